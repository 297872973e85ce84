"""`exover audit`: statuses, formats, what is wrong with missions, and the page that shows an audit."""

import errno
import json
import os
from collections.abc import Iterator
from pathlib import Path
from unittest.mock import patch

import jsonschema
import pytest

from exover.audit import native
from exover.engines.compiler import NativeUnavailable
from exover.model.canonical import digest
from exover.model.wire import Json
from tests.audit.missions import CRANE, LOOSE, QUICKLY, built, told
from tests.support.command import Run

LINES = (
    '{"time": 1700000000, "event": {"ask": "slew.turn"}, "actions": [{"launch": "slew.turn"}]}',
    '{"time": 1700000001.25, "event": {"ask": "hoist.lift", "args": {"load": 1}},'
    ' "actions": [{"launch": "hoist.lift"}]}',
)

SCHEMA = Path(__file__).parents[1] / "report" / "sarif-schema-2.1.0.json"
DIVERGES = "launched at 2023-11-14T22:13:21.250Z: the robot launched hoist.lift, and the tables let it wait [one]"


@pytest.fixture(autouse=True)
def quickly() -> Iterator[None]:
    """Compile without optimisation."""
    with patch.object(native.compile_library, "__defaults__", (QUICKLY,)):
        yield


@pytest.fixture
def run(tmp_path: Path) -> Run:
    (tmp_path / "crane.exo").write_text(CRANE, encoding="utf-8")
    (tmp_path / "m.jsonl").write_text("".join(f"{line}\n" for line in LINES), encoding="utf-8")
    (tmp_path / "well.jsonl").write_text(f"{LINES[0]}\n", encoding="utf-8")
    return Run(tmp_path)


def test_a_mission_that_cannot_be_read_says_nothing_of_rules(run: Run) -> None:
    done = run("audit", "crane.exo", "nowhere.jsonl")
    assert done.returncode == 2
    why = "it cannot be read: No such file or directory"
    last = "crane: 1 mission, 0 events; nothing is known; 1 not audited"
    assert done.stdout == f"nowhere.jsonl: not audited: {why}\n{last}\n"


def test_text(run: Run) -> None:
    done = run("audit", "crane.exo", "m.jsonl", "well.jsonl")
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout == (
        "m.jsonl: 2 events, 1 divergence, the first in line 2\n"
        f"  m.jsonl:2: {DIVERGES}\n"
        "well.jsonl: 1 event, no divergence\n"
        "asks:\n"
        "  hoist.lift: wait 1\n"
        "  slew.turn: launch 2\n"
        "rules:\n"
        "  hoist.lift.light: never used\n"
        "  hoist.hold.wait.1: never used\n"
        "  slew.turn.interrupts.self: never used\n"
        "  one: 1\n"
        "  away: never used\n"
        "  home: never used\n"
        "crane: 2 missions, 3 events; 1 of them diverges: 1 launched\n"
    )


def test_every_engine_says_the_same(run: Run) -> None:
    said = {engine: run("audit", "crane.exo", "m.jsonl", "--engine", engine) for engine in ("c", "tables", "reference")}
    assert len({(done.returncode, done.stdout, done.stderr) for done in said.values()}) == 1


def test_nothing_diverges(run: Run) -> None:
    done = run("audit", "crane.exo", "well.jsonl", "--engine", "tables")
    assert done.returncode == 0
    assert done.stdout.endswith("crane: 1 mission, 1 event; nothing diverges\n")


def test_json_and_sarif(run: Run) -> None:
    found: Json = json.loads(run("audit", "crane.exo", "m.jsonl", "--format", "json", "--engine", "tables").stdout)
    (mission,) = found["missions"]
    assert mission["divergences"] == [
        {
            "line": 2,
            "time": 1700000001.25,
            "kind": "launched",
            "request": "hoist.lift",
            "instance": 0,
            "answer": "wait",
            "rule": "one",
            "text": DIVERGES,
        }
    ]
    assert found["total"]["rules"]["one"] == 1
    log = json.loads(run("audit", "crane.exo", "m.jsonl", "--format", "sarif", "--engine", "tables").stdout)
    jsonschema.validate(log, json.loads(SCHEMA.read_text(encoding="utf-8")))
    (result,) = log["runs"][0]["results"]
    assert (result["ruleId"], result["level"]) == ("exover/audit/launched", "error")
    assert result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] == "crane.exo"
    (related,) = result["relatedLocations"]
    assert related["physicalLocation"] == {"artifactLocation": {"uri": "m.jsonl"}, "region": {"startLine": 2}}


