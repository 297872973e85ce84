"use strict";
// What a running checker holds, as exover/ocrd/memory.py has it: the state vector, slots, waiting places, readings.

const IDLE = 0;
const RUNNING = 1;
const STOPPING = 2;
const EMPTY = 0;
const WAITING = 1;
const CLEARING = 2;
const PHASES = ["idle", "running", "stopping"];
const PLACES = ["empty", "waiting", "clearing"];
const OUTCOMES = ["none", "ok", "failed", "interrupted"];

/** The state of a checker; `names` says what the numbers of the tables are called. */
class Memory {
  constructor(tables, names) {
    this.tables = tables;
    this.names = names;
    this.conflicts = tables.requests.map((row) => this.conflictsOf(row));
    this.restart();
  }

  /** Begin anew, in the initial state. */
  restart() {
    const { entries, requests, variables, reals, launches, rules } = this.tables;
    const slots = requests.reduce((sum, row) => sum + row.instances, 0);
    this.vector = entries.map((entry) => entry.initial);
    this.phase = Array(slots).fill(IDLE);
    this.held = Array(requests.length).fill(0);
    this.slotArgs = Array(slots).fill([]);
    this.place = Array(requests.length).fill(EMPTY);
    this.placeArgs = Array(requests.length).fill([]);
    this.placeRule = Array(requests.length).fill(null);
    this.refused = Array(launches.length).fill(null);
    this.raw = variables.map((row) => (row.type === TYPES.REAL ? reals[Number(row.initial)] : 0));
    this.broken = Array(rules.length).fill(false);
    this.dirty = Array(rules.length).fill(true);
    this.actions = [];
    this.walks = [];
    this.changed = false;
    // For the reader alone, no decision looks at them: what was read last, and the arguments and results of pasts.
    this.readings = variables.map((row, k) => fromWord(this.tables, row.type, this.names.variables[k], row.initial));
    this.pasts = Array(requests.length).fill(null);
  }

  /** Return the requests in the bit row of a request. */
  conflictsOf(row) {
    const found = [];
    for (const { block, mask } of this.tables.conflicts.slice(row.conflicts, row.conflicts_end)) {
      for (let bit = 0; bit < BLOCK; bit++) if ((mask >> bit) & 1) found.push(BLOCK * block + bit);
    }
    return found;
  }

  /** Return words of `lists` that are indices. */
  listed(start, end) {
    return this.tables.lists.slice(start, end).map(({ word }) => Number(word));
  }

  // ---- the vector ----

  add(entry, delta) {
    if (entry === NONE || delta === 0n) return;
    const row = this.tables.entries[entry];
    this.vector[entry] += delta;
    for (const rule of this.listed(row.rules, row.rules_end)) this.dirty[rule] = true;
    for (let k = row.sums; k < row.sums_end; k++) {
      const { entry: sum, factor } = this.tables.sums[k];
      this.add(sum, factor * delta);
    }
  }

  put(entry, value) {
    if (entry !== NONE) this.add(entry, value - this.vector[entry]);
  }

  /** Return the action nodes on the path that the vector takes from `node`; `path` collects the numbers of all nodes. */
  walk(node, path = []) {
    const found = [];
    while (node !== NONE) {
      const here = this.tables.nodes[node];
      path.push(node);
      if (here.code < 0) found.push(here);
      node = here.code < 0 || this.vector[here.code] <= here.bound ? here.low : here.high;
    }
    return found;
  }

  /** Walk a diagram and remember its path, under the name of the event or question. */
  watched(label, root) {
    const path = [];
    const found = this.walk(root, path);
    this.walks.push({ label, root, path });
    return found;
  }

  agrees(predicate) {
    return predicate === ALWAYS || this.walk(predicate).length > 0;
  }

  // ---- arguments ----

  paramsOf(request) {
    const { params, results } = this.names.requests[request];
    return [...params, ...results];
  }

