"use strict";
// The tables at work, step for step what exover/ocrd/machine.py and the C runtime do (docs/runtime.md).

const BUSY = 0;

/** A checker that runs: what it does with an event, on what it holds. Answers are those of the reference interpreter. */
class Walker extends Memory {
  /** Return the actions that answer an event; `walks` are the paths that they come of. */
  step(event) {
    this.actions = [];
    this.walks = [];
    const fault = event.invalid ? event : this.validate(event);
    if (fault) return [fault];
    const { launches, requests, limits } = this.tables;
    this.tried = Array(launches.length).fill(false);
    this.refusing = Array(launches.length).fill(null);
    this.fallen = Array(requests.length).fill(false);
    this.update(event);
    this.changed = true;
    for (let pass = 0; this.changed; pass++) {
      if (pass === limits[0].passes) throw new Error("the bound on passes is wrong");
      this.changed = false;
      this.recover();
      this.launchRequired();
      this.settle();
    }
    this.refused = this.refusing;
    this.violations();
    return this.actions;
  }

  validate({ kind, request, slot }) {
    const { name } = this.names.requests[request] ?? {};
    if (kind === "withdraw" && this.place[request] === EMPTY) {
      return { invalid: "nothing-to-abort", detail: `nothing waits at ${name}` };
    }
    if ((kind === "report" || kind === "abort") && this.phase[this.tables.requests[request].slots + slot] === IDLE) {
      return { invalid: kind === "report" ? "not-active" : "nothing-to-abort", detail: `slot ${slot} of ${name} is idle` };
    }
    return null;
  }

  update(event) {
    switch (event.kind) {
      case "ask":
        return this.ask(event.request, event.args, null);
      case "report":
        return this.end(event);
      case "abort":
        return this.kill(event.request, event.slot, { rule: "abort" });
      case "withdraw":
        return this.vacate(event.request, { rule: "aborted" });
      default:
        return this.observe(event);
    }
  }

  observe({ variable, stock, value, broken }) {
    if (broken) this.actions.push({ invalid: "out-of-range", detail: broken });
    if (stock !== undefined) this.put(this.tables.stocks[stock].entry, value);
    else this.read(variable, value);
    this.latch(NONE);
  }

  // ---- decisions ----

  /** Return the actions of the decision; the second channel must agree where it can tell. */
  decide(request, args) {
    this.load(request, args);
    const path = this.watched(`ask ${this.names.requests[request].name}`, this.tables.requests[request].decide);
    const first = ACTIONS[-path[0].code];
    if (["reject", "wait", "clear"].includes(first)) {
      const { denials } = this.tables.reasons[Number(path[0].bound)];
      const told = denials === DENIALS.ALL || (denials === DENIALS.CLEARINGS && first === "clear");
      if (told && !this.inConflict(request)) throw new Error("only the diagrams see a conflict");
    }
    return path;
  }

  inConflict(request) {
    return this.conflicts[request].some((other) => this.held[other] > 0);
  }

  /** Handle an ask; `launch`: the number of the launch rule that raised it. */
  ask(request, args, launch) {
    const required = launch === null ? null : this.reason(this.tables.launches[launch].reason);
    const taken = this.place[request] !== EMPTY;
    if (taken && !this.tables.requests[request].interrupts_self) return this.refuse(request, BUSY, launch);
    const path = this.decide(request, args);
    if (ACTIONS[-path[0].code] === "reject") return this.refuse(request, Number(path[0].bound), launch);
    if (taken) this.sayRejected(request, { rule: "superseded" }, this.placeRule[request]);
    const waits = this.carryOut(request, args, path, required, required);
    if (waits) {
      this.placeRule[request] = required;
      this.actions.push({ wait: request, rule: waits.rule, because: waits.because, launchRule: required?.rule });
    }
  }

  reason(number) {
    return this.names.reasons[Number(number)];
  }

  /** Reject a newcomer; without a word if the last step refused this required launch for the same rule. */
  refuse(request, reason, launch) {
    if (launch !== null) {
      this.refusing[launch] = reason;
      if (this.refused[launch] === reason) return;
    }
    const required = launch === null ? null : this.reason(this.tables.launches[launch].reason);
    this.sayRejected(request, this.reason(reason), required);
  }

  /** Reject what stands in the waiting place. */
  vacate(request, reason) {
    this.setPlace(request, EMPTY, []);
    this.sayRejected(request, reason, this.placeRule[request]);
  }

  sayRejected(request, { rule, because }, required) {
    this.actions.push({ reject: request, rule, because, launchRule: required?.rule });
  }

  /** Do what a decision that is no rejection says; return what the newcomer waits for, if it does. */
  carryOut(request, args, path, required, launchRule) {
    let waits = null;
    for (const node of path) {
      const action = ACTIONS[-node.code];
      if (["wait", "clear", "settle"].includes(action)) {
        waits = this.reason(node.bound);
        this.setPlace(request, action === "wait" ? WAITING : CLEARING, args);
      } else if (action === "kill") {
        this.killTarget(node);
      } else if (action === "dismiss") {
        if (this.place[node.high] !== EMPTY) this.vacate(node.high, this.reason(node.bound));
      } else if (action === "launch") {
        this.launch(request, args, required, launchRule);
      }
    }
    return waits;
  }