def test_any_number_of_jobs_prints_the_same_bytes(run: Run) -> None:
    pytest.importorskip("pyarrow")
    for seed in range(4):
        (run.folder / "logs" / ".hidden").mkdir(parents=True, exist_ok=True)
        (run.folder / "logs" / f"{seed}.log").write_bytes(b"\n".join(told(LOOSE, seed, 60)))
    (run.folder / "logs" / "notes.txt").write_text("no mission", encoding="utf-8")
    (run.folder / "logs" / ".hidden" / "9.log").write_text("not looked at", encoding="utf-8")
    words = ("audit", "crane.exo", "logs", "--engine", "tables", "--format", "json")
    said = [run(*words, "--jobs", jobs, "--out", f"{jobs}.parquet") for jobs in (1, 3)]
    assert said[0].stdout == said[1].stdout and said[0].returncode == 2  # clients have asked for what is not there
    assert [each["mission"] for each in json.loads(said[0].stdout)["missions"]] == [f"logs/{k}.log" for k in range(4)]
    assert (run.folder / "1.parquet").read_bytes() == (run.folder / "3.parquet").read_bytes()


def test_all_rows_as_parquet(run: Run) -> None:
    pq = pytest.importorskip("pyarrow.parquet")
    assert run("audit", "crane.exo", "m.jsonl", "--out", "found/rows.parquet", "--engine", "tables").returncode == 1
    rows = pq.read_table(run.folder / "found" / "rows.parquet").to_pylist()
    assert [
        (row["line"], row["kind"], row["request"], row["instance"], row["answer"], row["rule"]) for row in rows
    ] == [
        (1, "ask", "slew.turn", None, "launch", None),
        (2, "ask", "hoist.lift", None, "wait", "one"),
        (2, "launched", "hoist.lift", 0, "wait", "one"),
    ]
    assert {row["mission"] for row in rows} == {"m.jsonl"} and rows[0]["time"] == 1700000000


def test_a_mission_whose_name_is_no_text_has_rows(run: Run) -> None:
    pq = pytest.importorskip("pyarrow.parquet")
    (run.folder / "m.jsonl").rename(run.folder / "m\udcff.jsonl")
    done = run("audit", "crane.exo", ".", "--out", "rows.parquet", "--engine", "tables")
    assert (done.returncode, done.stderr) == (1, "")
    rows = pq.read_table(run.folder / "rows.parquet").to_pylist()
    assert {row["mission"] for row in rows} == {"./m\\udcff.jsonl", "./well.jsonl"}


def test_mistakes_are_placed_and_what_can_be_audited_is(run: Run) -> None:
    odd = [
        '{"ask": "slew.trun"}',
        "{",
        LINES[0],
        '{"observe": "wnd", "value": 1}',
        '{"ask": "hoist.lift", "args": {"load": 99}}',
    ]
    (run.folder / "odd.jsonl").write_text("\n".join(odd), encoding="utf-8")
    (run.folder / "text.jsonl").write_text("spec crane;\n", encoding="utf-8")
    done = run("audit", "crane.exo", "missing.jsonl", "odd.jsonl", "text.jsonl", "well.jsonl")
    assert done.returncode == 2
    told_of = [line.removeprefix("exover: error: ") for line in done.stderr.splitlines()]
    assert told_of == [
        "missing.jsonl: it cannot be read: No such file or directory",
        "odd.jsonl:1: unknown-request: there is no request `slew.trun`; did you mean `slew.turn`?",
        told_of[2],
        "odd.jsonl:4: unknown-poster: there is no poster or consumable resource `wnd`; did you mean `wind`?",
        "text.jsonl: no line of it is an event: write one JSON object a line",
    ]
    assert told_of[2].startswith("odd.jsonl:2: bad-event: the line is not JSON: ")
    assert done.stdout.endswith("crane: 4 missions, 5 events; nothing diverges; 3 mistakes; 2 not audited\n")


def test_a_mission_from_standard_input(run: Run) -> None:
    done = run("audit", "crane.exo", "-", "--engine", "tables", input="\n".join(LINES))
    assert done.returncode == 1 and done.stdout.startswith("<stdin>: 2 events, 1 divergence")
    assert run("audit", "-", "-", input="").returncode == 2


def test_what_is_undecided_is_status_3(run: Run) -> None:
    done = run("audit", "crane.exo", "-", "--engine", "tables", input='{"launch": "hoist.lift"}')
    assert done.returncode == 3
    assert "  note: 1 launch undecided: no arguments are recorded\n" in done.stdout
    assert done.stdout.endswith("crane: 1 mission, 0 events; nothing diverges; 1 launch undecided\n")


