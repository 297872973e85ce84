"""The circuit of the command line: the same bytes each time, whatever the checks say, and read by others."""

from pathlib import Path

import pytest

from exover.checks.engines import DIAGRAMS
from exover.cli.main import main
from exover.engines.aig import abc
from exover.engines.aig.aiger import Document, read
from exover.engines.aig.answer import Answer, Reachable
from exover.engines.process import run
from exover.pipeline import build, check, load, load_properties
from exover.source import Source
from tests.support.abc import needs_abc

SPEC = """spec s; module m { request r(); }
forbid f: active(m.r) by kill m.r; launch l: m.r() when past(m.r);"""
PROPERTIES = "for s; property p: never past(m.r); property q: ltl G !past(m.r); property w: never active(m.r);"


def emitted(folder: Path, *more: str) -> bytes:
    """Return the file that the command writes for a spec that is violated."""
    (folder / "s.exo").write_text(SPEC)
    assert main(["emit", str(folder / "s.exo"), "--target", "aiger", "--out", str(folder / "out"), *more]) == 0
    (file,) = (folder / "out").iterdir()
    assert file.name == "s.aig"
    return file.read_bytes()


def meanings(document: Document) -> dict[str, str]:
    """Return what each finding holds iff, as the comment says."""
    return dict(line.split(": ", 1) for line in document.comment[3:])


def test_a_spec_need_not_hold_to_be_judged_by_others(tmp_path: Path) -> None:
    found = emitted(tmp_path)
    assert emitted(tmp_path) == found
    document = read(found)
    assert document.names.bad[0] == "unsettled" and "safety.f" in document.names.bad
    assert any(name.startswith("m.r[0]") for name in document.names.latches)
    assert "event[0]" in document.names.inputs
    assert meanings(document)["safety.f"] == "it cannot be reached"
    assert meanings(document)["deadlock.m.r"].startswith("not asked")


@pytest.mark.parametrize("given", [True, False])
def test_properties_are_asked(given: bool, tmp_path: Path) -> None:
    file = tmp_path / ("given.prop" if given else "s.prop")
    file.write_text(PROPERTIES)
    document = read(emitted(tmp_path, *(["--properties", str(file)] if given else [])))
    assert "property.p" in document.names.bad
    assert meanings(document)["property.q"].startswith("not asked")


@needs_abc
def test_abc_reads_it(tmp_path: Path) -> None:
    document = read(emitted(tmp_path))
    printed = run([abc.find(), "-q", "read_aiger s.aig; print_stats"], tmp_path / "out", seconds=60).printed
    assert f"/{len(document.names.bad):5d}  lat ={len(document.circuit.latches):5d}" in printed


@needs_abc
def test_what_abc_finds_is_what_the_checks_say(tmp_path: Path) -> None:
    (tmp_path / "s.prop").write_text(PROPERTIES)
    document = read(emitted(tmp_path))
    answers: dict[int, Answer] = {}
    abc.decide(document.circuit, answers.__setitem__, 60, None, abc.find())
    names = document.names.bad
    reached = {name for place, name in enumerate(names) if isinstance(answers[place], Reachable)}
    assert "unsettled" not in reached
    model = load(Source("s.exo", SPEC)).model
    assert model is not None
    properties = load_properties(Source("s.prop", PROPERTIES), model).properties
    assert properties is not None
    findings = check(build(model), lambda _: None, properties=properties, engines=DIAGRAMS).findings
    said = {f"{each.check}.{each.subject}".replace(" ", "-"): each.verdict == "holds" for each in findings}
    simple = {name: text for name, text in meanings(document).items() if text.startswith("it ")}
    assert {name: (name in reached) == (text == "it can be reached") for name, text in simple.items()} == {
        name: said[name] for name in simple
    }
    assert set(map(said.__getitem__, simple)) == {True, False}
