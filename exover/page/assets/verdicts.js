"use strict";
// What the checks say: what does not hold first, then all of it, check by check.

const WORDS = ["violated", "unknown", "warning", "note", "ok"];
const ALL = { asked: "Everything that was asked holds", none: "Nothing was asked" };

function verdictsPart(page) {
  const { report } = page;
  const open = report.findings.filter(({ word }) => word !== "ok");
  open.sort((one, other) => WORDS.indexOf(one.word) - WORDS.indexOf(other.word));
  const part = el(
    "div",
    {},
    el("p", { class: "outcome" }, badge(report.verdict), " ", report.outcome),
    figures(report),
    el("h3", {}, open.length ? "What does not hold" : ALL[report.findings.length ? "asked" : "none"]),
    open.length ? el("ul", { class: "findings" }, open.map((finding) => findingItem(page, finding))) : null,
    el("h3", {}, "Check by check"),
    report.checks.map((check) => checkDetails(page, check)),
  );
  return { part };
}

function figures({ figures: found, file, properties }) {
  const pairs = [["spec", file], ["properties", properties ?? "none"], ...found];
  return el("dl", { class: "figures" }, pairs.map(([name, value]) => el("div", {}, el("dt", {}, name), el("dd", {}, value))));
}

function findingItem({ report }, finding) {
  const { word, check, subject, message, excuse, run, place } = finding;
  const where = placeLink(report, place);
  return el(
    "li",
    {},
    badge(word), " ", el("strong", {}, check), " ", subjectLink(report, subject), where ? [", ", where] : "",
    el("p", {}, message),
    excuse ? el("p", { class: "excuse" }, excuse) : null,
    run === null ? null : el("p", {}, link(`runs/${run + 1}`, "see the run that shows it")),
  );
}

/** Return a place of a spec, as a link to the text where that is shown; null if there is none. */
function placeLink(report, place) {
  if (!place) return null;
  const words = `${place.file}:${place.line}`;
  const file = (report.files ?? []).findIndex(({ name }) => name === place.file);
  return file < 0 ? words : link(`spec/${file + 1}/${place.line}`, words);
}

function subjectLink(report, subject) {
  return report.rules.some(({ name }) => name === subject) ? ruleLink(subject) : el("code", {}, subject);
}

function checkDetails({ report }, { name, severity, iff, mend }) {
  const found = report.findings.filter(({ check }) => check === name);
  const asked = !report.skipped.includes(name);
  const counts = WORDS.map((word) => [found.filter((each) => each.word === word).length, word]).filter(([count]) => count);
  const rows = found.map(({ subject, word, engine, method, message, run }) => [
    subjectLink(report, subject),
    badge(word),
    word === "ok" ? `${method} (${engine})` : message,
    run === null ? "" : link(`runs/${run + 1}`, "run"),
  ]);
  return el(
    "details",
    {},
    el("summary", {}, el("strong", {}, name), ` (${severity}) `,
      asked ? counts.map(([count, word]) => [badge(word), ` ${count} `]) : badge("not asked"), asked && !found.length ? "nothing to ask" : ""),
    iff ? el("p", {}, "Holds iff ", iff, ".") : null,
    mend && counts.some(([, word]) => word !== "ok") ? el("p", {}, "How to mend it: ", mend, ".") : null,
    rows.length ? table(["subject", "", "how", ""], rows) : null,
  );
}
