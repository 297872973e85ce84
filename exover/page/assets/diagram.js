"use strict";
// The diagram of one event or question: tests, actions, and the rule behind each.

const MOST_NODES = 120;

/** Draws the diagrams of the tables; `names` says what their nodes ask and do. */
class Diagrams {
  constructor(tables, names) {
    this.tables = tables;
    this.names = names;
  }

  /** Return what a node asks or does. */
  text(node) {
    return this.names.texts[this.names.nodes[node]];
  }

  /** Return the rule behind an action node; null of a test, and of what no rule demands. */
  rule(node) {
    const { code, bound } = this.tables.nodes[node];
    return code < 0 && !["launch", "agree"].includes(ACTIONS[-code]) ? this.names.reasons[Number(bound)] : null;
  }

  kind(node) {
    const { code } = this.tables.nodes[node];
    return code < 0 ? `action ${ACTIONS[-code]}` : "test";
  }

  /** Return the edges out of a node, as pairs of a node and what is written on the edge. */
  children(node) {
    const { code, low, high } = this.tables.nodes[node];
    return code < 0 ? [[low, ""]] : [[low, "yes"], [high, "no"]];
  }

  /** Return the nodes below a root, nearest first, at most so many. */
  below(root, most = Infinity) {
    const found = new Set(root < 0 ? [] : [root]);
    for (const node of found) {
      for (const [child] of this.children(node)) if (child >= 0 && found.size < most) found.add(child);
    }
    return [...found];
  }

  /**
   * Return the drawing of what is below a root, of a large diagram the `most` nearest nodes and those of `path`, which is
   * lit; `onpick` is told of a node that is picked.
   */
  draw(root, path, onpick, most = MOST_NODES) {
    const shown = new Set([...path, ...this.below(root, most)]);
    const lit = new Set(path);
    const steps = new Set(path.map((node, k) => `${node} ${path[k + 1] ?? NONE}`));
    const nodes = [...shown].map((node) => ({
      id: String(node),
      text: this.text(node),
      kind: `${this.kind(node)}${lit.has(node) ? " lit" : ""}`,
      label: `node ${node}: ${this.text(node)}${lit.has(node) ? ", on the path" : ""}`,
      title: this.rule(node)?.because ? `${this.text(node)}: ${this.rule(node).because}` : undefined,
    }));
    const edges = [...shown].flatMap((node) =>
      this.children(node).map(([child, text]) => this.edge(node, child, text, shown, steps)),
    );
    for (const end of new Set(edges.map(({ to }) => to).filter((to) => to.includes(" ")))) {
      const [word, node] = end.split(" ");
      nodes.push({ id: end, text: word === "more" ? "…" : "", kind: "end", title: word === "more" ? `more from node ${node}` : "end" });
    }
    const describe = `diagram of ${shown.size} nodes; the table below it says the same`;
    return drawing(nodes, edges, { direction: "TB", describe, onpick: (id) => onpick(Number(id.replace("more ", ""))) });
  }

  edge(node, child, text, shown, steps) {
    const isLit = steps.has(`${node} ${child}`);
    const to = child < 0 ? `end ${node}` : shown.has(child) ? String(child) : `more ${child}`;
    return { from: String(node), to, text, kind: `${text || "then"}${isLit ? " lit" : ""}` };
  }

  /** Return the nodes as a table, for those who read it by ear or by line. */
  outline(root, path) {
    const lit = new Set(path);
    const target = (node) => (node < 0 ? "end" : link(this.anchor(root, node), `node ${node}`));
    const rows = this.below(root).map((node) => {
      const { code, low, high } = this.tables.nodes[node];
      const rule = this.rule(node);
      return [
        String(node),
        lit.has(node) ? el("mark", {}, this.text(node)) : this.text(node),
        code < 0 ? ["then ", target(low)] : ["yes: ", target(low), ", no: ", target(high)],
        rule && rule.rule !== "busy" ? [ruleLink(rule.rule), rule.because ? ` ${rule.because}` : ""] : "",
      ];
    });
    return el(
      "details",
      {},
      el("summary", {}, `as a table (${rows.length} nodes)`),
      table(["node", "test or action", "goes on", "rule"], rows),
    );
  }

  anchor(root, node) {
    return `diagrams/${encodeURIComponent(this.labelOf(root))}/${node}`;
  }

  /** Return the event or question whose diagram begins at a root; of several the one that is called so, or so and a number. */
  labelOf(root, called = "") {
    const found = this.names.roots.filter(({ node }) => node === root);
    return (found.find(({ label }) => label.startsWith(called)) ?? found[0])?.label ?? String(root);
  }

  /** Return the events and questions in whose diagrams an action names this rule, or which ask whether it launches. */
  uses(rule) {
    return this.names.roots.filter(({ label, node }) =>
      label === `launch ${rule}` || this.below(node).some((each) => this.rule(each)?.rule === rule));
  }
}

/** Return the part of the page with a diagram to choose. */
function diagramsPart({ diagrams }) {
  const body = el("div");
  const { roots } = diagrams.names;
  let chosen = roots[0];
  const select = choice(roots.map(({ label }) => [label, label]), chosen?.label, (label) => go("diagrams", label), {});
  const show = (label, node) => {
    chosen = roots.find((each) => each.label === label) ?? chosen;
    if (!chosen) return;
    select.value = chosen.label;
    const root = node === undefined ? chosen.node : Number(node);
    replace(body, ...diagramView(diagrams, chosen, root));
  };
  const part = el(
    "div",
    {},
    el("p", {}, "Each event has its own diagram in the tables: tests lead to actions. A full line is taken if the test ",
      "holds, a dashed one if not. Pick a node to see what is below it alone."),
    el("div", { class: "controls" }, labelled("event or question", select)),
    body,
  );
  return { part, show };
}

function diagramView(diagrams, { label, node }, root) {
  if (node < 0) return [el("p", {}, node === ALWAYS ? `${label}: always.` : `${label}: never.`)];
  const top = root === node ? null : el("p", {}, link(`diagrams/${encodeURIComponent(label)}`, "back to the whole diagram"));
  const pick = (picked) => go("diagrams", label, picked);
  const rules = new Map(
    diagrams.below(root).map((each) => diagrams.rule(each)).filter((rule) => rule && rule.rule !== "busy").map((rule) => [rule.rule, rule]),
  );
  const total = diagrams.below(root).length;
  const cut = total > MOST_NODES ? `, of which the first ${MOST_NODES} are drawn: pick … for what is below` : "";
  return [
    el("h3", {}, root === node ? label : `${label}, from node ${root}`),
    el("p", {}, `${total} nodes${cut}. `, rules.size ? ["Rules behind its actions: ", commas([...rules.keys()].map(ruleLink)), "."] : ""),
    top,
    frame(diagrams.draw(root, [], pick)),
    diagrams.outline(root, []),
  ];
}

function commas(items) {
  return items.flatMap((item, k) => (k ? [", ", item] : [item]));
}

function ruleLink(rule) {
  return link(`rules/${encodeURIComponent(rule)}`, rule);
}
