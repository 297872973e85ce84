"use strict";
// The parts of the page, which of them is shown, and how light it is.

/** Show a part of the page by its address, `#part/what/…`. */
function go(...words) {
  location.hash = words.map((word) => encodeURIComponent(word)).join("/");
}

function runsPart(page) {
  const { report } = page;
  const body = el("div");
  const titles = report.runs.map(({ finding }, k) => {
    const { word, check, subject } = report.findings[finding];
    return [String(k + 1), `${word}: ${check} ${subject}`];
  });
  const select = choice(titles, "1", (number) => go("runs", number));
  const show = (number) => {
    const k = Math.min(Math.max(Number(number) || 1, 1), report.runs.length) - 1;
    select.value = String(k + 1);
    if (report.runs.length) replace(body, ...runView(page, report.runs[k]));
  };
  const intro = "Each run begins at the start. Step through it with the buttons, the slider, or the arrow keys on the timeline.";
  const part = report.runs.length
    ? el("div", {}, el("p", {}, intro), el("div", { class: "controls" }, labelled("run", select)), body)
    : el("p", {}, "No finding has a run to show.");
  return { part, show };
}

function runView(page, { finding, events, answers, loop_start: loopStart }) {
  const { message, word, check, subject } = page.report.findings[finding];
  const run = new Run(page.tables, page.names);
  for (const line of events) run.step(line);
  const wrong = answers.findIndex((answer, k) => answer !== run.moments[k + 1].answer && !answer.includes('{"invalid": '));
  const open = () => {
    page.simulator.restart([...events]);
    page.simulator.play(Infinity);
    go("simulator");
  };
  return [
    el("h3", {}, badge(word), ` ${check} ${subject}`),
    el("p", {}, message),
    wrong < 0 ? null : el("p", { class: "message" }, `The page answers step ${wrong + 1} otherwise than exover did: please report it.`),
    new Timeline(run, { loopStart }).node,
    el("p", {}, button("open in the simulator", open)),
  ];
}

function specPart({ report }) {
  if (!report.files) return { part: el("p", {}, "The text of the spec is too long to be shown here.") };
  const files = report.files.map(({ text }) => text.split("\n").map((line, k) => el("li", { value: k + 1 }, line || "\u200b")));
  const show = (file, number) => {
    files.flat().forEach((line) => line.classList.remove("now"));
    const line = files[Number(file) - 1]?.[Number(number) - 1];
    line?.classList.add("now");
    line?.scrollIntoView({ block: "center" });
  };
  const parts = files.map((lines, k) => [
    el("h3", {}, report.files[k].name),
    el("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": report.files[k].name }, el("ol", { class: "source" }, lines)),
  ]);
  return { part: el("div", {}, parts), show };
}

/** The parts by their addresses: the title, what makes them, and whether they need the tables. */
const PARTS = {
  verdicts: ["Verdicts", verdictsPart, false],
  rules: ["Rules", rulesPart, false],
  graph: ["Who excludes whom", graphPart, false],
  diagrams: ["Diagrams", diagramsPart, true],
  runs: ["Runs", runsPart, true],
  simulator: ["Simulator", (page) => ({ part: page.simulator.part() }), true],
  missions: ["Missions", missionsPart, false],
  spec: ["Spec", specPart, false],
};

/** The page that is shown, and its parts as far as they were looked at. */
let page = null;
const made = new Map();

/** Show a report, in place of the one that is there. */
function begin(report) {
  page = { report };
  if (report.table) {
    page.tables = decode(bytesOf(report.table));
    page.names = report.names;
    page.diagrams = new Diagrams(page.tables, page.names);
    page.simulator = new Simulator(page);
  }
  document.getElementById("tab-missions").hidden = !report.audit;
  made.clear();
  replace(document.getElementById("parts"));
  document.getElementById("title").textContent = report.spec;
  replace(document.getElementById("verdict"), badge(report.verdict));
  document.getElementById("version").textContent = `exover ${report.version}.`;
  turnTo();
}

/** Show the part that the address names. */
function turnTo() {
  const [name, ...rest] = location.hash.slice(1).split("/").map(decoded);
  const chosen = Object.hasOwn(PARTS, name) ? name : "verdicts";
  if (!made.has(chosen)) made.set(chosen, added(document.getElementById("parts"), page, chosen));
  for (const tab of document.getElementById("tabs").children) {
    const isChosen = tab.id === `tab-${chosen}`;
    tab.setAttribute("aria-selected", isChosen);
    tab.tabIndex = isChosen ? 0 : -1;
    if (isChosen) tab.scrollIntoView({ block: "nearest", inline: "center" });
  }
  for (const [each, { node }] of made) node.hidden = each !== chosen;
  made.get(chosen).show?.(...rest);
}

function added(body, page, name) {
  const [title, make, needsTables] = PARTS[name];
  const missing = { part: el("p", {}, "The command ended before the tables were made.") };
  const { part, show } = needsTables && !page.tables ? missing : make(page);
  const node = el("section", { id: `part-${name}`, role: "tabpanel", "aria-labelledby": `tab-${name}` }, el("h2", {}, title), part);
  body.append(node);
  return { node, show };
}

function decoded(word) {
  try {
    return decodeURIComponent(word);
  } catch {
    return word;
  }
}

/** Move among the tabs by arrow keys, Home and End. */
function turn(event) {
  const tabs = [...document.getElementById("tabs").children].filter((tab) => !tab.hidden);
  const at = tabs.indexOf(document.activeElement);
  const targets = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: tabs.length - 1 };
  if (at < 0 || !(event.key in targets)) return;
  event.preventDefault();
  const tab = tabs.at(targets[event.key] % tabs.length);
  tab.click();
  tab.focus();
}

/** Make what is the same for every report: the tabs, and the choice of colours. */
function dress() {
  const tabs = Object.entries(PARTS).map(([name, [title]]) =>
    el("a", { role: "tab", id: `tab-${name}`, href: `#${name}`, "aria-controls": `part-${name}` }, title));
  replace(document.getElementById("tabs"), ...tabs);
  document.getElementById("tabs").addEventListener("keydown", turn);
  addEventListener("hashchange", () => page && turnTo());
  const themes = ["as the system", "light", "dark"];
  const select = choice(themes.map((theme) => [theme, theme]), themes[0], (theme) => {
    document.documentElement.dataset.theme = theme;
  });
  document.getElementById("theme").append(labelled("colours", select));
}
