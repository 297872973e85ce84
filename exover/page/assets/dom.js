"use strict";
// Elements from data: all texts become text nodes, so nothing in a spec is ever read as HTML.

const SVG = "http://www.w3.org/2000/svg";

/** Return an element of HTML; attributes `on…` are listeners, those that are false, null or undefined are left out. */
function el(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** Return an element of SVG. */
function svg(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

function filled(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat(2).filter((child) => child !== null && child !== undefined && child !== ""));
  return node;
}

function button(label, onclick, attributes = {}) {
  return el("button", { type: "button", onclick, ...attributes }, label);
}

/** Return a word in a coloured box; the word says what the colour says. */
function badge(word) {
  return el("span", { class: `badge ${word.replaceAll(" ", "-")}` }, word);
}

/** Return a table with a heading row; rows are lists of cells. */
function table(headings, rows, attributes = {}) {
  return el(
    "div",
    { class: "scroll", tabindex: 0, role: "group", "aria-label": attributes.caption ?? "table" },
    el(
      "table",
      attributes,
      attributes.caption ? el("caption", {}, attributes.caption) : null,
      el("thead", {}, el("tr", {}, headings.map((heading) => el("th", { scope: "col" }, heading)))),
      el("tbody", {}, rows.map((row) => el("tr", {}, row.map((cell) => el("td", {}, cell))))),
    ),
  );
}

/** Return a control with its label. */
function labelled(label, control) {
  return el("label", { class: "field" }, el("span", {}, label), control);
}

/** Return a choice among values; `choices` are pairs of a value and what is shown. */
function choice(choices, value, onchange, attributes = {}) {
  const options = choices.map(([each, shown]) => el("option", { value: each, selected: each === value }, shown));
  return el("select", { onchange: (event) => onchange(event.target.value), ...attributes }, options);
}

/** Return a link to a part of the page. */
function link(part, ...children) {
  return el("a", { href: `#${part}` }, ...children);
}

function replace(node, ...children) {
  node.replaceChildren(...children.flat(2).filter((child) => child !== null && child !== undefined));
}