def test_without_a_compiler(run: Run) -> None:
    with patch("exover.cli.audit.compile_library", side_effect=NativeUnavailable("no C compiler is there")):
        done = run("audit", "crane.exo", "m.jsonl")
        assert done.returncode == 1
        assert done.stderr == "exover: note: the tables are walked in Python, which is slower: no C compiler is there\n"
        assert run("audit", "crane.exo", "m.jsonl", "--engine", "c").returncode == 2


@pytest.mark.parametrize(
    ("words", "reason"),
    (
        (("empty",), "empty holds no mission: their names end as "),
        (("m.jsonl", "--out", "m.jsonl/rows.parquet"), "cannot write m.jsonl/rows.parquet: "),
        (("m.jsonl", "--out", "loop"), "cannot write loop: Too many levels of symbolic links"),
        (("m.jsonl", "--out", os.devnull), f"cannot write {os.devnull}: it is no regular file"),
        (("m.jsonl", "--bind", "crane.exo"), "crane.exo has "),
    ),
)
def test_what_cannot_be_done(run: Run, words: tuple[str, ...], reason: str) -> None:
    pytest.importorskip("pyarrow")
    (run.folder / "empty").mkdir()
    (run.folder / "loop").symlink_to("loop")
    before = sorted(run.folder.iterdir())
    done = run("audit", "crane.exo", *words, "--engine", "tables")
    assert done.returncode == 2 and reason in done.stderr
    assert sorted(run.folder.iterdir()) == before


def test_what_cannot_be_read_in_a_folder_keeps_nothing_else_from_being_audited(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    (run.folder / "locked").mkdir()
    (run.folder / "round").symlink_to(".")
    (run.folder / "loop.jsonl").symlink_to("loop.jsonl")
    real = os.listdir

    def listdir(path: str) -> list[str]:
        if os.path.basename(path) == "locked":
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)
        return real(path)

    monkeypatch.setattr(os, "listdir", listdir)
    done = run("audit", "crane.exo", ".", "--engine", "tables")
    assert (done.returncode, done.stderr.splitlines()) == (
        2,
        [
            "exover: error: ./locked: it cannot be read: Permission denied",
            "exover: error: ./loop.jsonl: it cannot be read: Too many levels of symbolic links",
        ],
    )
    assert "./m.jsonl: 2 events" in done.stdout and "crane: 4 missions, 3 events; " in done.stdout


def test_a_package_that_is_missing(run: Run) -> None:
    with patch("exover.cli.audit.find_spec", return_value=None):
        done = run("audit", "crane.exo", "m.jsonl", "--out", "rows.parquet")
        assert (done.returncode, done.stderr) == (
            2,
            "exover: error: Parquet needs pyarrow: pip install 'exover[audit]'\n",
        )
        assert "pip install 'exover[ros]'" in run("audit", "crane.exo", "m.mcap").stderr


# ---- the page ----


def test_the_page_holds_an_audit(run: Run) -> None:
    audit = run("audit", "crane.exo", "m.jsonl", "--format", "json", "--engine", "tables").stdout
    (run.folder / "audit.json").write_text(audit, encoding="utf-8")
    done = run(
        "report", "crane.exo", "--out", "report.html", "--audit", "audit.json", "--only", "tables", "--jobs", "1"
    )
    assert "./report.html" in done.stdout
    page = (run.folder / "report.html").read_text(encoding="utf-8")
    assert '"audit":{"tool":"exover"' in page and "the tables let it wait [one]" in page


FIGURES = {"asks": {"slew.turn": {"launch": 1, "wait": 0, "reject": 0, "invalid": 0}}, "rules": {"one": 1}}
MISSION = {
    "mission": "m",
    "events": 3,
    **FIGURES,
    "diverged": {"launched": 1},
    "divergences": [{"line": 3, "text": "launched"}],
    "mistakes": [],
    "mistake_count": 0,
    "notes": [],
}
AUDIT = {
    "tool": "exover",
    "audit": "crane",
    "sha256": digest(built(CRANE)[0]).hex(),
    "outcome": "",
    "missions": [MISSION, {"mission": "n", "error": "it is none"}],
    "total": FIGURES,
}
NO_JSON = "audit.json is no JSON: print the audit with --format json"
NO_AUDIT = "audit.json is no audit: print one with `exover audit --format json`"


