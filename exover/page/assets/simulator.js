"use strict";
// The tables walked by hand: events are clicked, typed or loaded; state, answers and paths are shown.

const MOST_EVENTS = 10000;
const MOST_HISTORY = 200;
const SMALL_DIAGRAM = 40;

/** A run that grows by events of the reader's. */
class Simulator {
  constructor(page) {
    this.page = page;
    this.words = new Words(page.tables, page.names);
    this.controls = new EventControls(this);
    this.message = el("p", { class: "message", role: "status" });
    this.waiting = [];
    this.aside = el("p", { class: "aside", role: "status" });
    this.onchange = () => {};
    this.views = Object.fromEntries(["answers", "paths", "state", "history"].map((name) => [name, el("div", { class: name })]));
    this.views.answers.setAttribute("aria-live", "polite");
    this.restart();
  }

  restart(lines = []) {
    this.run = new Run(this.page.tables, this.page.names);
    this.waiting = lines;
    this.select(0);
  }

  /** Answer the event of a line. */
  send(line) {
    this.run.step(line);
    this.select(this.run.moments.length - 1);
  }

  undo() {
    const lines = this.run.moments.slice(1, -1).map(({ line }) => line);
    const waiting = this.waiting;
    this.restart();
    for (const line of lines) this.run.step(line);
    this.waiting = waiting;
    this.select(lines.length);
  }

  /** Answer so many of the events that were loaded. */
  play(count) {
    for (const line of this.waiting.splice(0, count)) this.run.step(line);
    this.select(this.run.moments.length - 1);
  }

  /** Begin anew with the lines of events, which wait to be played. */
  load(lines, name) {
    const written = lines.filter(isWritten);
    if (written.length > MOST_EVENTS) {
      this.say(`${name} has ${written.length} events, and the page takes ${MOST_EVENTS}: use exover simulate`);
      return;
    }
    this.restart(written);
    this.say(`${name}: ${written.length} events are loaded; play them one by one or all at once`);
  }

  async loadFile(file) {
    if (!file) return;
    try {
      const text = new TextDecoder("utf-8", { fatal: true }).decode(await file.arrayBuffer());
      this.load(text.split("\n"), file.name);
    } catch (error) {
      this.say(`${file.name} cannot be read: ${error instanceof TypeError ? "it is not UTF-8" : error.message}`);
    }
  }

