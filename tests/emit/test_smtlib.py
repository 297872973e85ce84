"""What is asked, as SMT-LIB 2: Z3 reads the text, and its answers are those of the checks."""

import re
from collections.abc import Sequence
from functools import cache
from itertools import count
from pathlib import Path
from time import monotonic

import pytest

from exover.checks.questions import claims
from exover.cli.main import main
from exover.emit import smtlib
from exover.engines.smt import smtlib_queries, solver
from exover.engines.smt.ag_ef import AlwaysPossible
from exover.engines.smt.solver import Inconclusive
from exover.engines.smt.unrolling import Taken
from exover.model.property import NO_PROPERTIES
from exover.pipeline import load_properties
from exover.source import Source
from tests.support.command import Run, environment
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.small import compiled, small_spec_of

FLAWED = """spec flawed;
poster a: int in 0 .. 100 = 0;
poster x: real in 0 .. 1 = 0.1;
module m {
    request r(v: real in 0 .. 1) { check enough: v > 0.5 and x < 1; }
    request never() { check no: a > 7 and a < 3; }
}
forbid both: active(m.r) and a >= 99;
"""


STARVING = """spec starving;
poster hot: bool = false; poster s: int in 0 .. 3 = 0; poster e: {t, start} = t;
module m {
    request long(n: int in 0 .. 3) { wait until not hot; fail when s == 2; }
    request short() { wait until not active(m.long); }
    request stuck() { wait until past(m.never); }
    request never() { check s > 2 and s < 1; }
    request lost() { check not past(m.long); }
}
launch go: m.short() when e == start;
"""
PROPERTIES = """for starving;
property way: always possible active(m.long);
property served: always (waiting(m.short) leads to not waiting(m.short));
property trap: from past(m.long) possible launched(m.lost);
property cooled: ltl G (hot -> F (!hot));
property long_first: ctl A [!active(m.short) U active(m.long)];
"""
Ways = list[Sequence[Taken]] | None
SAYS = re.compile(r"\b((?:all )?(?:un)?sat): (it holds|it is violated)")
VERDICTS = {"it holds": "holds", "it is violated": "violated"}


def answers(text: str) -> list[tuple[str, str, str]]:
    """Return what Z3 answers to each question: the claim, what is asked with what answers say, and the answer."""
    import z3

    context = z3.Context()
    said = z3.Z3_eval_smtlib2_string(context.ref(), text)
    assert "error" not in said and "unknown" not in said, said
    return re.findall(r"^(.+?): (.*)\n(sat|unsat)$", said, re.MULTILINE)


@cache
def decided(text: str) -> dict[str, set[str]]:
    """Return by claim what the answers decide, as the text itself says."""
    found: dict[str, set[str]] = {}
    idle: dict[str, bool] = {}
    for name, asked_, answer in answers(text):
        idle[name] = idle.get(name, True) and (answer == "unsat" or "while the run stays" not in asked_)
        for decisive, verdict in SAYS.findall(asked_):
            if decisive == answer or (decisive == "all unsat" and answer == "unsat" and idle[name]):
                found.setdefault(re.sub(r" \(\d+\)$", "", name), set()).add(VERDICTS[verdict])
    return found


@cache
def asked(spec: str, properties: str = "", check: str = "") -> tuple[str, dict[str, str]]:
    """Return the text of what is asked of a spec, of one check if it is named, and what the checks answer."""
    made = compiled(model_of(spec))
    assumed = NO_PROPERTIES
    if properties:
        loaded = load_properties(Source("x.prop", properties), made.model).properties
        assert loaded is not None
        assumed = loaded
    said = tuple(claim for claim in claims(made.model, assumed) if check in ("", claim.check))
    (artefact,) = smtlib.emit(made, assumed, said)
    findings = check_by_diagrams(made, {check} if check else None, assumed).findings
    return artefact.content.decode(), {f"{each.check} {each.subject}": each.verdict for each in findings}


@pytest.mark.parametrize(
    ("spec", "properties", "least"),
    [(FLAWED, "", 12), (small_spec_of(4), "", 12), (STARVING, PROPERTIES, 30), (small_spec_of(7), "", 17)],
    ids=("flawed", "small", "starving", "more"),
)
def test_answers_are_those_of_the_checks(spec: str, properties: str, least: int) -> None:
    text, verdicts = asked(spec, properties)
    found = decided(text)
    for name, said in found.items():
        assert said == {verdicts[name]}, name
    assert len(found) >= least, verdicts.keys() - found.keys()
    for name in verdicts:
        assert f"; ---- {name} ----" in text


def test_what_branches_and_what_lasts_is_decided_too() -> None:
    text, verdicts = asked(STARVING, PROPERTIES)
    found = decided(text)
    for name in ("deadlock m.short", "lockout m.long", "starvation m.long", "starvation m.short", "property way"):
        assert found[name] == {verdicts[name]}, name
    assert {verdicts["starvation m.long"], verdicts["starvation m.short"]} == {"holds", "violated"}
    for name in ("property served", "property cooled", "property long_first"):
        assert found[name] == {verdicts[name]}, name
    assert "; Not asked: no ways were found" in text.split("---- lockout m.never ----")[1].split("----")[0]
    assert "; Not asked here: what it asks is not said" in text.split("---- tables ask m.long ----")[1].split("----")[0]


