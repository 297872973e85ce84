"""Every Boolean function of three atoms, through the diagrams, the tables and the compiled C."""

from contextlib import AbstractContextManager, nullcontext
from itertools import product

import pytest

from exover.model.event import Ask, Launched, Observe, Report
from exover.model.model import Model
from exover.ocrd.machine import Machine
from exover.ocrd.tables import Tables
from exover.run.native import NativeEngine
from exover.run.simulate import Engine
from tests.support.engines import model_of, tables_of

ATOMS = ("hot", "count <= 1", "speed < 0.2")
VALUES = ((False, True), (2, 1), (0.2, 0.1))
"""What makes each atom false, and what true."""
ROWS = tuple(product((False, True), repeat=3))


def formula(function: int) -> str:
    """Return the function as text; bit k of `function` is its value in row k of the truth table."""
    rows = [row for index, row in enumerate(ROWS) if function >> index & 1]
    terms = [" and ".join(a if v else f"not {a}" for a, v in zip(ATOMS, row, strict=True)) for row in rows]
    return " or ".join(f"({term})" for term in terms) or "false"


@pytest.fixture(scope="module")
def model() -> Model:
    """A request for each function, launched iff the function is true."""
    requests = "\n".join(f"request f{number}() {{ check {formula(number)}; }}" for number in range(256))
    return model_of(f"""spec functions;
        poster hot: bool = false;
        poster count: int in 0 .. 3 = 0;
        poster speed: real in 0 .. 1 = 0;
        module m {{ {requests} }}""")


@pytest.fixture(scope="module")
def tables(model: Model) -> Tables:
    return tables_of(model)


def test_equal_functions_share_their_nodes(model: Model, tables: Tables) -> None:
    """Each function is one diagram of at most 7 tests: as many as the number of its distinct subfunctions."""
    for index in range(256):
        seen, stack = set(), [tables.requests[index].decide]
        while stack:
            node = stack.pop()
            if node >= 0 and node not in seen:
                seen.add(node)
                stack += [tables.nodes[node].low]
                stack += [tables.nodes[node].high] if tables.nodes[node].code >= 0 else []
        tests = sum(tables.nodes[node].code >= 0 for node in seen)
        assert tests <= 1 + 5, f"{formula(index)}: {tests} tests, one of them whether a slot is free"


@pytest.mark.parametrize("name", ["tables", "c"])
def test_functions(name: str, model: Model, tables: Tables) -> None:
    context: AbstractContextManager[Engine] = (
        nullcontext(Machine(model, tables)) if name == "tables" else NativeEngine(model, tables)
    )
    found = dict.fromkeys(range(256), "")
    with context as engine:
        for row in ROWS:
            for poster, values, atom in zip(("hot", "count", "speed"), VALUES, row, strict=True):
                engine.step(Observe(poster, values[atom]))
            for number in range(256):
                (action,) = engine.step(Ask(f"m.f{number}"))
                found[number] += "1" if isinstance(action, Launched) else "0"
                if isinstance(action, Launched):
                    engine.step(Report(f"m.f{number}", 0, "failed"))
    for number, column in found.items():
        wanted = "".join(str(number >> index & 1) for index in range(8))
        rows = "\n".join(f"{row}: {w} {f}" for row, w, f in zip(ROWS, wanted, column, strict=True))
        assert column == wanted, f"{formula(number)}\n{ATOMS}: wanted, found\n{rows}"
