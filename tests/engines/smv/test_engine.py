"""NuSMV says of claims what the decision diagrams say, and shows runs that the reference interpreter has."""

from dataclasses import replace
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from exover.checks.questions import claims
from exover.engines.aig.passes import enough_passes
from exover.engines.process import NotRunnable, run
from exover.engines.smv import engine, find
from exover.engines.smv.engine import NuSmv
from exover.engines.smv.program import ProgramAnswers, ask, environment, in_wheel
from exover.engines.smv.text import Text, looped
from exover.loop.claim import APPROXIMATE, Claim
from exover.model.expression import Compare, Const, Reading
from exover.model.model import NOWHERE
from exover.model.property import (
    FALSE,
    NO_PROPERTIES,
    TRUE,
    Assumption,
    Atom,
    Conjunction,
    Happened,
    Negation,
    Next,
    Properties,
    all_always,
    all_until,
    implies,
    some_finally,
)
from exover.model.trace import Disagreement
from exover.ocrd.compile import Compiled
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.judging import judged
from tests.support.needed import needs_nusmv
from tests.support.small import compiled, small_spec_of

pytestmark = needs_nusmv
SECONDS = 60.0
SEEDS = (4, 42, 51, 112)
"""Of others tests/agreement/test_all_engines.py says that NuSMV, the diagrams and plain enumeration agree."""
FEWER = (110, 216)
"""Of which runs need fewer passes than what no run comes to."""
TOTAL = "read_model -i model.smv\ngo\ncheck_fsm\nquit\n"
STARVING = """spec s; poster hot: bool = false;
module a { request r() { wait until not hot; } request q() { check not hot; } }
launch go: a.q() when hot;
"""
REFUSED_LATE = """spec s; module m { state ok: bool = false;
    request a() { check ok; }
    request b() { wait until not active(m.c); }
    request c() { check not active(m.b); } }
launch go: m.a() when active(m.b);
"""
"""Where the report of c starts b, the launch of a is required and refused, which changes no state."""
WORDS_ALL_OVER = """spec F; poster init: bool = false; poster idle: {A, X} = A; poster G: int in 0 .. 9 = 3;
module next {
    state mod: bool = false;
    request esac() { wait until not init; on ok set mod = true; }
    request case(G: {EF, xor}) { interrupts self; check U: idle == A; }
}
module update { poster union: real in 0 .. 5 = 1; request start() { fail V: when union > 3; } }
mutex H: next.case, update.start;
launch O: update.start() when G == 7;
"""
WORDS_OF_THE_TEXT = """spec s; poster goes_on: bool = false;
module enabled { request r() { check not goes_on; on ok set Word.ITYPE = true; } }
module Word { state ITYPE: bool = false; request q() { check ITYPE; } }
"""


@pytest.mark.parametrize(("seed", "fewer"), [*((seed, False) for seed in SEEDS), *((seed, True) for seed in FEWER)])
def test_nusmv_says_what_the_diagrams_say(seed: int, fewer: bool) -> None:
    spec = small_spec_of(seed)
    made = compiled(model_of(spec))
    properties = Formulas(Random(seed), made.model).properties(2, seed % 3)
    enough = enough_passes(made, properties) if fewer else None
    assert enough is None or enough + 1 < Text(looped(made, properties, ()), (), False).passes
    asked = [claim for claim in claims(made.model, properties) if claim.formula is not None]
    opinions = NuSmv(made, properties, find(), SECONDS, enough).judge_all(asked)
    for claim, opinion, holds in zip(asked, opinions, judged(made, properties, asked), strict=True):
        if opinion.message != "the assumptions contradict each other, so it is about nothing":
            wanted = "holds" if holds else "violated"
            assert opinion.verdict == wanted, f"{spec}\n{properties}\n{claim}\n{opinion}"


ONE_VALUE = """spec s; poster five: int in 5 .. 5 = 5; poster a: {A} = A; poster q: int in 0 .. 9 = 3;
module m { state s: int in 2 .. 2 = 2; request r(n: int in 2 .. 2, k: int in 0 .. 3) {
    check sum: n + k + five + s <= 10; check q + five < 13; on ok set s = 2; } }
launch go: m.r(2, 1) when q + five == 7 and a == A;
"""


@pytest.mark.parametrize("assumed", [False, True])
def test_what_has_one_value_is_no_variable(assumed: bool) -> None:
    """NuSMV makes a constant of it, and refuses a text that assigns one."""
    made = compiled(model_of(ONE_VALUE))
    five = Atom(Compare("==", Reading("five"), Const(5)))
    properties = Properties((), (Assumption(five, NOWHERE),) if assumed else (), fair=assumed)
    asked = [claim for claim in claims(made.model, properties) if claim.formula is not None]
    opinions = NuSmv(made, properties, find(), SECONDS).judge_all(asked)
    for claim, opinion, holds in zip(asked, opinions, judged(made, properties, asked), strict=True):
        assert opinion.verdict == ("holds" if holds else "violated"), f"{claim}\n{opinion}"


