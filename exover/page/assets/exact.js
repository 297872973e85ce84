"use strict";
// JSON lines with exact numbers: a number stays the text that it is until its type is known, so no double stands
// between a file and an integer of 64 bits. Objects become Maps, for a name may be `__proto__`.

const LONGEST_LINE = 1 << 20;
const TOKEN = /"[^"\\]*(?:\\.[^"\\]*)*"|-?(?:0|[1-9]\d*)(?:\.\d+)?(?:[eE][+-]?\d+)?|NaN|-?Infinity/g;

/** A number of a JSON text, as it is written. */
class Numeral {
  constructor(text) {
    this.text = text;
  }

  /** The nearest double, never -0. */
  get real() {
    return Number(this.text) + 0;
  }

  /** The integer that it is, as a BigInt; null if it has a fraction; NaN or an infinity if no double is so large. */
  get whole() {
    if (!Number.isFinite(this.real)) return this.real;
    const [, sign, before, fraction = "", exponent = "0"] = /^(-?)(\d+)(?:\.(\d+))?(?:[eE](.+))?$/.exec(this.text);
    const digits = (before + fraction).replace(/^0+/, "");
    const shift = Number(exponent) - fraction.length;
    const zeros = digits.length - digits.replace(/0+$/, "").length;
    if (digits === "") return 0n;
    if (shift + zeros < 0) return null;
    const size = shift < 0 ? BigInt(digits.slice(0, shift)) : BigInt(digits) * 10n ** BigInt(shift);
    return sign ? -size : size;
  }
}

/** Return what a line of JSON holds; throws an `Error` if it is none. */
function parseLine(text) {
  // Strings get an s before them and numbers become strings with an n, so that JSON.parse judges all the rest.
  const marked = text.replace(TOKEN, (token) => (token.startsWith('"') ? `"s${token.slice(1)}` : `"n${token}"`));
  return unmarked(JSON.parse(marked));
}

function unmarked(found) {
  if (typeof found === "string") return found.startsWith("n") ? new Numeral(found.slice(1)) : found.slice(1);
  if (Array.isArray(found)) return found.map(unmarked);
  if (found === null || typeof found !== "object") return found;
  return new Map(Object.entries(found).map(([key, value]) => [keyOf(key), unmarked(value)]));
}

function keyOf(marked) {
  if (!marked.startsWith("s")) throw new SyntaxError("a key is no string");
  return marked.slice(1);
}

/** Return a double as the answers of exover print it: whole ones without a fraction, below 10^16 without an exponent. */
function realText(value) {
  if (Number.isInteger(value) && Math.abs(value) < 1e16) return String(value + 0);
  const [, sign, lead, rest = "", power] = /^(-?)(\d)(?:\.(\d+))?e([+-]\d+)$/.exec(value.toExponential());
  const exponent = Number(power);
  if (exponent >= 16 || exponent < -4) {
    const size = String(Math.abs(exponent)).padStart(2, "0");
    return `${sign}${lead}${rest && "."}${rest}e${exponent < 0 ? "-" : "+"}${size}`;
  }
  return String(value);
}

/** Return a value of the language as JSON. */
function valueJson(value) {
  return typeof value === "number" ? realText(value) : typeof value === "bigint" ? String(value) : JSON.stringify(value);
}

/** Return pairs of names and JSON texts as an object of JSON; pairs without a text are left out. */
function objectJson(pairs) {
  const present = pairs.filter(([, text]) => text !== undefined && text !== null);
  return `{${present.map(([name, text]) => `${JSON.stringify(name)}: ${text}`).join(", ")}}`;
}