  launch(request, args, required, launchRule) {
    const row = this.tables.requests[request];
    const slot = this.phase.slice(row.slots, row.slots + row.instances).indexOf(IDLE);
    if (this.inConflict(request)) throw new Error("only the bit rows see a conflict");
    this.held[request] += 1;
    this.setPlace(request, EMPTY, []);
    for (const amount of this.counting(request, args, row.consumes, row.produces)) {
      this.add(this.tables.stocks[amount.stock].entry, -amount.amount);
    }
    this.setSlot(request, slot, RUNNING, args);
    this.affect(row.on_launch, row.on_ok);
    const { rule, because } = required ?? {};
    this.actions.push({ launch: request, slot, args, rule, because, launchRule: launchRule?.rule });
  }

  counting(request, args, start, end) {
    const amounts = this.tables.amounts.slice(start, end);
    if (amounts.length) this.load(request, args);
    return amounts.filter((amount) => this.agrees(amount.predicate));
  }

  // ---- what becomes of slots and readings ----

  affect(start, end) {
    for (const { kind, target, value } of this.tables.effects.slice(start, end)) {
      if (kind === 0) {
        const { type } = this.tables.variables[target];
        this.read(target, fromWord(this.tables, type, this.names.variables[target], value));
      } else {
        this.setPast(target, null);
      }
    }
  }

  setPast(request, values) {
    const row = this.tables.requests[request];
    for (const { entry, predicate } of this.tables.pasts.slice(row.pasts, row.pasts_end)) {
      this.put(entry, values !== null && this.agrees(predicate) ? 1n : 0n);
    }
    this.pasts[request] = values;
  }

  end({ request, slot, outcome, results }) {
    const row = this.tables.requests[request];
    const values = [...this.slotArgs[row.slots + slot], ...(results ?? [])];
    this.setSlot(request, slot, IDLE, []);
    this.held[request] -= 1;
    this.put(row.last, BigInt(OUTCOMES.indexOf(outcome)));
    if (outcome === "ok") {
      this.load(request, values);
      this.setPast(request, values);
      for (const amount of this.counting(request, values, row.produces, row.produces_end)) this.produce(amount);
    }
    const edges = { ok: [row.on_ok, row.on_failed], failed: [row.on_failed, row.on_interrupted] };
    this.affect(...(edges[outcome] ?? [row.on_interrupted, row.effects_end]));
    this.latch(outcome === "ok" ? request : NONE);
  }

  produce({ stock, amount }) {
    const { entry, capacity } = this.tables.stocks[stock];
    if (entry === NONE) return;
    const level = this.vector[entry] + amount;
    this.put(entry, level < capacity ? level : capacity);
  }

  latch(clearedBy) {
    for (const { variable, condition, resets, resets_end } of this.tables.latches) {
      if (this.agrees(condition)) this.read(variable, true);
      else if (this.listed(resets, resets_end).includes(clearedBy)) this.read(variable, false);
    }
  }

  killTarget({ bound, high }) {
    const { requests } = this.tables;
    if (high >= 0) {
      for (let slot = 0; slot < requests[high].instances; slot++) this.kill(high, slot, this.reason(bound));
      return;
    }
    const number = -1 - high;
    const request = requests.findLastIndex((row) => row.slots <= number);
    this.kill(request, number - requests[request].slots, this.reason(bound));
  }

  kill(request, slot, { rule, because }) {
    const number = this.tables.requests[request].slots + slot;
    if (this.phase[number] !== RUNNING) return;
    this.setSlot(request, slot, STOPPING, this.slotArgs[number]);
    this.actions.push({ kill: request, slot, rule, because });
  }

  // ---- steps 3 to 5 ----

  recover() {
    this.tables.rules.forEach(({ root, reason }, number) => {
      if (!this.dirty[number]) return;
      this.dirty[number] = false;
      const path = this.watched(`recover ${this.reason(reason).rule}`, root);
      this.broken[number] = path.some((node) => ACTIONS[-node.code] === "violation");
      for (const node of path) if (ACTIONS[-node.code] === "kill") this.killTarget(node);
    });
  }

  launchRequired() {
    this.tables.launches.forEach(({ condition, request, args, reason }, number) => {
      if (this.tried[number] || condition === NONE) return;
      const due = condition === ALWAYS || this.watched(`launch ${this.reason(reason).rule}`, condition).length > 0;
      if (!due) return;
      this.tried[number] = true;
      this.ask(request, this.launched(request, args), number);
    });
  }

  /** Return the arguments of a required launch, which stand in `lists`. */
  launched(request, start) {
    const row = this.tables.requests[request];
    return this.names.requests[request].params.map((name, k) =>
      fromWord(this.tables, this.tables.params[row.params + k].type, name, this.tables.lists[start + k].word),
    );
  }

  settle() {
    this.place.forEach((_, request) => {
      if (this.place[request] === EMPTY) return;
      const args = this.placeArgs[request];
      const path = this.decide(request, args);
      const first = ACTIONS[-path[0].code];
      if (first === "reject") {
        this.vacate(request, this.reason(path[0].bound));
      } else if (first === "wait" || (this.fallen[request] && first !== "launch" && first !== "dismiss")) {
        this.fallen[request] ||= this.place[request] === CLEARING;
        this.setPlace(request, WAITING, args);
      } else {
        this.carryOut(request, args, path, null, this.placeRule[request]);
      }
    });
  }

  violations() {
    const said = new Set();
    this.tables.rules.forEach(({ reason }, number) => {
      const { rule, because } = this.reason(reason);
      const key = JSON.stringify([rule, because]);
      if (this.broken[number] && !said.has(key)) this.actions.push({ violation: rule, because });
      if (this.broken[number]) said.add(key);
    });
  }
}
