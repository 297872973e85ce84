"""What `make bench` measures is what it says that it is."""

from pathlib import Path

import pytest

from benchmarks import __main__ as table
from benchmarks import checks, command, engines, families, ros2
from benchmarks.measure import Row
from exover.checks.schedule.examination import Examination
from exover.model.property import NO_PROPERTIES
from exover.pipeline import build, load, load_properties
from exover.source import Source

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize("size", [2, 3, 8])
def test_a_coupled_module_has_23_bits(size: int) -> None:
    text = families.coupled(size)
    loaded = load(Source("family.exo", text))
    assert loaded.model is not None
    assert not loaded.diagnostics
    assert Examination(build(loaded.model).compiled, NO_PROPERTIES).state_bits(lambda what: None) == 23 * size
    assert text == families.coupled(size)


def test_a_run_of_the_command_says_what_it_took_and_when_the_first_error_showed() -> None:
    found = command.check(ROOT / "specs" / "violations" / "obligation.exo", 60, "--engine=bdd")
    assert found.whole, found.said
    assert found.verdicts["obligation", "violated"] == 1
    assert found.first is not None
    assert 0 < found.first < 60
    assert found.seconds > 0


def test_a_command_that_is_refused_is_no_figure() -> None:
    found = command.check(ROOT / "specs" / "rover.exo", 60, "--engine=bdd", "--abc=none")
    assert not found.whole
    assert found.said.startswith("exit status 2: ")
    assert "--abc" in found.said


def test_checks_are_asked_of_a_spec_from_its_text() -> None:
    found = checks.ask(families.guarded(4, 3, 1), 60)
    assert found.whole, found.said
    assert "4 completeness holds" in found.said
    assert "rule-use" not in found.said
    two = checks.ask(families.queues(4), 60, "safety", "deadlock")
    assert two.whole, two.said
    assert {part.split()[1] for part in two.said.split("; ")} == {"safety", "deadlock"}


def test_a_process_that_fails_or_is_late_is_no_figure() -> None:
    assert not checks.ask("spec s; module m {", 60).whole
    assert not checks.ask(families.queues(4), 60, "no such check").whole
    assert not checks.ask(families.queues(4), 0.01).whole


def test_what_is_not_whole_misses_its_limit() -> None:
    assert Row("", 1, "s", 2).verdict == "ok"
    assert Row("", 1, "s", 2, whole=False).verdict == "MISSED"
    assert Row("", 1, "s", whole=False).verdict == ""


def test_rows_are_chosen_by_their_names_and_those_of_groups() -> None:
    row = Row("one", 1)
    known = {"a": {"x": lambda: iter([row]), "y": lambda: iter([row, row])}, "b": {"z": lambda: iter([row])}}
    assert len(list(table.chosen(known, []))) == 4
    assert len(list(table.chosen(known, ["a"]))) == 3
    assert len(list(table.chosen(known, ["y", "z"]))) == 3


def test_no_two_rows_have_one_name() -> None:
    known = table.groups(5, False)
    names = [*known, *(name for members in known.values() for name in members)]
    assert len(names) == len(set(names))
    assert all((ROOT / "tests" / "specs" / f"{name}.prop").exists() for name in engines.TEAMS)


@pytest.mark.parametrize("spec", engines.FIELDS, ids=lambda spec: spec.stem)
def test_specs_of_other_fields_have_no_mistakes_and_properties(spec: Path) -> None:
    source = Source(str(spec), spec.read_text())
    loaded = load(source)
    assert loaded.model is not None, loaded.diagnostics
    properties = spec.with_suffix(".prop")
    read = load_properties(Source(str(properties), properties.read_text()), loaded.model)
    assert read.properties is not None, read.diagnostics


def test_a_goal_of_ros_2_takes_the_gate_some_time_of_its_own() -> None:
    pytest.importorskip("rosbags", reason="the extra exover[ros2] is not installed")
    (row,) = ros2.own(1)
    assert row.value > 0
    assert "99 of 100" in row.note