def test_how_reals_compare_in_a_step_is_declared_where_no_state_keeps_it() -> None:
    """NuSMV reads no text with a value that nothing has."""
    made = compiled(model_of("spec s; poster p: real = 0; module m { request r(x: real in 0 .. 1) { check x > p; } }"))
    asked = [claim for claim in claims(made.model, NO_PROPERTIES) if claim.check == "lockout"]
    opinions = NuSmv(made, NO_PROPERTIES, find(), SECONDS).judge_all(asked)
    assert asked and {opinion.message for opinion in opinions} <= {"", APPROXIMATE}


def test_an_answer_of_several_lines_is_read() -> None:
    """A sum of an enumerated number is printed as a `case` in lines of its own."""
    text = """spec s; poster a: int in 0 .. 2 = 0; poster b: int in 0 .. 2 = 1; poster c: int in 0 .. 2 = 1;
    module m { request r() { check a + b > c + 1; } } launch go: m.r() when a + c >= 2 * b + 1;"""
    made = compiled(model_of(text))
    asked = [claim for claim in claims(made.model, NO_PROPERTIES) if claim.formula is not None]
    opinions = NuSmv(made, NO_PROPERTIES, find(), SECONDS).judge_all(asked)
    for claim, opinion, holds in zip(asked, opinions, judged(made, NO_PROPERTIES, asked), strict=True):
        wanted = "holds" if holds else "violated"
        assert opinion.verdict == wanted, f"{claim}\n{opinion}"


def test_a_loop_with_one_event_has_runs_too() -> None:
    made = compiled(replace(model_of("spec s; poster p: int in 5 .. 5 = 5; module m { request r(); }"), requests=()))
    five = Atom(Compare("==", Reading("p"), Const(5)))
    opinion = NuSmv(made, NO_PROPERTIES, find(), SECONDS).judge(Claim("property", "x", Negation(some_finally(five))))
    assert opinion.verdict == "violated"
    claim = Claim("property", "y", Next(Negation(five)), linear=True)
    opinion = NuSmv(made, NO_PROPERTIES, find(), SECONDS).judge(claim)
    assert opinion.verdict == "violated" and opinion.trace is not None and len(opinion.trace.moments) >= 1


def test_runs_that_end_and_runs_that_repeat_are_shown() -> None:
    made = compiled(model_of(STARVING))
    opinions = {claim.check: NuSmv(made, NO_PROPERTIES, find(), SECONDS).judge(claim) for claim in _about(made)}
    assert opinions["starvation"].verdict == opinions["obligation"].verdict == "violated"
    lasso, run = opinions["starvation"].trace, opinions["obligation"].trace
    assert lasso is not None and lasso.loop_start is not None
    assert run is not None and run.loop_start is None and len(run.moments) == 1


def test_a_run_is_shown_that_breaks_until() -> None:
    made = compiled(model_of(STARVING))
    hot, asked = Atom(Compare("==", Reading("hot"), Const(True))), Happened("asked", "a.r")
    claim = Claim("property", "p", all_until(Negation(hot), Conjunction((asked, hot))))
    opinion = NuSmv(made, NO_PROPERTIES, find(), SECONDS).judge(claim)
    assert opinion.verdict == "violated" and opinion.trace is not None and len(opinion.trace.moments) >= 1


def test_a_run_is_shown_where_no_event_matters() -> None:
    made = compiled(model_of("spec s; poster b: bool = false; module m { request a(); } forbid f: b or not b;"))
    (claim,) = (claim for claim in claims(made.model, NO_PROPERTIES) if claim.check == "completeness")
    opinion = NuSmv(made, NO_PROPERTIES, find(), SECONDS).judge(claim)
    assert opinion.verdict == "violated" and opinion.trace is not None and len(opinion.trace.moments) == 1


def test_a_run_that_the_reference_does_not_have_is_a_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    made = compiled(model_of(STARVING))
    (claim,) = (claim for claim in _about(made) if claim.check == "obligation")

    def damaged(program: str, model: str, *others: Any) -> ProgramAnswers:
        assert "init(q$0) := idle" in model
        return ask(program, model.replace("init(q$0) := idle", "init(q$0) := stopping"), *others)

    monkeypatch.setattr(engine, "ask", damaged)
    with pytest.raises(Disagreement, match="step 1 of what NuSMV shows is none of the reference"):
        NuSmv(made, NO_PROPERTIES, find(), SECONDS).judge(claim)


