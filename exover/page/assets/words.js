"use strict";
// Events and actions in words, as exover/model/wording.py has them.

/** Tells what happens in the words of docs/language.md; `names` says what the numbers of the tables are called. */
class Words {
  constructor(tables, names) {
    this.tables = tables;
    this.names = names;
  }

  /** Return the name of a request, with the number of a slot where it has several. */
  slot(request, slot) {
    const { name } = this.names.requests[request];
    return this.tables.requests[request].instances > 1 ? `${name}[${slot}]` : name;
  }

  /** Return arguments, or arguments and results, with their names. */
  args(request, values, declared = this.names.requests[request].params) {
    return values.map((value, k) => `${declared[k].name} = ${plainText(value)}`).join(", ");
  }

  event(event) {
    if (event.invalid) return `an event that is ${event.invalid}`;
    const { kind, request } = event;
    const { name, results } = this.names.requests[request] ?? {};
    if (kind === "ask") return `ask ${name}(${this.args(request, event.args)})`;
    if (kind === "withdraw") return `abort ${name} waiting`;
    if (kind === "abort") return `abort ${this.slot(request, event.slot)}`;
    if (kind === "report") return `report ${this.slot(request, event.slot)} ${this.ending(event, results)}`;
    const read = event.stock === undefined ? this.names.variables[event.variable] : this.names.stocks[event.stock];
    return `observe ${read.name} ${event.broken ? `broken, ${event.broken}` : `= ${plainText(event.value)}`}`;
  }

  ending({ request, outcome, results, status }, declared) {
    if (outcome === "ok") return declared.length ? `ok(${this.args(request, results, declared)})` : "ok";
    return status ? `${outcome}(${status})` : outcome;
  }

  /** Return what an action does, without the rule. */
  action(action) {
    const of = action.launchRule && action.rule !== action.launchRule ? ` of ${action.launchRule}` : "";
    if ("launch" in action) {
      return `launch ${this.slot(action.launch, action.slot)}(${this.args(action.launch, action.args)})${of}`;
    }
    if ("kill" in action) return `kill ${this.slot(action.kill, action.slot)}`;
    if ("violation" in action) return "violation";
    if ("invalid" in action) return `invalid ${action.invalid}${action.detail ? `: ${action.detail}` : ""}`;
    const word = "wait" in action ? "wait" : "reject";
    return `${word} ${this.names.requests[action[word]].name}${action.launchRule ? ` of ${action.launchRule}` : ""}`;
  }
}

/** Return what kind of action it is. */
function actionKind(action) {
  return ["launch", "wait", "reject", "kill", "violation", "invalid"].find((kind) => kind in action);
}
