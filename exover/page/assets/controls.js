"use strict";
// The events of a spec as forms and buttons, made of the types that stand in the tables.

/** Forms for everything that the environment can do; what is active has buttons of its own. */
class EventControls {
  constructor(simulator) {
    this.simulator = simulator;
    const { names, tables } = simulator.page;
    this.names = names;
    this.wire = new Wire(tables, names);
    this.active = names.requests.map(() => el("div", { class: "active" }));
    this.node = el(
      "div",
      { class: "events" },
      names.requests.map((_, k) => this.request(k)),
      [...this.wire.variables].map(([name, k]) => this.reading(name, this.wire.variableKind(k))),
      [...this.wire.stocks].map(([name, k]) => this.reading(name, this.wire.stockKind(k))),
    );
  }

  send(pairs) {
    this.simulator.send(objectJson(pairs));
  }

  request(k) {
    const { name, params } = this.names.requests[k];
    const fields = params.map((param, number) => this.field(param.name, this.wire.paramKind(k, number)));
    const ask = (event) => {
      event.preventDefault();
      this.send([["ask", quoted(name)], ["args", written(fields)]]);
    };
    return el(
      "fieldset",
      { "data-request": name },
      el("legend", {}, name),
      el("form", { class: "controls", onsubmit: ask }, fields.map(({ node }) => node), el("button", { type: "submit" }, "ask")),
      this.active[k],
    );
  }

  reading(name, kind) {
    const field = this.field("value", kind);
    const observe = (event) => {
      event.preventDefault();
      this.send([["observe", quoted(name)], ["value", field.json()]]);
    };
    return el("fieldset", { "data-reading": name }, el("legend", {}, name),
      el("form", { class: "controls", onsubmit: observe }, field.node, el("button", { type: "submit" }, "observe")));
  }

  /** Return a control for a value, and what it says as JSON: numbers go as they are written. */
  field(name, kind) {
    const { type, low, high, values, domain } = kind;
    if (type === TYPES.BOOL || type === TYPES.ENUM) {
      const words = type === TYPES.BOOL ? ["false", "true"] : values;
      const control = choice(words.map((word) => [word, word]), words[0], () => {});
      return { name, node: labelled(name, control), json: () => (type === TYPES.BOOL ? control.value : quoted(control.value)) };
    }
    const zero = type === TYPES.REAL ? 0 : 0n;
    const start = low <= zero && zero <= high ? zero : low;
    const control = el("input", { type: "text", inputmode: "decimal", value: plainText(start), title: domain, size: 8 });
    const json = () => (/^-?(0|[1-9]\d*)(\.\d+)?([eE][+-]?\d+)?$/.test(control.value.trim()) ? control.value.trim() : quoted(control.value));
    return { name, node: labelled(`${name} (${domain})`, control), json };
  }

  /** Show the buttons for what is active and what waits. */
  update({ slots, places }) {
    const lost = this.node.contains(document.activeElement) ? document.activeElement.closest("fieldset") : null;
    this.active.forEach((node, k) => {
      const running = slots[k].flatMap(({ phase }, slot) => (phase === "idle" ? [] : [this.slot(k, slot, phase)]));
      const waits = places[k].phase === "empty" ? null : this.waiting(k, places[k].phase);
      replace(node, ...running, waits);
    });
    if (lost && !lost.contains(document.activeElement)) lost.querySelector("[type=submit]").focus();
  }

  slot(k, slot, phase) {
    const { name, results, statuses } = this.names.requests[k];
    const { params } = this.names.requests[k];
    const fields = results.map((result, number) => this.field(result.name, this.wire.paramKind(k, params.length + number)));
    const report = (outcome, more = []) => this.send([["report", quoted(name)], ["instance", String(slot)], ["outcome", quoted(outcome)], ...more]);
    const failures = statuses.length ? statuses : [null];
    return el(
      "div",
      { class: "controls" },
      badge(phase), ` [${slot}]`,
      fields.map(({ node }) => node),
      button("ok", () => report("ok", results.length ? [["results", written(fields)]] : [])),
      failures.map((status) => button(status ? `failed: ${status}` : "failed", () => report("failed", [["status", quoted(status)]]))),
      button("interrupted", () => report("interrupted")),
      button("abort", () => this.send([["abort", quoted(name)], ["instance", String(slot)]])),
    );
  }

  waiting(k, phase) {
    const name = quoted(this.names.requests[k].name);
    return el("div", { class: "controls" }, badge(phase), button("give up", () => this.send([["abort", name], ["waiting", "true"]])));
  }
}

function written(fields) {
  return objectJson(fields.map(({ name, json }) => [name, json()]));
}
