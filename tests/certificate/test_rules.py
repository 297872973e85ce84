"""Each rule of the checker accepts what is so, and refuses what is nearly so."""

from typing import Any

import pytest

from exover.certificate.check import Checker
from exover.certificate.proof import Proof
from exover.certificate.table import Refused, decode
from exover.pipeline import build
from tests.support.engines import model_of

SPEC = """spec rules;
module m {
    state lamp: int in 0 .. 3 = 0;
    request on() { check lamp < 2; on ok set lamp = 1; }
    request more() { check lamp == 1; on ok set lamp = 2; }
    request off() { check lamp > 0; on ok set lamp = 0; }
}
"""
Json = Any
ON, MORE, OFF = range(3)
DARK, LIT, BRIGHT = (f"(= reading.0 {value})" for value in range(3))
LAUNCHED = {slot: [["launch", slot, 0, -1]] for slot in (ON, MORE, OFF)}


@pytest.fixture(scope="module")
def checker() -> Checker:
    found = Checker(decode(build(model_of(SPEC)).data))
    found.induction(["(<= reading.0 2)"])
    return found


def step(event: list[Json], answers: Json = ()) -> Json:
    return {"event": event, "answers": list(answers)}


def done(request: int, outcome: int = 1) -> list[Json]:
    """Return the steps by which a request is launched and ends."""
    return [step(["ask", request, 0, []], LAUNCHED[request]), step(["report", request, outcome, []])]


def prove(
    checker: Checker, formula: Json, verdict: str, *parts: Json, fair: bool = False, linear: bool = False
) -> None:
    Proof(checker, {"formula": formula, "fair": fair, "linear": linear}, parts).check(verdict)


def refuse(checker: Checker, *said: Json, **options: bool) -> str:
    with pytest.raises((Refused, KeyError, TypeError)) as refused:  # `verify` refuses all of these
        prove(checker, *said, **options)
    return str(refused.value)


INVARIANT: Json = {"kind": "invariant"}
NOTHING: Json = {"kind": "layers", "layers": []}


def run(*steps: list[Json], **more: Json) -> Json:
    return {"kind": "run", "steps": [each for part in steps for each in part], "from": 0} | more


def closed(states: str) -> Json:
    return {"kind": "closed", "states": states}


def layers(*each: tuple[list[Json], str]) -> Json:
    return {"kind": "layers", "layers": [{"event": event, "states": states} for event, states in each]}


def ranking(*each: tuple[str | None, str]) -> Json:
    return {"kind": "ranking", "layers": [{"never": never, "states": states} for never, states in each]}


def test_what_is_invariant_is_never_so(checker: Checker) -> None:
    prove(checker, ["not", ["EU", "true", "(= reading.0 3)"]], "holds", INVARIANT)
    prove(checker, ["EX", "(= reading.0 3)"], "violated", INVARIANT)
    refuse(checker, ["not", ["EU", "true", BRIGHT]], "holds", INVARIANT)
    refuse(checker, ["EU", "true", "(= reading.0 3)"], "holds", INVARIANT)


def test_the_start_is_looked_at_by_itself(checker: Checker) -> None:
    refuse(checker, ["not", ["EU", "true", f"(and start {DARK})"]], "holds", INVARIANT)
    prove(checker, ["EU", "true", DARK], "holds", NOTHING)
    prove(checker, ["EX", ["EU", "true", "start"]], "violated", None, INVARIANT)
    prove(checker, DARK, "holds")
    refuse(checker, DARK, "violated")


def test_polarity_decides_which_bound_is_wanted(checker: Checker) -> None:
    lit = ["EU", "true", LIT]
    prove(checker, lit, "holds", run(done(ON)))
    refuse(checker, ["not", lit], "holds", run(done(ON)))
    prove(checker, ["not", lit], "violated", run(done(ON)))
    refuse(checker, lit, "violated", run(done(ON)))
    refuse(checker, lit, "holds", closed("true"))
    refuse(checker, lit, "violated", NOTHING)
    prove(checker, ["or", "false", ["and", DARK, lit], ["EX", BRIGHT]], "holds", run(done(ON)), NOTHING)
    refuse(checker, ["and", DARK, lit, ["EX", BRIGHT]], "holds", run(done(ON)), NOTHING)


def test_a_run_shows_what_it_comes_to(checker: Checker) -> None:
    prove(checker, ["EU", DARK, LIT], "holds", run(done(ON)))
    prove(checker, ["EX", "asked.0"], "holds", run(done(ON)[:1]))
    prove(checker, ["EX", ["EU", DARK, LIT]], "holds", None, run(done(ON)))
    refuse(checker, ["EX", LIT], "holds", run(done(ON)))
    refuse(checker, ["EU", "(= phase.0 0)", LIT], "holds", run(done(ON)))
    refuse(checker, ["EU", DARK, BRIGHT], "holds", run(done(ON), done(MORE)))
    refuse(checker, ["EU", "true", BRIGHT], "holds", run(done(MORE)))
    refuse(checker, ["EU", "true", LIT], "holds", run(done(ON, outcome=2)))
    refuse(checker, ["EU", "true", LIT], "holds", run(done(ON), **{"from": 2}))
    refuse(checker, ["EU", "true", LIT], "holds", run(done(ON), **{"from": 1}))