  /** Put arguments, and results if there are any, into the entries that tests of them read. */
  load(request, values) {
    const row = this.tables.requests[request];
    values.forEach((value, k) => {
      const param = this.tables.params[row.params + k];
      if (param.type === TYPES.REAL) this.put(param.rank, this.rank(param, value));
      else this.put(param.value, this.argument(request, k, value));
    });
    for (const order of this.tables.orders.slice(row.orders, row.orders_end)) {
      if (order.left < values.length && order.right < values.length) this.compare(order, values);
    }
  }

  argument(request, k, value) {
    const param = this.tables.params[this.tables.requests[request].params + k];
    return toWord(param.type, this.paramsOf(request)[k], value);
  }

  /** Return twice the number of constants below a real, one more if it is a constant itself. */
  rank({ cuts, cuts_end }, value) {
    const constants = this.tables.reals.slice(cuts, cuts_end);
    return BigInt(2 * constants.filter((cut) => cut < value).length + (constants.includes(value) ? 1 : 0));
  }

  compare({ left, right, entry }, values) {
    const [one, other] = [left, right].map((side) => (side >= 0 ? values[side] : this.raw[-1 - side]));
    this.put(entry, one === other ? 1n : one < other ? 0n : 2n);
  }

  /** Count what holds `args` in (or, sign -1n, out of) every feature of its request. */
  count(request, args, slot, phase, sign) {
    const row = this.tables.requests[request];
    const features = this.tables.features.slice(row.features, row.features_end);
    if (features.some(({ predicate, weight }) => predicate !== ALWAYS || weight !== NONE)) this.load(request, args);
    for (const feature of features) {
      if ((feature.slot === NONE || feature.slot === slot) && this.agrees(feature.predicate)) {
        const weight = feature.weight === NONE ? 1n : this.argument(request, feature.weight, args[feature.weight]);
        this.add(feature[phase], sign * weight);
      }
    }
  }

  setSlot(request, slot, phase, args) {
    const number = this.tables.requests[request].slots + slot;
    const before = this.phase[number];
    if (before !== IDLE) this.count(request, this.slotArgs[number], slot, PHASES[before], -1n);
    this.phase[number] = phase;
    this.slotArgs[number] = args;
    if (phase !== IDLE) this.count(request, args, slot, PHASES[phase], 1n);
    this.changed = true;
  }

  setPlace(request, phase, args) {
    const before = this.place[request];
    const same = args.every((value, k) => value === this.placeArgs[request][k]);
    if (before === phase && args.length === this.placeArgs[request].length && same) return;
    if (before !== EMPTY) this.count(request, this.placeArgs[request], NONE, PLACES[before], -1n);
    this.place[request] = phase;
    this.placeArgs[request] = args;
    if (phase !== EMPTY) this.count(request, args, NONE, PLACES[phase], 1n);
    this.changed = true;
  }

  /** Let a poster, state or latch read `value`. */
  read(variable, value) {
    const row = this.tables.variables[variable];
    const held = this.heldBy(this.listed(row.refresh, row.refresh_end));
    for (const [request, slot, phase, args] of held) this.count(request, args, slot, phase, -1n);
    if (row.type === TYPES.REAL) {
      this.put(row.rank, this.rank(row, value));
      this.raw[variable] = value;
    } else {
      this.put(row.value, toWord(row.type, this.names.variables[variable], value));
    }
    for (const order of this.tables.orders.slice(row.orders, row.orders_end)) this.compare(order, []);
    for (const [request, slot, phase, args] of held) this.count(request, args, slot, phase, 1n);
    this.readings[variable] = value;
  }

  /** Return the active slots of these requests, with what they hold. */
  heldBy(requests) {
    return requests.flatMap((request) => {
      const { slots, instances } = this.tables.requests[request];
      const numbers = Array.from({ length: instances }, (_, slot) => slots + slot);
      return numbers
        .filter((number) => this.phase[number] !== IDLE)
        .map((number) => [request, number - slots, PHASES[this.phase[number]], this.slotArgs[number]]);
    });
  }
}
