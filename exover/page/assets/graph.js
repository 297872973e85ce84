"use strict";
// Who excludes whom, launches whom and wakes whom.

const MOST_EDGES = 100;
const DIRECTED = ["interrupts", "constrains", "launches", "wakes", "sets"];

function graphPart({ report }) {
  const { nodes, edges } = report.graph;
  const kinds = [...new Set(edges.map(({ kind }) => kind))];
  const shown = new Set(kinds.filter((kind) => ["excludes", "interrupts", "shares", "launches"].includes(kind)));
  const body = el("div");
  let centre = "";
  const draw = () => replace(body, ...graphView(nodes, edges.filter(({ kind }) => shown.has(kind)), centre, focus));
  const focus = (id) => go("graph", id);
  const boxes = kinds.map((kind) =>
    el("label", { class: `kind ${kind}` },
      el("input", { type: "checkbox", checked: shown.has(kind), onchange: (event) => {
        if (event.target.checked) shown.add(kind);
        else shown.delete(kind);
        draw();
      } }), kind));
  const choices = [["", "everything"], ...nodes.map(({ id }) => [id, id])];
  const select = choice(choices, "", focus);
  const part = el(
    "div",
    {},
    el("p", {}, "What requests do to each other, with the rules that make it so. A dashed line depends on arguments or ",
      "readings. Pick a box to see it and its neighbours alone."),
    el("div", { class: "controls" }, labelled("around", select), el("fieldset", {}, el("legend", {}, "lines"), boxes)),
    body,
  );
  const show = (id) => {
    centre = nodes.some((node) => node.id === id) ? id : "";
    select.value = centre;
    draw();
  };
  return { part, show };
}

function graphView(nodes, edges, centre, focus) {
  const near = centre ? edges.filter(({ from, to }) => from === centre || to === centre) : edges;
  const met = new Set([centre, ...near.flatMap(({ from, to }) => [from, to])]);
  const boxes = nodes.filter(({ id }) => met.has(id));
  const rows = near.map(({ from, kind, sometimes, to, rules }) => [
    from, sometimes ? `may be: ${kind}` : kind, to, kind === "shares" ? rules.join(", ") : commas(rules.map(ruleLink)),
  ]);
  const list = el("details", { open: near.length > MOST_EDGES }, el("summary", {}, `as a table (${rows.length} lines)`),
    table(["from", "line", "to", "by"], rows));
  if (!near.length) return [el("p", {}, "There is nothing of this kind.")];
  if (near.length > MOST_EDGES) {
    return [el("p", {}, `${near.length} lines are too many to be seen at once: choose what to look around, or fewer kinds.`), list];
  }
  const itself = new Map(near.filter(({ from, to }) => from === to).map(({ from, kind }) => [from, ` (${kind} itself)`]));
  const drawn = drawing(
    boxes.map(({ id, kind, name }) => ({
      id, text: name + (itself.get(id) ?? ""), kind: `${kind === "request" ? "request" : "reading"}${id === centre ? " lit" : ""}`, title: id,
    })),
    near.filter(({ from, to }) => from !== to).map(({ from, to, kind, sometimes, rules, text }) => ({
      from, to, kind: `${kind}${sometimes ? " sometimes" : ""}`, undirected: !DIRECTED.includes(kind),
      text: rules.length > 1 ? `${rules[0]} +${rules.length - 1}` : rules[0], title: text,
    })),
    { direction: "LR", describe: `graph of ${boxes.length} boxes and ${near.length} lines; the table below it says the same`, onpick: focus },
  );
  return [frame(drawn), list];
}
