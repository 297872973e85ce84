"use strict";
// Events and answers as JSON lines (docs/language.md section 7), read and written as exover/model/wire.py does. The
// codes of faults are the same; their details are in shorter words.

/** Reads the lines of events of one spec and writes the lines of answers. */
class Wire {
  constructor(tables, names) {
    this.tables = tables;
    this.names = names;
    this.requests = new Map(names.requests.map(({ name }, k) => [name, k]));
    this.variables = new Map();
    names.variables.forEach(({ name }, k) => {
      if (tables.variables[k].role === ROLES.POSTER) this.variables.set(name, k);
    });
    this.stocks = new Map(names.stocks.map(({ name }, k) => [name, k]));
  }

  // ---- reading ----

  /** Return the event of a line, or `{invalid, detail}`, the first of its faults. */
  read(line) {
    if (new TextEncoder().encode(line).length > LONGEST_LINE) return fault("bad-event", "the line is longer than 1 MiB");
    let found;
    try {
      found = parseLine(line.replace(/^\ufeff/, ""));
    } catch (error) {
      return fault("bad-event", `the line is not JSON: ${error.message}`);
    }
    if (!(found instanceof Map)) return fault("bad-event", "the line is not an object");
    for (const kind of ["ask", "report", "observe", "abort"]) {
      if (found.has(kind)) return this[`read_${kind}`](found);
    }
    return fault("bad-event", "none of ask, report, observe, abort is there");
  }

  read_ask(found) {
    const request = this.requestOf(found.get("ask"));
    if (request.invalid) return request;
    const args = this.values(request.number, false, found.has("args") ? found.get("args") : new Map());
    return args.invalid ? args : { kind: "ask", request: request.number, args };
  }

  read_report(found) {
    const request = this.requestOf(found.get("report"));
    if (request.invalid) return request;
    const slot = this.slotOf(request.number, found);
    if (slot.invalid) return slot;
    const outcome = found.get("outcome");
    if (!["ok", "failed", "interrupted"].includes(outcome)) {
      return fault("bad-event", "the outcome is not one of ok, failed, interrupted");
    }
    const event = { kind: "report", request: request.number, slot: slot.number, outcome };
    if (outcome === "ok") return this.withResults(event, found);
    if (outcome === "failed" && found.has("status")) return this.withStatus(event, found.get("status"));
    return event;
  }

  withResults(event, found) {
    const results = this.values(event.request, true, found.has("results") ? found.get("results") : new Map());
    return results.invalid ? results : { ...event, results };
  }

  withStatus(event, status) {
    const { name, statuses } = this.names.requests[event.request];
    return statuses.includes(status) ? { ...event, status } : fault("unknown-status", `that is no status of ${name}`);
  }

  read_observe(found) {
    const name = found.get("observe");
    const [variable, stock] = [this.variables.get(name), this.stocks.get(name)];
    if (variable === undefined && stock === undefined) {
      return fault("unknown-poster", `there is no such poster or consumable resource`);
    }
    const kind = variable === undefined ? this.stockKind(stock) : this.variableKind(variable);
    if (!found.has("value")) return fault("missing-argument", `value is missing: ${name} reads ${kind.domain}`);
    const value = this.value(kind, found.get("value"), name);
    const event = variable === undefined ? { kind: "observe", stock } : { kind: "observe", variable };
    const row = this.tables.variables[variable];
    if (value?.invalid !== "out-of-range" || !row?.has_fallback) return value?.invalid ? value : { ...event, value };
    const taken = fromWord(this.tables, row.type, this.names.variables[variable], row.fallback);
    return { ...event, value: taken, broken: `taken as ${plainText(taken)}` };
  }

  read_abort(found) {
    const request = this.requestOf(found.get("abort"));
    if (request.invalid) return request;
    if (found.get("waiting") === true) return { kind: "withdraw", request: request.number };
    const slot = this.slotOf(request.number, found);
    return slot.invalid ? slot : { kind: "abort", request: request.number, slot: slot.number };
  }

  requestOf(name) {
    const number = typeof name === "string" ? this.requests.get(name) : undefined;
    return number === undefined ? fault("unknown-request", "there is no such request") : { number };
  }

