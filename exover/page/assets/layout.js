"use strict";
// Boxes and arrows, laid out by dagre.

const LETTER = 7.3;
const LONGEST_LABEL = 44;

/** Return a text that is short enough for a box. */
function shortened(text) {
  return text.length > LONGEST_LABEL ? `${text.slice(0, LONGEST_LABEL - 1)}…` : text;
}

/**
 * Return a drawing in which nodes `{id, text, kind}` and edges `{from, to, text, kind}` stand in layers.
 *
 * `describe` is what those who do not see are told of it; `onpick` is called with the id of a node that is picked.
 */
function drawing(nodes, edges, { direction, describe, onpick }) {
  const graph = new dagre.graphlib.Graph({ multigraph: true });
  graph.setGraph({ rankdir: direction, nodesep: 18, ranksep: 34, edgesep: 8, marginx: 8, marginy: 8 });
  graph.setDefaultEdgeLabel(() => ({}));
  for (const { id, text } of nodes) {
    const width = text ? LETTER * shortened(text).length + 20 : 12;
    graph.setNode(id, { width, height: text ? 30 : 12 });
  }
  edges.forEach(({ from, to, text }, k) => {
    graph.setEdge(from, to, { width: text ? LETTER * shortened(text).length : 0, height: text ? 14 : 0, labelpos: "c" }, `e${k}`);
  });
  dagre.layout(graph);
  const { width, height } = graph.graph();
  return svg(
    "svg",
    { viewBox: `0 0 ${width} ${height}`, width, height, role: "group", "aria-label": describe },
    svg("defs", {}, ["plain", "lit"].map(arrowhead)),
    edges.map((edge, k) => drawnEdge(edge, graph.edge(edge.from, edge.to, `e${k}`))),
    nodes.map((node) => drawnNode(node, graph.node(node.id), onpick)),
  );
}

function arrowhead(name) {
  const shape = svg("path", { d: "M0 0L8 4L0 8z", class: `head ${name}` });
  return svg("marker", { id: name, viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 9, markerHeight: 9, markerUnits: "userSpaceOnUse", orient: "auto" }, shape);
}

function drawnEdge({ kind, text, title, from, to, undirected }, { points, x, y }) {
  const path = points.map((point, k) => `${k ? "L" : "M"}${point.x.toFixed(1)} ${point.y.toFixed(1)}`).join("");
  const head = undirected ? null : `url(#${kind.includes("lit") ? "lit" : "plain"})`;
  return svg(
    "g",
    { class: `edge ${kind}`, "data-from": from, "data-to": to },
    title ? svg("title", {}, title) : null,
    svg("path", { d: path, "marker-end": head }),
    text ? svg("text", { x, y: y + 4, "text-anchor": "middle" }, shortened(text)) : null,
  );
}

function drawnNode({ id, text, kind, title, label }, { x, y, width, height }, onpick) {
  const picks = onpick && text;
  const attributes = picks ? { tabindex: 0, role: "button", "aria-label": label ?? title ?? text } : {};
  if (picks) {
    attributes.onclick = () => onpick(id);
    attributes.onkeydown = (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      onpick(id);
    };
  }
  const round = kind.includes("test") || kind.includes("reading") ? 15 : 4;
  return svg(
    "g",
    { class: `node ${kind}`, "data-id": id, transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})`, ...attributes },
    svg("title", {}, title ?? text),
    text
      ? svg("rect", { x: -width / 2, y: -height / 2, width, height, rx: round })
      : svg("circle", { r: 5 }),
    text ? svg("text", { y: 4, "text-anchor": "middle" }, shortened(text)) : null,
  );
}

/** Return a frame in which a drawing is moved by scrolling, with buttons for its size. */
function frame(picture) {
  const width = Number(picture.getAttribute("width"));
  const height = Number(picture.getAttribute("height"));
  const view = el("div", { class: "canvas", tabindex: 0, role: "group", "aria-label": "drawing, to be scrolled" }, picture);
  let scale = 1;
  const sized = (factor) => {
    scale = Math.min(Math.max(factor, 0.1), 3);
    picture.setAttribute("width", width * scale);
    picture.setAttribute("height", height * scale);
  };
  const fit = () => sized(Math.min(1, (view.clientWidth - 4) / width));
  const tools = el(
    "div",
    { class: "tools" },
    button("fit", fit, { title: "as wide as the page" }),
    button("+", () => sized(scale * 1.25), { "aria-label": "larger" }),
    button("−", () => sized(scale / 1.25), { "aria-label": "smaller" }),
    button("1:1", () => sized(1)),
  );
  requestAnimationFrame(() => {
    sized(Math.min(1, Math.max((view.clientWidth - 4) / width, 0.55)));
    const first = picture.querySelector(".node").getBoundingClientRect();
    view.scrollLeft += first.left + first.width / 2 - view.getBoundingClientRect().left - view.clientWidth / 2;
  });
  return el("div", { class: "frame" }, tools, view);
}
