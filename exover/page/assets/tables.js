"use strict";
// The packed tables, read from their bytes (docs/runtime.md). Indices become numbers; whatever is compared or added up
// becomes a BigInt, for it may take 64 bits.

const NONE = -1;
const ALWAYS = -2;
const VERSION = 3;
const HEADER = 52;
const BLOCK = 16;
const WIDTHS = [2, 4, 8];
const TYPES = { BOOL: 0, INT: 1, ENUM: 2, REAL: 3 };
const ROLES = { POSTER: 0, STATE: 1, LATCH: 2 };
const ACTIONS = ["", "reject", "wait", "clear", "settle", "kill", "dismiss", "launch", "violation", "agree"];
const DENIALS = { NONE: 0, CLEARINGS: 1, ALL: 2 };

/** The sections in the order of the bytes, and the fields of their records; those with a star hold values. */
const SECTIONS = {
  nodes: "code *bound low high",
  entries: "*initial rules rules_end sums sums_end",
  requests:
    "decide slots instances values interrupts_self statuses params results params_end orders orders_end features " +
    "features_end pasts pasts_end consumes produces produces_end on_launch on_ok on_failed on_interrupted effects_end " +
    "last conflicts conflicts_end",
  params: "type *low *high cuts cuts_end value rank",
  orders: "left right entry",
  features: "predicate slot weight running stopping waiting clearing",
  pasts: "predicate entry",
  amounts: "stock *amount predicate",
  effects: "kind target *value",
  variables:
    "role type *low *high *initial has_fallback *fallback cuts cuts_end value rank raw refresh refresh_end orders orders_end",
  latches: "variable condition resets resets_end",
  stocks: "*capacity *initial entry",
  rules: "root reason",
  launches: "condition request args reason",
  limits: "tests actions passes violations",
  conflicts: "block mask",
  reasons: "denials",
  invariants: "root reason",
  sums: "entry *factor",
  lists: "*word",
};

/** Return the bytes that a text in base64 stands for. */
function bytesOf(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

/** Return the tables in these bytes, section by section; throws an `Error` that says why they are none. */
function decode(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const names = Object.keys(SECTIONS);
  const start = HEADER + 4 * (names.length + 1);
  if (bytes.length < start) throw new Error("too short for a table");
  const magic = String.fromCharCode(...bytes.subarray(0, 4));
  const [version, width] = [view.getUint16(4, true), view.getUint16(6, true)];
  if (magic !== "EXOV" || version !== VERSION || !WIDTHS.includes(width)) throw new Error("no table of this format");
  if (crc32(bytes) !== view.getUint32(12, true)) throw new Error("the checksum of the table is wrong");
  const reals = Array.from({ length: view.getUint32(16, true) }, (_, k) => view.getFloat64(start + 8 * k, true));
  const word = wordsFrom(view, width, start + 8 * reals.length);
  const tables = { reals };
  names.forEach((name, k) => {
    const fields = SECTIONS[name].split(" ");
    const length = view.getUint32(HEADER + 4 * k, true);
    tables[name] = Array.from({ length }, () => record(fields, word));
  });
  return tables;
}

/** Return a function that reads one signed word after the other, as a number or, of eight bytes, as a BigInt. */
function wordsFrom(view, width, start) {
  let at = start - width;
  const read = { 2: "getInt16", 4: "getInt32", 8: "getBigInt64" }[width];
  return () => view[read]((at += width), true);
}

function record(fields, word) {
  return Object.fromEntries(
    fields.map((field) => (field.startsWith("*") ? [field.slice(1), BigInt(word())] : [field, Number(word())])),
  );
}

/** Return the CRC-32 of the bytes, in which those of the checksum itself count as 0. */
function crc32(bytes) {
  let crc = ~0;
  for (let k = 0; k < bytes.length; k++) {
    crc ^= k >= 12 && k < 16 ? 0 : bytes[k];
    for (let bit = 0; bit < 8; bit++) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

/** Return the value that a word of the tables stands for: of a real, the word is the index of a double. */
function fromWord(tables, type, name, word) {
  if (type === TYPES.BOOL) return word !== 0n;
  if (type === TYPES.INT) return word;
  return type === TYPES.ENUM ? name.values[Number(word)] : tables.reals[Number(word)];
}

/** Return the integer that stands for a value of a bool, int or enum. */
function toWord(type, name, value) {
  return BigInt(type === TYPES.ENUM ? name.values.indexOf(value) : value);
}