def test_what_follows_a_run_is_asked_of_its_last_moment(checker: Checker) -> None:
    dark_for_good = ["and", LIT, ["not", ["EX", DARK]]]
    never = closed(f"(or {DARK} (not (= phase.2 0)))")
    prove(checker, ["EU", "true", dark_for_good], "holds", run(done(ON)), never)
    refuse(checker, ["EU", "true", dark_for_good], "holds", run(done(ON), done(OFF)[:1]), never)
    later = run(done(ON), done(MORE), **{"from": 2})
    prove(checker, ["EU", "true", ["and", LIT, ["EU", LIT, BRIGHT]]], "holds", run(done(ON)), later)
    refuse(checker, ["EU", "true", ["and", LIT, ["EU", LIT, BRIGHT]]], "holds", run(done(ON)), later | {"from": 3})


def test_a_closed_set_is_never_entered(checker: Checker) -> None:
    bright = ["EU", f"(not {LIT})", BRIGHT]
    prove(checker, bright, "violated", closed(f"(or {BRIGHT} (not (= phase.1 0)))"))
    refuse(checker, ["EU", "true", BRIGHT], "violated", closed(f"(or {BRIGHT} (not (= phase.1 0)))"))
    refuse(checker, bright, "violated", closed("false"))
    refuse(checker, bright, "violated", closed(f"(or {BRIGHT} (= phase.1 1))"))
    refuse(checker, bright, "violated", closed("(not (= phase.1 0))"))
    refuse(checker, bright, "violated", closed("true"))
    refuse(checker, ["EX", "launch.1"], "violated", closed("false"))
    prove(checker, ["EX", "launch.1"], "violated", closed(LIT))
    refuse(checker, ["EX", "launch.1"], "violated", closed(BRIGHT))


OUT = ["report", OFF, 1, []]
ASK = ["ask", OFF, 0, []]
ABLE = [(OUT, "(not (= phase.2 0))"), (ASK, f"(not {DARK})")]
"""Layers from which the lamp can be switched off."""


def test_layers_lead_to_the_goal(checker: Checker) -> None:
    always = ["not", ["EU", "true", ["not", ["or", DARK, ["EU", "true", DARK]]]]]
    prove(checker, always, "holds", INVARIANT, layers(*ABLE))
    refuse(checker, always, "holds", INVARIANT, layers(*reversed(ABLE)))
    refuse(checker, always, "holds", INVARIANT, layers(ABLE[0]))
    refuse(checker, always, "holds", INVARIANT, layers(ABLE[0], (ASK, LIT)))
    refuse(checker, always, "holds", INVARIANT, layers(ABLE[0], (["ask", ON, 0, []], f"(not {DARK})")))
    refuse(checker, always, "holds", INVARIANT, layers((OUT, "true")))


def test_layers_stay_where_they_must(checker: Checker) -> None:
    def always(stay: str) -> Json:
        return ["not", ["EU", "true", ["not", ["or", DARK, ["EX", ["EU", stay, f"(and {DARK} {stay})"]]]]]]

    prove(checker, always("(not abort)"), "holds", INVARIANT, None, layers(*ABLE))
    refuse(checker, always("(not ended.2)"), "holds", INVARIANT, None, layers(*ABLE))
    refuse(checker, always("(not launch.2)"), "holds", INVARIANT, None, layers(*ABLE))


def test_a_next_has_layers_of_one_step(checker: Checker) -> None:
    launched = ["not", ["EU", "true", ["not", ["or", f"(not (and {LIT} (= phase.2 0)))", ["EX", "launch.2"]]]]]
    prove(checker, launched, "holds", INVARIANT, layers((ASK, f"(and {LIT} (= phase.2 0))")))
    refuse(checker, launched, "holds", INVARIANT, layers((ASK, LIT)))
    prove(checker, ["EX", "launch.0"], "holds", layers((["ask", ON, 0, []], "start")))
    refuse(checker, ["EX", "launch.2"], "holds", layers((ASK, "start")))
    refuse(checker, launched, "holds", INVARIANT, None)


AGAIN = done(ON) + done(OFF)


def test_a_lasso_goes_on_for_ever(checker: Checker) -> None:
    prove(checker, ["EG", f"(not {BRIGHT})"], "holds", run(done(ON), AGAIN[2:], AGAIN, loop=4))
    refuse(checker, ["EG", f"(not {BRIGHT})"], "holds", run(AGAIN, AGAIN, loop=3))
    refuse(checker, ["EG", f"(not {BRIGHT})"], "holds", run(AGAIN, AGAIN, loop=8))
    refuse(checker, ["EG", f"(not {BRIGHT})"], "holds", run(AGAIN, AGAIN, loop=None))
    refuse(checker, ["EG", DARK], "holds", run(AGAIN, AGAIN, loop=4))
    lasso = run(done(ON), done(ON), done(ON), loop=4, **{"from": 2})
    prove(checker, ["EU", "true", ["EG", LIT]], "holds", run(done(ON)), lasso)
    refuse(checker, ["EU", "true", ["EG", LIT]], "holds", run(done(ON)), lasso | {"from": 1})
    refuse(checker, ["EU", "true", ["EG", LIT]], "holds", run(AGAIN), lasso)