def audit_with(**other: object) -> str:
    """Return the text of an audit of two missions in which something is another."""
    return json.dumps({**AUDIT, **other})


def mission_with(**other: object) -> str:
    return audit_with(missions=[{**MISSION, **other}])


@pytest.mark.parametrize(
    ("content", "reason"),
    (
        ("{", NO_JSON),
        ("[" * 100_000, NO_AUDIT),
        (audit_with(time=float("inf")), NO_JSON),
        (audit_with(time=float("nan")), NO_JSON),
        (audit_with(time=7).replace("7", "1e999"), NO_JSON),
        ("[]", NO_AUDIT),
        (audit_with(tool="other"), NO_AUDIT),
        (audit_with(sha256=None), NO_AUDIT),
        (audit_with(missions=[1]), NO_AUDIT),
        (audit_with(missions={}), NO_AUDIT),
        (audit_with(total={"asks": {}, "rules": 5}), NO_AUDIT),
        (audit_with(total={"asks": [], "rules": {}}), NO_AUDIT),
        (audit_with(total={"asks": {"a": {"launch": 1}}, "rules": {}}), NO_AUDIT),
        (audit_with(total={"asks": {}, "rules": {"one": None}}), NO_AUDIT),
        (audit_with(missions=[{"mission": "m"}]), NO_AUDIT),
        (audit_with(missions=[{"mission": "m", "error": 3}]), NO_AUDIT),
        (audit_with(missions=[{"mission": "m", "error": ""}]), NO_AUDIT),
        (mission_with(asks=[]), NO_AUDIT),
        (mission_with(rules=5), NO_AUDIT),
        (mission_with(events=-1), NO_AUDIT),
        (mission_with(events=1.5), NO_AUDIT),
        (mission_with(events=True), NO_AUDIT),
        (mission_with(events=777).replace("777", "9" * 5000), NO_AUDIT),
        (mission_with(diverged={"launched": "many"}), NO_AUDIT),
        (mission_with(divergences=[{"text": "launched"}]), NO_AUDIT),
        (mission_with(divergences={}), NO_AUDIT),
        (mission_with(mistakes=None), NO_AUDIT),
        (mission_with(notes=[3]), NO_AUDIT),
        (audit_with(audit="x"), "audit.json is an audit by the spec x, not crane"),
        (
            audit_with(sha256="0" * 64),
            "audit.json is an audit by another version of crane: audit the missions again",
        ),
    ),
)
def test_what_is_no_audit(run: Run, content: str, reason: str) -> None:
    assert shown_with(run, content) == (2, f"exover: error: {reason}\n")
    assert not (run.folder / "report.html").exists()


def test_an_audit_by_the_same_spec_is_shown_whatever_else_is_in_it(run: Run) -> None:
    status, _ = shown_with(run, audit_with(more={"deep": [7]}).replace("[7]", f"[{'9' * 5000}]"))
    assert status != 2
    page = (run.folder / "report.html").read_text(encoding="utf-8")
    assert '"rules":{"one":1}' in page and "deep" not in page.partition('"audit":')[2].partition('"graph":')[0]


def shown_with(run: Run, content: str) -> tuple[int, str]:
    """Return the status of a report with this file as an audit, and what is said to it."""
    (run.folder / "audit.json").write_text(content, encoding="utf-8")
    words = ("--audit", "audit.json", "--only", "tables", "--jobs", "1")
    done = run("report", "crane.exo", "--out", "report.html", *words)
    return done.returncode, done.stderr


@pytest.mark.parametrize("engine", ("c", "tables", "reference"))
@pytest.mark.parametrize("time", ("1e999", "-1e999", "9" * 500, "NaN", "Infinity"))
def test_a_time_that_is_not_finite_is_a_mistake(run: Run, engine: str, time: str) -> None:
    lines = [line.replace("1700000001.25", time) for line in LINES]
    (run.folder / "odd.jsonl").write_text("\n".join(lines), encoding="utf-8")
    done = run("audit", "crane.exo", "odd.jsonl", "--format", "json", "--engine", engine)
    said = "out-of-range: `time` is no finite number of seconds"
    assert (done.returncode, done.stderr) == (2, f"exover: error: odd.jsonl:2: {said}\n")
    found = json.loads(done.stdout, parse_constant=pytest.fail)
    (mission,) = found["missions"]
    assert mission["mistakes"] == [{"line": 2, "text": said}] and mission["events"] == 2
    assert [(each["line"], "time" in each) for each in mission["divergences"]] == [(2, False)]
