"""Engines and plain enumeration on random small specs: `python -m tests.support.agreement --specs 200`.

Every disagreement is printed with the spec that shows it; the status is 1 if there was one.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from random import Random

from exover.checks.finding import Finding
from exover.checks.schedule.agenda import Agenda
from exover.checks.schedule.engines import EngineName, Engines
from exover.checks.schedule.examination import Examination
from exover.checks.schedule.plan import CheckPlan
from exover.checks.schedule.tasks import TaskAnswer, TaskRunner
from exover.checks.schedule.workers import Lost, alone
from exover.engines.smv.program import find
from exover.model.model import Model
from exover.model.property import Properties
from exover.ocrd.compile import Compiled
from tests.support import explicit_ctl, explicit_ltl
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.moments import moments_of
from tests.support.oracle import explore, verdicts
from tests.support.representatives import TooLarge
from tests.support.small import compiled, small_spec_of
from tests.support.starving import starved

PATIENCE = 1.0
"""Seconds for a claim that an engine could go on about for ever."""
ENUMERATION = "enumeration"
MOST_STATES, MOST_STEPS = 300, 1500
"""How large a spec may be that is gone through moment by moment."""

Key = tuple[str, str]
"""A check and a subject."""


@dataclass(frozen=True)
class Agreed:
    """A spec with properties, and by finding the verdict of each engine, plain enumeration among them.

    `about_nothing`: the assumptions contradict each other, so that only properties say anything.
    """

    spec: str
    properties: Properties
    said: dict[Key, dict[str, str]]
    reasons: Counter[tuple[str, str]]
    """Why engines give no answer."""
    about_nothing: bool

    @property
    def disagreements(self) -> dict[Key, dict[str, str]]:
        """The findings of which one says that they hold, and another that they are violated."""
        return {
            key: said
            for key, said in self.said.items()
            if (key[0] == "property" or not self.about_nothing) and {"holds", "violated"} <= set(said.values())
        }

    def __str__(self) -> str:
        """Return all that is needed to see it again."""
        rows = "\n".join(f"{check} {subject}: {said}" for (check, subject), said in self.disagreements.items())
        return f"{self.spec}\n{self.properties}\n{rows}"


def agreed(seed: int, engines: Engines) -> Agreed:
    """Return what is said of the spec of a seed and of random properties; raises `TooLarge`."""
    spec = small_spec_of(seed)
    made = compiled(model_of(spec))
    of = Formulas(Random(seed), made.model)
    properties = of.properties(1 + seed % 2, 1 + seed % 3)
    wanted, about_nothing = enumerated(made.model, properties)
    said, reasons = _judged(made, properties, engines)
    for key, verdict in wanted.items():
        said[key][ENUMERATION] = verdict
    return Agreed(spec, properties, said, reasons, about_nothing)


def _judged(
    made: Compiled, properties: Properties, engines: Engines
) -> tuple[dict[Key, dict[str, str]], Counter[tuple[str, str]]]:
    asked = tuple(CheckPlan(properties=properties).questions(made.model))
    runner = TaskRunner(Examination(made, properties), asked, engines)
    lots = [lot for place, name in enumerate(engines.names) for lot in runner._lots(name, place * len(asked))]
    answers: dict[int, Finding] = {}

    def take(number: int, answer: TaskAnswer | Lost) -> bool:
        assert isinstance(answer, Finding), answer
        answers[number] = answer
        return False

    alone(runner.task, Agenda(lots, None, {}), lambda what: None, take)
    said: dict[Key, dict[str, str]] = {}
    for number, (_, question) in enumerate(asked):
        row = [answers[place * len(asked) + number] for place in range(len(engines.names))]
        said[question.check, question.subject] = {each.engine: each.verdict for each in row}
    unknown = (each for each in answers.values() if each.verdict == "unknown")
    return said, Counter((each.engine, each.message) for each in unknown)


def enumerated(
    model: Model, properties: Properties, most_states: int = MOST_STATES, most_steps: int = MOST_STEPS
) -> tuple[dict[Key, str], bool]:
    """Return the verdicts by plain enumeration, and whether the assumptions contradict each other.

    Under assumptions only properties are enumerated.
    """
    moments = moments_of(model, properties, most_states, most_steps)
    contradictory = bool(moments.dead) or 0 not in explicit_ctl.fair(moments)
    found: dict[Key, str] = {}
    for each in properties.properties:
        logic = explicit_ltl if each.form == "ltl" else explicit_ctl
        holds = not contradictory and logic.holds(moments, each.formula)
        found["property", each.name] = "holds" if holds else "violated"
        if each.premise is not None and not contradictory:
            possible = explicit_ctl.can_be(moments, each.premise)
            found["vacuity", each.name] = "holds" if possible else "violated"
    if not properties.assumptions:
        graph = explore(model, most_states, most_steps)
        found |= verdicts(graph)
        for request in model.request:
            found["starvation", request] = "violated" if starved(graph, request) else "holds"
    return found, contradictory


ALL: tuple[EngineName, ...] = ("aig", "bdd", "z3", "nusmv")


def every_engine(names: tuple[EngineName, ...] = ALL) -> Engines:
    """Return these engines, to be compared; raises `NotRunnable` if NuSMV is one and is not installed."""
    return Engines(names, compared=True, nusmv=find() if "nusmv" in names else "", patience=PATIENCE)


# ---- many ----


@dataclass
class Tally:
    """What was compared so far."""

    specs: int = 0
    findings: int = 0
    answers: Counter[tuple[str, str]] = field(default_factory=Counter)
    """By engine and verdict."""
    reasons: Counter[tuple[str, str]] = field(default_factory=Counter)
    disagreed: int = 0

    def add(self, one: Agreed) -> None:
        """Count one spec."""
        self.specs += 1
        self.findings += len(one.said)
        self.answers.update((engine, verdict) for said in one.said.values() for engine, verdict in said.items())
        self.reasons.update(one.reasons)
        self.disagreed += len(one.disagreements)

    def lines(self) -> Iterator[str]:
        """Yield what a reader should know."""
        yield f"{self.specs} specs, {self.findings} findings, {self.disagreed} disagreements"
        for engine in dict.fromkeys(engine for engine, _ in sorted(self.answers)):
            counts = {verdict: self.answers[engine, verdict] for verdict in ("holds", "violated", "unknown")}
            yield f"{engine:>12}: " + ", ".join(f"{number} {verdict}" for verdict, number in counts.items())
        for (engine, reason), number in self.reasons.most_common():
            yield f"{engine:>12}: {number} unknown: {reason}"


def small_enough(engines: Engines, first: int) -> Iterator[Agreed]:
    """Yield what is said of ever new specs, those left out that are too large to be enumerated."""
    seed = first
    while True:
        with suppress(TooLarge):
            yield agreed(seed, engines)
        seed += 1


def main(argv: Sequence[str] | None = None) -> int:
    """Compare the engines and print what was compared."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--specs", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="the seed to begin with")
    parser.add_argument("--engines", nargs="+", choices=ALL, default=list(ALL))
    arguments = parser.parse_args(argv)
    tally = Tally()
    for one in small_enough(every_engine(tuple(arguments.engines)), arguments.first):
        tally.add(one)
        if one.disagreements:
            print(f"\n{one}", flush=True)
        if tally.specs % 20 == 0:
            print(next(tally.lines()), flush=True)
        if tally.specs == arguments.specs:
            break
    print("\n".join(tally.lines()))
    return 1 if tally.disagreed else 0


if __name__ == "__main__":
    sys.exit(main())