def test_a_lasso_is_fair(checker: Checker) -> None:
    stuck = run(done(ON)[:1], [step(["ask", MORE, 0, []], [["reject", MORE, -1, 1]])] * 2, loop=2)
    runs = ["EG", "(not ended.0)"]
    answers = checker.whole(("ask", MORE, 0, []), checker.initial, [])[0].said()
    stuck["steps"][1]["answers"] = stuck["steps"][2]["answers"] = answers
    prove(checker, runs, "holds", stuck)
    refuse(checker, runs, "holds", stuck, fair=True)
    prove(checker, ["EG", f"(not {BRIGHT})"], "holds", run(AGAIN, AGAIN, loop=4), fair=True)


def test_a_ranking_lets_nothing_go_on_for_ever(checker: Checker) -> None:
    busy = ["EG", "(not (= phase.0 0))"]
    once = ["EX", busy]
    active = "(not (= phase.0 0))"
    prove(checker, once, "violated", closed("false"), ranking(("reported.0", active)), fair=True)
    refuse(checker, once, "violated", closed("false"), ranking(("reported.0", active)))
    refuse(checker, once, "violated", closed("false"), ranking(("reported.1", active)), fair=True)
    refuse(checker, once, "violated", closed("false"), ranking((None, active)), fair=True)
    refuse(checker, once, "violated", closed("false"), ranking(("reported.0", "(= phase.0 1)")), fair=True)
    two = ranking(("reported.0", "(= phase.0 2)"), ("reported.0", "(= phase.0 1)"))
    prove(checker, once, "violated", closed("false"), two, fair=True)
    two["layers"].reverse()
    refuse(checker, once, "violated", closed("false"), two, fair=True)
    refuse(checker, ["EG", "true"], "violated", ranking((None, "true")), fair=True)
    refuse(checker, ["EG", "true"], "violated", ranking((None, "false"), (None, "true")), fair=True)


def test_steps_that_must_lead_down_need_no_constraint(checker: Checker) -> None:
    moved = ["EG", "(and (not launch.0) ended.0)"]
    prove(checker, ["EX", moved], "violated", closed("false"), ranking((None, "(= phase.0 0)"), (None, "true")))
    refuse(checker, ["EX", moved], "violated", closed("false"), ranking((None, "true")))


FINISHED = ["not", ["U", "true", ["not", ["or", "(not launch.0)", ["U", "true", "(= phase.0 0)"]]]]]
"""LTL: whatever is launched ends. Its operators are G (0) and F (1)."""


def test_promises_hold_or_are_broken(checker: Checker) -> None:
    left = "(not (= phase.0 0))"
    broken = "(and promise.0 (not promise.1))"
    down = ranking(("reported.0", f"(and {left} (not promise.1))"), ("promise.0", "promise.0"))
    prove(checker, FINISHED, "holds", down, fair=True, linear=True)
    refuse(checker, FINISHED, "holds", down, linear=True)
    refuse(checker, FINISHED, "holds", ranking(("promise.0", "promise.0")), fair=True, linear=True)
    refuse(checker, FINISHED, "holds", ranking(("promise.1", broken)), fair=True, linear=True)


def test_a_run_makes_a_formula_of_time_false(checker: Checker) -> None:
    never = ["not", ["U", "true", LIT]]
    lasso = run(AGAIN, AGAIN, loop=4)
    prove(checker, never, "violated", lasso, linear=True)
    refuse(checker, never, "holds", lasso, linear=True)
    refuse(checker, ["not", ["U", "true", BRIGHT]], "violated", lasso, linear=True)
    refuse(checker, never, "violated", run(done(OFF)), linear=True)
    dark = run([step(["give up", ON, 0, []])], loop=0)
    refuse(checker, ["U", "true", LIT], "violated", dark, linear=True)
    prove(checker, ["X", ["not", ["X", "ended.0"]]], "violated", lasso, linear=True)
    refuse(checker, ["X", ["not", ["X", "launch.0"]]], "violated", lasso, linear=True)
    refuse(checker, never, "violated", lasso | {"from": 4}, linear=True)


def test_operators_belong_to_their_kind_of_claim(checker: Checker) -> None:
    refuse(checker, ["U", "true", LIT], "holds", run(done(ON)))
    refuse(checker, ["EU", "true", LIT], "holds", run(done(ON)), linear=True)
    refuse(checker, ["EX", LIT, LIT], "holds", run(done(ON)))
    refuse(checker, ["AG", LIT], "holds", INVARIANT)
    refuse(checker, 5, "holds")