def test_what_changes_no_state_happens_in_the_emitted_text() -> None:
    made = compiled(model_of(REFUSED_LATE))
    asked = Claim("property", "p", some_finally(Conjunction((Happened("rejected", "m.a"), Happened("ended", "m.c")))))
    enough = enough_passes(made, NO_PROPERTIES)
    assert enough is not None
    assert NuSmv(made, NO_PROPERTIES, find(), SECONDS, enough).judge(asked).verdict == "holds"


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("fair", [False, True])
def test_every_state_of_the_text_has_a_next_one(seed: int, fair: bool) -> None:
    made = compiled(model_of(small_spec_of(seed)))
    properties = Formulas(Random(seed), made.model).properties(1, 1)
    asked = tuple(claims(made.model, properties))
    text = Text(looped(made, properties, asked), asked, fair)
    with TemporaryDirectory() as name:
        Path(name, "model.smv").write_text(text.render())
        Path(name, "script").write_text(TOTAL)
        ended = run([find(), "-source", "script"], Path(name), environment(Path(name)), SECONDS)
    assert ended.status == 0, ended.complained
    assert "The transition relation is total" in ended.printed


SCRIPTS = {
    "crashing": ("kill -SEGV $$", "was ended by SIGSEGV"),
    "killed": ("kill -9 $$", "was ended by SIGKILL"),
    "refusing": ("exit 255", "ended with status 255"),
    "rubbish": ("head -c 100000 /dev/urandom | tee 0.txt", "NuSMV says nothing of it"),
    "complaining": ("echo 'no such thing' >&2; exit 3", "ended with status 3: no such thing"),
    "silent": ("exit 0", "NuSMV says nothing of it"),
    "slow": ("sleep 60", "took longer than 0.5 s"),
    "half": ("printf '%s\\n' '-- specification x  is false' '<counter-example' > 0.txt", "NuSMV says nothing of it"),
}


@pytest.mark.parametrize("kind", SCRIPTS)
def test_of_a_program_that_fails_nothing_is_believed(kind: str, tmp_path: Path) -> None:
    script, reason = SCRIPTS[kind]
    program = tmp_path / "NuSMV"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    made = compiled(model_of("spec s; module m { request r(); }"))
    claim = next(claim for claim in claims(made.model, NO_PROPERTIES) if claim.check == "reachability")
    opinion = NuSmv(made, NO_PROPERTIES, find(str(program)), 0.5 if kind == "slow" else SECONDS).judge(claim)
    assert opinion.verdict == "unknown" and reason in opinion.message


@pytest.mark.parametrize("given", ["/nowhere/NuSMV", __file__, "/"])
def test_what_is_no_program_is_refused(given: str) -> None:
    with pytest.raises(NotRunnable, match="it is no program"):
        find(given)


def test_a_program_on_path_comes_before_that_of_the_wheel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "nuXmv").write_text("#!/bin/sh\n")
    (tmp_path / "nuXmv").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert find() == str(tmp_path / "nuXmv")
    monkeypatch.setenv("PATH", "")
    assert find() == str(in_wheel())


def test_assumptions_that_contradict_each_other_make_no_claim_true() -> None:
    made = compiled(model_of("spec s; poster p: bool = false; module m { request r(); }"))
    never = Assumption(FALSE, NOWHERE)
    claim = Claim("property", "x", TRUE, coherent=True)
    engine = NuSmv(made, Properties(assumptions=(never,)), find(), SECONDS)
    assert engine.judge(claim).verdict == "violated"
    assert engine.judge(Claim("reachability", "m.r", TRUE)).message.startswith("the assumptions contradict")


@pytest.mark.parametrize("text", [WORDS_ALL_OVER, WORDS_OF_THE_TEXT])
def test_names_that_mean_something_to_nusmv_or_the_text_are_still_names(text: str) -> None:
    made = compiled(model_of(text))
    assumed = Properties((), (Assumption(TRUE, NOWHERE),))
    asked = [claim for claim in claims(made.model, assumed) if claim.formula is not None]
    opinions = NuSmv(made, assumed, find(), SECONDS).judge_all(asked)
    assert [claim.subject for claim, each in zip(asked, opinions, strict=True) if each.verdict == "unknown"] == []


def _about(made: Compiled) -> list[Claim]:
    return [claim for claim in claims(made.model, NO_PROPERTIES) if claim.subject in ("a.r", "go")]


def test_a_latch_is_cleared_by_a_report_unless_its_condition_holds() -> None:
    made = compiled(model_of("spec s; poster hot: bool = true; module m { request r(); } latch l: when hot until m.r;"))
    hot, latched = (Atom(Compare("==", Reading(name), Const(True))) for name in ("hot", "l"))
    cleared = Conjunction((Happened("ended", "m.r"), Negation(latched)))
    formulas = (all_always(implies(hot, latched)), some_finally(cleared), all_always(Negation(cleared)))
    asked = [Claim("property", f"p{number}", formula) for number, formula in enumerate(formulas)]
    opinions = NuSmv(made, NO_PROPERTIES, find(), SECONDS).judge_all(asked)
    assert [opinion.verdict for opinion in opinions] == ["holds", "holds", "violated"]
