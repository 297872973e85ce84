"use strict";
// The page of a report, made anew of the spec in an editor whenever it changes.

const PAUSE = 400;
const PATIENCE = 30000;
const UNSTARTED = "Python could not be started";

/**
 * Python in a worker: what takes too long is ended, and a new one begun; one that fails is begun anew by the next call.
 * It may take any time to be loaded.
 */
class Python {
  constructor() {
    this.begin();
  }

  begin() {
    this.calls = new Map();
    this.isReady = false;
    this.worker = new Worker("worker.js");
    this.worker.onmessage = ({ data }) => this.heard(data);
    this.worker.onerror = ({ message }) => this.end(`${UNSTARTED}: ${message ?? "worker.js cannot be loaded"}`);
  }

  /** Return what a function of exover.playground returns; throws an `Error` with the reason if it does not. */
  call(name, ...args) {
    if (!this.worker) this.begin();
    return new Promise((resolve, reject) => {
      const id = crypto.randomUUID();
      this.calls.set(id, { resolve, reject });
      if (this.isReady) this.watch(id);
      this.worker.postMessage({ id, call: name, args });
    });
  }

  /** End all if a call is not answered in time. */
  watch(id) {
    const late = () => {
      this.end("this takes too long for the playground: use exover check");
      this.begin();
    };
    this.calls.get(id).late = setTimeout(late, PATIENCE);
  }

  heard({ ready, failed, id, result, error }) {
    if (failed) return this.end(`${UNSTARTED}: ${failed}`);
    if (ready) {
      this.isReady = true;
      for (const each of this.calls.keys()) this.watch(each);
      return;
    }
    if (!this.calls.has(id)) return;
    const { resolve, reject, late } = this.calls.get(id);
    this.calls.delete(id);
    clearTimeout(late);
    if (error) reject(new Error(error));
    else resolve(result);
  }

  end(reason) {
    this.worker?.terminate();
    this.worker = null;
    for (const { reject, late } of this.calls.values()) {
      clearTimeout(late);
      reject(new Error(reason));
    }
    this.calls.clear();
  }
}

/** The editor: a text, what is wrong with it, and the page of the last text without mistakes. */
class Editor {
  constructor() {
    this.python = new Python();
    this.text = el("textarea", { spellcheck: "false", "aria-label": "spec", rows: 16, oninput: () => this.soon() });
    this.status = el("p", { role: "status", class: "status" }, "Python is being loaded …");
    this.mistakes = el("pre", { class: "mistakes", role: "alert", hidden: true });
    const node = el("section", { id: "editor", "aria-label": "editor" }, this.text, this.status, this.mistakes);
    document.querySelector("nav").before(node);
  }

  soon() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.read(), PAUSE);
  }

  /** Show the page of the text as it is now, or what is wrong with it. */
  async read() {
    if (this.isBusy) return this.soon();
    this.isBusy = true;
    const text = this.text.value;
    try {
      this.show(text, await this.python.call("look", text));
    } catch (error) {
      this.status.textContent = error.message;
    } finally {
      this.isBusy = false;
    }
  }

  show(text, { mistakes, report }) {
    this.mistakes.textContent = mistakes;
    this.mistakes.hidden = !mistakes;
    this.status.textContent = report ? "no mistakes" : "the page below is that of the last text without mistakes";
    if (!report) return;
    const lines = page ? page.simulator.told("line") : [];
    begin(report);
    page.simulator.onchange = () => this.compare(text, page.simulator);
    page.simulator.restart(lines);
    page.simulator.play(Infinity);
  }

  /** Say what the reference interpreter answers to the events of the simulator. */
  async compare(text, simulator) {
    const [lines, told] = [simulator.told("line"), simulator.told("answer")];
    simulator.aside.textContent = "";
    if (!lines.length) return;
    try {
      const answers = await this.python.call("answer", text, JSON.stringify(lines));
      if (lines.length !== simulator.told("line").length) return;
      const wrong = answers.findIndex((answer, k) => answer !== told[k] && !told[k].includes('"invalid"'));
      simulator.aside.textContent = wrong < 0
        ? `The reference interpreter answers the same: ${answers.length} of ${answers.length}.`
        : `The reference interpreter answers otherwise, please report it: ${answers[wrong]}`;
    } catch (error) {
      simulator.aside.textContent = error.message;
    }
  }

  async open(address) {
    this.text.value = await (await fetch(address)).text();
    await this.read();
  }
}

dress();
document.querySelector("footer").append(el("p", {}, "Python runs here by Pyodide 0.29.5, MPL 2.0."));
document.getElementById("title").textContent = "exover playground";
const editor = new Editor();
editor.open("example.exo");
