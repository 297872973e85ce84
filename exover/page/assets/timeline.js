"use strict";
// A run as a timeline that steps: a lane for each request and reading, a column for each moment.

/** Return the lanes of a run: everything that is not idle all the time, or was observed. */
function lanesOf(run) {
  const { moments, names } = run;
  const marks = moments.map((moment) => marksOf(moment, names));
  const lanes = [{ name: "checker", rows: [], isValue: false }];
  names.requests.forEach(({ name }, k) => lanes.push({ name, isValue: false, rows: requestRows(moments, k) }));
  names.variables.forEach(({ name }, k) => {
    lanes.push({ name, isValue: true, rows: changing("", moments.map(({ state }) => plainText(state.readings[k]))) });
  });
  names.stocks.forEach(({ name }, k) => {
    lanes.push({ name, isValue: true, rows: changing("", moments.map(({ state }) => plainText(state.levels[k] ?? ""))) });
  });
  // A poster may have the name of a request.
  const stands = (mark, lane) => mark.lane === lane.name && (mark.kind === "observe") === lane.isValue;
  for (const lane of lanes) lane.marks = marks.map((found) => found.filter((mark) => stands(mark, lane)));
  return lanes.filter((lane) => lane.rows.length || lane.marks.some((found) => found.length));
}

function requestRows(moments, request) {
  const { slots } = moments[0].state;
  const rows = slots[request].map((_, slot) => ({
    label: slots[request].length > 1 ? `[${slot}]` : "",
    cells: moments.map(({ state }) => state.slots[request][slot].phase.replace("idle", "")),
  }));
  rows.push({ label: "place", cells: moments.map(({ state }) => state.places[request].phase.replace("empty", "")) });
  return rows.filter(({ cells }) => cells.some((cell) => cell));
}

function changing(label, cells) {
  return new Set(cells).size > 1 ? [{ label, cells }] : [];
}

function marksOf({ event, actions }, names) {
  if (!event) return [];
  return [eventMark(event, names), ...actions.map((action) => actionMark(action, names))];
}

function eventMark({ kind, invalid, request, variable, stock, outcome }, names) {
  if (invalid) return { lane: "checker", kind: "event", text: "event" };
  if (kind === "observe") {
    return { lane: (variable === undefined ? names.stocks[stock] : names.variables[variable]).name, kind, text: "observed" };
  }
  const text = kind === "report" ? outcome : kind === "withdraw" ? "abort" : kind;
  return { lane: names.requests[request].name, kind, text };
}

function actionMark(action, names) {
  const kind = actionKind(action);
  if (kind === "violation" || kind === "invalid") return { lane: "checker", kind, text: `${kind} ${action[kind]}` };
  const why = kind === "launch" ? action.launchRule : action.rule;
  return { lane: names.requests[action[kind]].name, kind, text: why ? `${kind} ${why}` : kind };
}

/** A timeline of a run, with the moment that is looked at; `onselect` is told of it. */
class Timeline {
  constructor(run, { loopStart = null, onselect = () => {} } = {}) {
    this.run = run;
    this.loopStart = loopStart;
    this.onselect = onselect;
    this.lanes = lanesOf(run);
    this.slider = el("input", {
      type: "range", min: 0, max: run.moments.length - 1, value: 0, "aria-label": "moment of the run",
      oninput: (event) => this.select(Number(event.target.value)),
    });
    this.grid = this.drawn();
    this.detail = el("div", { class: "moment", "aria-live": "polite" });
    this.node = el(
      "div",
      { class: "timeline" },
      el("div", { class: "tools" },
        button("|◀", () => this.select(0), { "aria-label": "to the start" }),
        button("◀", () => this.select(this.at - 1), { "aria-label": "one step back" }),
        this.slider,
        button("▶", () => this.select(this.at + 1), { "aria-label": "one step on" }),
        button("▶|", () => this.select(run.moments.length - 1), { "aria-label": "to the end" })),
      this.grid,
      this.detail,
    );
    this.select(0);
  }

  drawn() {
    const heads = this.run.moments.map((_, k) =>
      el("th", { scope: "col", "data-moment": k, class: this.isLooped(k) ? "looped" : null },
        button(k ? String(k) : "start", () => this.select(k), { "aria-label": k ? `step ${k}` : "the start" })));
    return el(
      "div",
      { class: "scroll lanes", tabindex: 0, role: "group", "aria-label": "timeline; arrow keys step",
        onkeydown: (event) => this.key(event) },
      el("table", {},
        el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "lane"), heads)),
        el("tbody", {}, this.lanes.map((lane) => this.lane(lane)))),
    );
  }

  isLooped(k) {
    return this.loopStart !== null && k > this.loopStart;
  }

  lane({ name, rows, marks, isValue }) {
    const cells = this.run.moments.map((_, k) =>
      el("td", { "data-moment": k },
        rows.map(({ label, cells: texts }) => {
          const word = isValue ? "value" : texts[k] || "idle";
          return el("span", { class: `bar ${word}`, title: texts[k] || "idle" }, texts[k] ? [label, " ", texts[k]] : "\u00a0");
        }),
        marks[k].map(({ kind, text }) => el("span", { class: `mark ${kind}`, title: text }, text))));
    return el("tr", {}, el("th", { scope: "row" }, name), cells);
  }

  key(event) {
    const targets = { ArrowLeft: this.at - 1, ArrowRight: this.at + 1, Home: 0, End: this.run.moments.length - 1 };
    if (!(event.key in targets)) return;
    event.preventDefault();
    this.select(targets[event.key]);
  }

  /** Return the moment that is looked at, in words. */
  told() {
    const { event } = this.run.moments[this.at];
    return event ? `step ${this.at}: ${new Words(this.run.walker.tables, this.run.names).event(event)}` : "the start";
  }

  select(moment) {
    this.at = Math.min(Math.max(moment, 0), this.run.moments.length - 1);
    this.slider.value = this.at;
    this.slider.setAttribute("aria-valuetext", this.told());
    for (const cell of this.grid.querySelectorAll("[data-moment]")) {
      cell.classList.toggle("now", Number(cell.dataset.moment) === this.at);
    }
    const head = this.grid.querySelector(`th[data-moment="${this.at}"]`);
    this.grid.scrollLeft = Math.max(0, head.offsetLeft - this.grid.clientWidth / 2);
    replace(this.detail, ...momentText(this.run, this.at, this.loopStart));
    this.onselect(this.at);
  }
}

/** Return what happened in a step, in words. */
function momentText(run, at, loopStart = null) {
  const { event, actions, line } = run.moments[at];
  if (!event) return [el("p", {}, el("strong", {}, "The start: "), "nothing has been asked yet.")];
  const words = new Words(run.walker.tables, run.names);
  const again = loopStart !== null && at === run.moments.length - 1 ? el("p", {}, `And again from step ${loopStart + 1}, for ever.`) : null;
  return [
    el("p", {}, el("strong", {}, `Step ${at}: `), words.event(event)),
    event.invalid ? el("pre", {}, line) : null,
    el("ul", { class: "answers" }, actions.length ? actions.map((action) => el("li", {}, actionText(words, action))) : el("li", {}, "no answer")),
    again,
  ];
}

/** Return an action as elements, with a link to the rule that spoke. */
function actionText(words, action) {
  const rule = action.rule ?? action.violation;
  const known = rule && !["busy", "superseded", "aborted", "abort"].includes(rule);
  const why = action.because ? el("q", {}, action.because) : null;
  return [badge(actionKind(action)), " ", words.action(action), rule ? [" for ", known ? ruleLink(rule) : rule, " "] : "", why];
}
