"""Where dd has no CUDD, its own diagrams in Python find the same: here CUDD cannot be imported."""

import subprocess
import sys
from pathlib import Path

import pytest

from exover.cli.files import read_spec
from exover.engines.bdd import python_manager
from tests.support import explicit_ctl, explicit_ltl, property_cases
from tests.support.command import environment
from tests.support.constructs import seldom
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.small import ENUMERABLE, compiled, differences, explored, findings_of, small_spec_of

SPECS = sorted((Path(__file__).parents[2] / "specs" / "violations").glob("*.exo"))
SEEDS = (4, 30, 69, 98, 109, 112)
"""Of small specs: with those of `SPECS` they have every construct that small specs have."""
PROPERTIES = property_cases.SEEDS[1::5]


@pytest.fixture(autouse=True)
def managers(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """Take CUDD away, and return the managers that are made instead; one at least has to be."""
    made: list[object] = []
    python = python_manager.PythonManager

    def manager() -> object:
        made.append(python())
        return made[-1]

    monkeypatch.setitem(sys.modules, "dd.cudd", None)
    monkeypatch.setattr(python_manager, "PythonManager", manager)
    return made


def test_the_specs_have_every_construct() -> None:
    few, many = ([(model_of(small_spec_of(seed)),) for seed in seeds] for seeds in (SEEDS, ENUMERABLE))
    assert not seldom([*few, *((read_spec(str(path)),) for path in SPECS)], many, 1)


@pytest.mark.parametrize("seed", SEEDS)
def test_every_verdict_is_that_of_the_oracle(seed: int, managers: list[object]) -> None:
    made = compiled(model_of(small_spec_of(seed)))
    assert differences(explored(seed), findings_of(made)) == {}
    assert managers


@pytest.mark.parametrize("seed", PROPERTIES)
def test_every_property_is_judged_as_explicit_search_does(seed: int, managers: list[object]) -> None:
    case = property_cases.case_of.__wrapped__(seed)
    assert managers
    for each in case.properties.properties:
        logic = explicit_ltl if each.form == "ltl" else explicit_ctl
        wanted = not case.contradictory and logic.holds(case.moments, each.formula)
        assert case.found["property", each.name].verdict == ("holds" if wanted else "violated"), each


@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_a_spec_has_the_verdicts_that_cudd_finds(
    path: Path, managers: list[object], monkeypatch: pytest.MonkeyPatch
) -> None:
    made = compiled(read_spec(str(path)))
    without = check_by_diagrams(made, count=True)
    assert managers
    monkeypatch.undo()
    known = len(managers)
    found = check_by_diagrams(made, count=True)
    assert len(managers) == known
    assert [(each.check, each.subject, each.verdict) for each in without.findings] == [
        (each.check, each.subject, each.verdict) for each in found.findings
    ]
    assert without.states == found.states


def test_a_command_says_nothing_of_diagrams_that_are_there_when_it_ends() -> None:
    code = "import sys; sys.modules['dd.cudd'] = None; from exover.cli.main import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", code, "check", str(SPECS[0]), "--no-cache", "--jobs", "1"]
    done = subprocess.run(command, env=environment(), check=False, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (1, "")