  save(name, lines) {
    const url = URL.createObjectURL(new Blob([lines.map((line) => `${line}\n`).join("")], { type: "application/jsonl" }));
    el("a", { href: url, download: `${this.page.report.spec}.${name}.jsonl` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }

  say(text) {
    this.message.textContent = text;
  }

  /** Show a moment of the run. */
  select(moment) {
    this.at = moment;
    this.say("");
    const { run, views } = this;
    const shown = run.moments[moment];
    replace(views.answers, ...momentText(run, moment));
    replace(views.paths, ...this.paths(shown));
    replace(views.state, ...stateView(this.words, shown.state));
    replace(views.history, this.history());
    this.controls.update(run.last.state);
    this.onchange();
  }

  history() {
    const first = Math.max(0, this.run.moments.length - MOST_HISTORY);
    const items = this.run.moments.slice(first).map(({ event, actions }, k) => {
      const at = first + k;
      const kinds = actions.map((action) => badge(actionKind(action)));
      return el("li", { value: at }, button(event ? this.words.event(event) : "the start", () => this.select(at), {
        "aria-current": at === this.at ? "step" : null,
      }), " ", kinds);
    });
    return el("ol", { reversed: false }, items.reverse());
  }

  /** Return the walks of a step: each diagram with the path that was taken in it. */
  paths({ walks }) {
    const { diagrams } = this.page;
    const found = new Map(walks.map((walk) => [`${walk.label} ${walk.path}`, walk])).values();
    const told = [...found].filter(({ path }) => path.length);
    if (!told.length) return [el("p", {}, "No diagram was asked.")];
    const speaks = ({ path }) => path.some((node) => diagrams.rule(node) || diagrams.kind(node).includes("launch"));
    const body = el("div");
    const show = (k) => replace(body, ...pathView(diagrams, told[k]));
    const first = Math.max(0, told.findIndex(speaks));
    show(first);
    const select = choice(told.map(({ label, root }, k) => [String(k), diagrams.labelOf(root, label)]), String(first), (k) => show(Number(k)));
    return [el("div", { class: "controls" }, labelled("diagram", select)), body];
  }

  part() {
    const file = el("input", { type: "file", accept: ".jsonl,.json,.txt", "aria-label": "load events", onchange: (event) => this.loadFile(event.target.files[0]) });
    const line = el("input", { type: "text", class: "line", spellcheck: "false", placeholder: '{"ask": "MODULE.REQUEST", "args": {}}' });
    const typed = (event) => {
      event.preventDefault();
      if (isWritten(line.value)) this.send(line.value);
    };
    const { answers, paths, state, history } = this.views;
    return el(
      "div",
      {},
      el("p", {}, "These are the bytes of the emitted tables, walked in this page. Click an event and see what they answer."),
      el("details", { open: innerWidth > 768 },
        el("summary", {}, "load, save, or type events"),
        el("div", { class: "controls" },
          labelled("load events", file), button("play one", () => this.play(1)), button("play all", () => this.play(Infinity)),
          button("save events", () => this.save("events", this.told("line"))),
          button("save answers", () => this.save("answers", this.told("answer")))),
        el("form", { class: "controls", onsubmit: typed }, labelled("event as a JSON line", line), el("button", { type: "submit" }, "send"))),
      this.message,
      el("div", { class: "simulator" },
        el("section", { class: "said" }, el("h3", {}, "Answer ", button("undo", () => this.undo()), " ", button("restart", () => this.restart())), answers, this.aside),
        el("section", { class: "asks" }, el("h3", {}, "Events"), this.controls.node),
        el("div", { class: "shows" },
          el("section", {}, el("h3", {}, "Path through the diagram"), paths),
          el("section", {}, el("h3", {}, "State"), state),
          el("section", {}, el("h3", {}, "History"), history))),
    );
  }

  /** Return the lines of the events, or of the answers, from the first on. */
  told(which) {
    return this.run.moments.slice(1).map((moment) => moment[which]);
  }
}

/** Return a diagram with a path in it, and the path in words. */
function pathView(diagrams, { label, root, path }) {
  const most = diagrams.below(root).length <= SMALL_DIAGRAM ? MOST_NODES : 0;
  const picture = diagrams.draw(root, path, (node) => go("diagrams", diagrams.labelOf(root), node), most);
  const steps = path.map((node, k) => {
    const { code, low } = diagrams.tables.nodes[node];
    const rule = diagrams.rule(node);
    const answer = code < 0 ? "" : path[k + 1] === low ? ": yes" : ": no";
    return el("li", {}, diagrams.text(node), answer, rule?.because ? [" ", el("q", {}, rule.because)] : "");
  });
  return [
    frame(picture),
    el("details", {}, el("summary", {}, `the path in words (${path.length} nodes)`), el("ol", {}, steps)),
    el("p", {}, link(`diagrams/${encodeURIComponent(diagrams.labelOf(root, label))}`, "the whole diagram")),
  ];
}

/** Return what the checker holds. */
function stateView(words, { slots, places, last, pasts, readings, levels }) {
  const { names } = words;
  const requests = names.requests.map((request, k) => {
    const held = slots[k].map(({ phase, args }, slot) => {
      const shown = phase === "idle" ? "" : ` ${words.args(k, args)}`;
      return el("span", { class: "held" }, slots[k].length > 1 ? `[${slot}] ` : "", badge(phase), shown);
    });
    const place = places[k].phase === "empty" ? "" : [badge(places[k].phase), ` ${words.args(k, places[k].args)}`];
    const ended = pasts[k] === null ? "" : words.args(k, pasts[k], [...request.params, ...request.results]) || "ok";
    return [request.name, held, place, ended, last[k] ?? ""];
  });
  const read = [
    ...names.variables.map(({ name }, k) => [name, plainText(readings[k])]),
    ...names.stocks.map(({ name }, k) => [`level(${name})`, levels[k] === null ? "no rule reads it" : plainText(levels[k])]),
  ];
  return [
    table(["request", "slots", "waiting place", "past", "last"], requests, { caption: "requests" }),
    read.length ? table(["reading", "value"], read, { caption: "readings and levels" }) : null,
  ];
}