  slotOf(request, found) {
    const { name } = this.names.requests[request];
    const most = this.tables.requests[request].instances - 1;
    const kind = { type: TYPES.INT, low: 0n, high: BigInt(most), domain: `an integer in 0 .. ${most}` };
    const given = found.has("instance") ? found.get("instance") : new Numeral("0");
    const value = this.value(kind, given, `the instance of ${name}`);
    return value?.invalid ? value : { number: Number(value) };
  }

  /** Return the arguments, or the results, in an object, in the order of the parameters. */
  values(request, isResults, found) {
    const { name, params, results } = this.names.requests[request];
    const declared = isResults ? results : params;
    const word = isResults ? "result" : "parameter";
    if (!(found instanceof Map)) return fault("bad-event", `the ${word}s of ${name} are no object`);
    for (const key of found.keys()) {
      if (!declared.some((each) => each.name === key)) return fault("unknown-argument", `${name} has no ${word} ${key}`);
    }
    const values = [];
    for (const [k, each] of declared.entries()) {
      if (!found.has(each.name)) return fault("missing-argument", `${name} lacks ${each.name}, ${each.domain}`);
      const kind = this.paramKind(request, isResults ? params.length + k : k);
      const value = this.value(kind, found.get(each.name), `${each.name} of ${name}`);
      if (value?.invalid) return value;
      values.push(value);
    }
    return values;
  }

  // ---- types: what may be said stands in the tables, how it is called in the names ----

  kind(row, name) {
    const isReal = row.type === TYPES.REAL;
    const [low, high] = isReal ? [row.low, row.high].map((word) => this.tables.reals[Number(word)]) : [row.low, row.high];
    return { type: row.type, low, high, values: name.values, domain: name.domain };
  }

  paramKind(request, k) {
    const { params, results } = this.names.requests[request];
    return this.kind(this.tables.params[this.tables.requests[request].params + k], [...params, ...results][k]);
  }

  variableKind(variable) {
    return this.kind(this.tables.variables[variable], this.names.variables[variable]);
  }

  stockKind(stock) {
    return { type: TYPES.INT, low: 0n, high: this.tables.stocks[stock].capacity, domain: this.names.stocks[stock].domain };
  }

  /** Return what was found as a value of a type: a boolean, a BigInt, a number for a real, or a string. */
  value(kind, found, subject) {
    const value = typed(kind.type, found);
    const message = `${subject} is not ${kind.domain}`;
    if (value === null) return fault("wrong-type", message);
    return inside(kind, value) ? value : fault("out-of-range", message);
  }

  // ---- writing ----

  /** Return the answer to the event of this step, one line. */
  answer(step, actions) {
    return `{"step": ${step}, "actions": [${actions.map((action) => this.action(action)).join(", ")}]}`;
  }

  action(action) {
    const { rule, because, launchRule } = action;
    const why = [["rule", quoted(rule)], ["because", quoted(because)], ["launch_rule", quoted(launchRule)]];
    for (const word of ["launch", "wait", "reject", "kill"]) {
      if (word in action) {
        const name = quoted(this.names.requests[action[word]].name);
        const slot = "slot" in action ? String(action.slot) : null;
        const args = word === "launch" ? this.named(action.launch, action.args) : null;
        return objectJson([[word, name], ["instance", slot], ["args", args], ...why]);
      }
    }
    if ("violation" in action) return objectJson([["violation", quoted(action.violation)], ["because", quoted(because)]]);
    return objectJson([["invalid", quoted(action.invalid)], ["detail", action.detail ? quoted(action.detail) : null]]);
  }

  named(request, args) {
    const { params } = this.names.requests[request];
    return objectJson(args.map((value, k) => [params[k].name, valueJson(value)]));
  }
}

function fault(invalid, detail) {
  return { invalid, detail };
}

function quoted(value) {
  return value === undefined || value === null ? null : JSON.stringify(value);
}

/** Return a value as the language writes it. */
function plainText(value) {
  return typeof value === "number" ? realText(value) : String(value);
}

function typed(type, found) {
  if (type === TYPES.BOOL) return typeof found === "boolean" ? found : null;
  if (type === TYPES.ENUM) return typeof found === "string" ? found : null;
  if (!(found instanceof Numeral)) return null;
  return type === TYPES.REAL ? found.real : found.whole;
}

function inside({ type, low, high, values }, value) {
  if (type === TYPES.BOOL) return true;
  if (type === TYPES.ENUM) return values.includes(value);
  if (type === TYPES.REAL) return Number.isFinite(value) && low <= value && value <= high;
  return typeof value === "bigint" && low <= value && value <= high;
}