def test_assumptions_that_allow_nothing_are_written_down() -> None:
    text, _ = asked(FLAWED, "for flawed; assume never (a >= 0);")
    assert ("assumptions", "sat") in [(name, answer) for name, _, answer in answers(text)]


def test_a_run_that_may_not_go_on_fairly_decides_nothing() -> None:
    """No fair run launches `m.long`, of which every report is forbidden."""
    assumed = "for starving; assume fair reports; assume never ended(m.long);"
    text, verdicts = asked(STARVING, f"{assumed} property never_long: never active(m.long);", "property")
    assert verdicts["property never_long"] == "holds"
    assert "sat, if these runs can go on fairly: it is violated" in text
    assert decided(text).get("property never_long", set()) <= {"holds"}


def test_the_text_names_what_it_is_about() -> None:
    text, _ = asked(FLAWED)
    for part in (
        "; ---- safety both ----",
        "(|m.r[0].v| Real)",
        "(|ask m.r: v| Real)",
        "(define-fun step ",
        "|next a|",
    ):
        assert part in text


def test_every_process_writes_the_same(tmp_path: Path, run: Run) -> None:
    """Which ways are found hangs on what Z3 was asked before, and on nothing else."""
    (tmp_path / "flawed.exo").write_text(FLAWED)
    for seed in ("1", "2"):
        env = environment(PYTHONHASHSEED=seed)
        assert run("emit", "flawed.exo", "--target", "smt2", "--out", seed, env=env).returncode == 0
    first, second = ((tmp_path / seed / "flawed.smt2").read_text() for seed in ("1", "2"))
    assert first == second and "way 0|" in first


def test_a_process_writes_the_same_again(tmp_path: Path, run: Run) -> None:
    (tmp_path / "flawed.exo").write_text(FLAWED)
    for out in ("1", "2"):
        assert run("emit", "flawed.exo", "--target", "smt2", "--out", out).returncode == 0
    first, second = ((tmp_path / out / "flawed.smt2").read_text() for out in ("1", "2"))
    assert first == second and "way 0|" in first


def test_a_busy_machine_writes_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    made = compiled(model_of(FLAWED))
    said = tuple(claim for claim in claims(made.model, NO_PROPERTIES) if claim.check in ("deadlock", "lockout"))
    texts = [smtlib.emit(made, NO_PROPERTIES, said)[0].content.decode()]
    for module in (solver, smtlib_queries):
        monkeypatch.setattr(module, "monotonic", count(step=1000).__next__, raising=False)
    texts.append(smtlib.emit(made, NO_PROPERTIES, said)[0].content.decode())
    assert texts[0] == texts[1] and "way 0|" in texts[0]


def test_a_search_ends_after_so_many_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    made = compiled(model_of(FLAWED))
    said = tuple(claim for claim in claims(made.model, NO_PROPERTIES) if claim.check == "lockout")
    (artefact,) = smtlib.emit(made, NO_PROPERTIES, said)
    assert "way 0|" in artefact.content.decode()
    monkeypatch.setattr(smtlib_queries, "MOST", 10_000)
    (artefact,) = smtlib.emit(made, NO_PROPERTIES, said)
    assert "; Not asked: no ways were found" in artefact.content.decode()
    assert "way 0|" not in artefact.content.decode()


def test_where_a_search_is_cut_off_changes_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    """The time of a search ends sooner on one machine than on another; ways of later questions are the same."""
    fewer = STARVING.replace("request lost() { check not past(m.long); }", "")
    made, ways = compiled(model_of(fewer)), AlwaysPossible.ways
    said = tuple(claim for claim in claims(made.model, NO_PROPERTIES) if claim.check in ("deadlock", "lockout"))
    texts = []
    for is_late in (False, True):
        searches: list[AlwaysPossible] = []

        def cut_off(search: AlwaysPossible, searches: list[AlwaysPossible] = searches, at_once: bool = is_late) -> Ways:
            searches.append(search)
            if len(searches) > 1:
                return ways(search)
            if not at_once:
                ways(search)
            raise Inconclusive("time limit")

        monkeypatch.setattr(AlwaysPossible, "ways", cut_off)
        (artefact,) = smtlib.emit(made, NO_PROPERTIES, said)
        assert len(searches) > 5
        texts.append(artefact.content.decode())
    assert texts[0] == texts[1] and "way 0|" in texts[0]


def test_a_spec_that_fails_can_be_asked_about(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "flawed.exo").write_text(FLAWED)
    assert main(["emit", str(tmp_path / "flawed.exo"), "--target", "smt2", "--out", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'out' / 'flawed.smt2'}\n"
    assert (tmp_path / "out" / "flawed.smt2").read_text().startswith("; The closed loop of the spec flawed")


@pytest.mark.parametrize("target", ["smt2", "smv", "c,smt2"])
def test_the_time_limit_is_kept(target: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = Path(__file__).parents[1] / "specs" / "planetary_rover.exo"
    unchecked = ["--unchecked"] if "c" in target.split(",") else []
    begun = monotonic()
    status = main(
        ["emit", str(spec), "--target", target, *unchecked, "--out", str(tmp_path / "made"), "--timeout", "1"]
    )
    assert monotonic() - begun < 20, "Z3 at work was told to end"
    assert status == 3
    assert f"time limit of 1 s: it was over before {target.replace(',', ', ')} could be" in capsys.readouterr().err
    assert not (tmp_path / "made").exists()
