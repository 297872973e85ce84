"""All 256 Boolean functions of three atoms, through diagrams, the machine that walks the tables, and the C runtime.

Modelled on OxiDD's `boolean_function.rs`: every function, every valuation, the truth table printed on failure.
"""

from collections.abc import Callable, Sequence
from itertools import product

import pytest

from exover.model.event import Action, Args, Ask, Event, Launched, Observe, Report
from exover.model.expression import And, Compare, Cond, Const, Not, Or, Param, Reading, Status
from exover.model.model import Guard, Model, Parameter, Request, Variable
from exover.model.types import Bool
from exover.ocrd.compile import compile_model
from exover.ocrd.machine import Machine
from tests.runtime.compiling import Engine

FUNCTIONS = range(256)
VALUATIONS = tuple(product((False, True), repeat=3))
PARAMS = tuple(Parameter(name, Bool()) for name in "abc")
Atoms = tuple[Cond, Cond, Cond]
Switch = Callable[[int, bool], Event]
Truth = list[list[bool]]
"""Whether function f launches in valuation v."""


def function(number: int, atoms: Atoms) -> Cond:
    """Return the disjunction of the minterms of a function: bit v of its number is its value in valuation v."""
    terms = []
    for index, valuation in enumerate(VALUATIONS):
        if number >> index & 1:
            terms.append(And(tuple(a if true else Not(a) for a, true in zip(atoms, valuation, strict=True))))
    return Or(tuple(terms))


def with_functions(atoms: Atoms, params: tuple[Parameter, ...], others: Sequence[Request], posters: bool) -> Model:
    guarded = []
    for number in FUNCTIONS:
        guard = Guard("check", f"f.f{number}.check.1", function(number, atoms), None, number)
        guarded.append(Request(f"f.f{number}", params, guards=(guard,)))
    variables = tuple(Variable(f"p{name}", "poster", Bool(), False) for name in "abc") if posters else ()
    return Model("boolean", (*guarded, *others), variables, (), (), (), ())


def of_posters() -> tuple[Model, Switch | None]:
    atoms = tuple(Compare("==", Reading(f"p{name}"), Const(True)) for name in "abc")
    return with_functions(atoms, (), (), True), lambda index, on: Observe(f"p{'abc'[index]}", on)


def of_activity() -> tuple[Model, Switch | None]:
    atoms = tuple(Status("active", f"x.{name}") for name in "abc")
    others = [Request(f"x.{name}") for name in "abc"]

    def switch(index: int, on: bool) -> Event:
        name = f"x.{'abc'[index]}"
        return Ask(name) if on else Report(name, 0, "ok")

    return with_functions(atoms, (), others, False), switch


def of_arguments() -> tuple[Model, Switch | None]:
    atoms = tuple(Compare("==", Param(name), Const(True)) for name in "abc")
    return with_functions(atoms, PARAMS, (), False), None


def events(switch: Switch | None) -> list[tuple[Event, tuple[int, int] | None]]:
    """Return every event, those that ask a function in a valuation with both numbers."""
    found: list[tuple[Event, tuple[int, int] | None]] = []
    before = (False, False, False)
    for index, valuation in enumerate(VALUATIONS):
        if switch:
            changes = [i for i in range(3) if valuation[i] != before[i]]
            found += [(switch(i, valuation[i]), None) for i in changes]
            before = valuation
        args: Args = () if switch else valuation
        for number in FUNCTIONS:
            found.append((Ask(f"f.f{number}", args), (number, index)))
            found.append((Report(f"f.f{number}", 0, "ok"), None))
    return found


def table(answers: Sequence[tuple[Action, ...]], asked: Sequence[tuple[Event, tuple[int, int] | None]]) -> Truth:
    truth: Truth = [[False] * len(VALUATIONS) for _ in FUNCTIONS]
    for actions, (_, place) in zip(answers, asked, strict=True):
        if place:
            truth[place[0]][place[1]] = any(isinstance(action, Launched) for action in actions)
    return truth


def assert_truth(found: Truth, engine: str) -> None:
    for number in FUNCTIONS:
        expected = [bool(number >> index & 1) for index in range(len(VALUATIONS))]
        if found[number] != expected:
            rows = [
                " ".join(str(int(bit)) for bit in (*valuation, want, got))
                for valuation, want, got in zip(VALUATIONS, expected, found[number], strict=True)
            ]
            pytest.fail(f"{engine}: function {number}\na b c due got\n" + "\n".join(rows))


@pytest.mark.parametrize("build", [of_posters, of_activity, of_arguments])
def test_every_function(build: Callable[[], tuple[Model, Switch | None]]) -> None:
    model, switch = build()
    tables = compile_model(model, bytes(32)).tables
    asked = events(switch)
    machine = Machine(model, tables)
    assert_truth(table([machine.step(event) for event, _ in asked], asked), "machine")
    with Engine(model, tables) as native:
        assert_truth(table(native.replay([event for event, _ in asked]), asked), "C")
