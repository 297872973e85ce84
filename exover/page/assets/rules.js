"use strict";
// The rules as the text has them, with their use: whether they ever act, and where in the diagrams they speak.

function rulesPart({ report, diagrams }) {
  const rows = new Map(report.rules.map((rule) => [rule.name, ruleRow(report, diagrams, rule)]));
  const filter = el("input", { type: "search", oninput: () => narrow(filter.value), placeholder: "name, text or request" });
  const narrow = (wanted) => {
    for (const row of rows.values()) row.hidden = !row.textContent.toLowerCase().includes(wanted.toLowerCase());
  };
  const part = el(
    "div",
    {},
    el("p", {}, "Everything that an answer can name: rules, guards of requests, resources, launch rules. ",
      "Whether one ever acts, the check ", el("code", {}, "rule-use"), " says."),
    el("div", { class: "controls" }, labelled("show those with", filter)),
    el("ul", { class: "rules" }, [...rows.values()]),
  );
  const show = (name) => {
    filter.value = "";
    narrow("");
    for (const [each, row] of rows) row.classList.toggle("now", each === name);
    rows.get(name)?.scrollIntoView({ block: "center" });
    rows.get(name)?.focus();
  };
  return { part, show };
}

function ruleRow(report, diagrams, { name, kind, request, written, because, place }) {
  const use = report.findings.find(({ check, subject }) => check === "rule-use" && subject === name);
  const others = report.findings.filter(({ check, subject, word }) => check !== "rule-use" && subject === name && word !== "ok");
  const where = diagrams ? diagrams.uses(name).map(({ label }) => link(`diagrams/${encodeURIComponent(label)}`, label)) : [];
  return el(
    "li",
    { tabindex: -1, "data-rule": name, "aria-label": `${kind} ${name}` },
    el("h3", {}, name, " ", el("small", {}, request && kind !== "launch" ? `${kind} of ${request}` : kind)),
    written ? el("pre", {}, written) : null,
    because && !written ? el("p", {}, el("q", {}, because)) : null,
    el("p", {}, useText(use), others.map(({ check, word, message }) => [" ", badge(word), ` ${check}: ${message}`])),
    where.length ? el("p", {}, "Speaks in: ", commas(where)) : null,
    place ? el("p", {}, placeLink(report, place)) : null,
  );
}

function useText(use) {
  if (!use) return [badge("not asked"), " whether it ever acts"];
  if (use.word === "ok") return [badge("in use"), " some run has it act"];
  return [badge(use.word), " ", use.message];
}
