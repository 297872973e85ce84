"use strict";
// A run: events, what the tables answer to each, and what the checker holds afterwards.

/** The checker of a report at work from the initial state on; `moments[0]` is the start. */
class Run {
  constructor(tables, names) {
    this.names = names;
    this.wire = new Wire(tables, names);
    this.walker = new Walker(tables, names);
    this.moments = [{ line: null, event: null, actions: [], answer: null, walks: [], state: this.state() }];
  }

  get last() {
    return this.moments[this.moments.length - 1];
  }

  /** Answer the event of a line, and return the moment after it. */
  step(line) {
    const event = this.wire.read(line);
    const actions = this.walker.step(event);
    const answer = this.wire.answer(this.moments.length, actions);
    this.moments.push({ line, event, actions, answer, walks: this.walker.walks, state: this.state() });
    return this.last;
  }

  /** Return what the checker holds now, as plain lists by the numbers of the tables. */
  state() {
    const { tables, phase, slotArgs, place, placeArgs, readings, pasts, vector } = this.walker;
    return {
      slots: tables.requests.map((row) =>
        Array.from({ length: row.instances }, (_, slot) => ({
          phase: PHASES[phase[row.slots + slot]],
          args: slotArgs[row.slots + slot],
        })),
      ),
      places: place.map((content, k) => ({ phase: PLACES[content], args: placeArgs[k] })),
      last: tables.requests.map((row) => (row.last === NONE ? null : OUTCOMES[Number(vector[row.last])])),
      pasts: [...pasts],
      readings: [...readings],
      levels: tables.stocks.map(({ entry }) => (entry === NONE ? null : vector[entry])),
    };
  }
}

/** Return whether a line holds more than blanks, as an event does. */
function isWritten(line) {
  return /[^ \t\r\v\f]/.test(line);
}

/** Return the lines by which the tables answer lines of events; those that are blank are skipped. */
function answersTo(tables, names, lines) {
  const wire = new Wire(tables, names);
  const walker = new Walker(tables, names);
  return lines.filter(isWritten).map((line, k) => wire.answer(k + 1, walker.step(wire.read(line))));
}
