"use strict";
// What an audit of recorded missions has found (`exover report --audit`).

/** Divergences of a mission that are listed. */
const MOST_DIVERGENCES = 200;

function missionsPart({ report }) {
  const { audit } = report;
  if (!audit) return { part: el("p", {}, "No audit of missions was given.") };
  const part = el(
    "div",
    {},
    el("p", {}, audit.outcome),
    table(["mission", "events", "divergences", "first in line"], audit.missions.map(missionRow), { caption: "missions" }),
    table(["request", "launch", "wait", "reject", "invalid"], Object.entries(audit.total.asks).map(askRow),
      { caption: "what the asks are answered" }),
    table(["rule", "used"], Object.entries(audit.total.rules).map(ruleUseRow), { caption: "use of every rule" }),
    audit.missions.map(missionView),
  );
  return { part };
}

function missionRow({ mission, error, events, diverged, divergences }) {
  if (error) return [mission, "", error, ""];
  const count = Object.values(diverged).reduce((sum, each) => sum + each, 0);
  return [mission, String(events), String(count), divergences.length ? String(divergences[0].line) : ""];
}

function askRow([request, { launch, wait, reject, invalid }]) {
  return [request, ...[launch, wait, reject, invalid].map(String)];
}

function ruleUseRow([rule, used]) {
  return [link(`rules/${encodeURIComponent(rule)}`, rule), used ? String(used) : "never"];
}

function missionView({ mission, divergences = [], mistakes = [], mistake_count: mistakeCount = 0, notes = [] }) {
  if (!divergences.length && !mistakes.length && !notes.length) return null;
  const shown = divergences.slice(0, MOST_DIVERGENCES).map(({ line, text }) => el("li", {}, `line ${line}: ${text}`));
  return el(
    "section",
    { "data-mission": mission },
    el("h3", {}, mission),
    el("ul", {}, shown, mistakes.map(({ line, text }) => el("li", {}, `line ${line}: ${text}`)), notes.map((note) => el("li", {}, note))),
    divergences.length > shown.length ? el("p", {}, `${divergences.length - shown.length} more are not listed.`) : null,
    mistakeCount > mistakes.length ? el("p", {}, `${mistakeCount - mistakes.length} more mistakes are not listed.`) : null,
  );
}
