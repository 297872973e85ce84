"""The engine that runs the emitted C: it answers like the reference, and leaves nothing behind."""

import os
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from exover.emit.artefact import Artefact
from exover.emit.c import emit_tables
from exover.engines.compiler import NativeUnavailable
from exover.model.event import Abort, AbortWaiting, Ask, Event, Killed, Launched, Observe, Rejected, Report
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.ocrd.tables import Tables
from exover.pipeline import build
from exover.run import native
from exover.run.inprocess import InProcessEngine
from exover.run.native import NativeEngine, NativeFault
from tests.runtime.compiling import ROOT, SANITIZERS, built, model_of

ROVER = built(ROOT / "specs" / "rover.exo")
GOTO = Ask("nd.goto", (1.0, -0.0, 0.4))
EVENTS: tuple[Event, ...] = (
    GOTO,
    Ask("pom.localize"),
    Report("pom.localize", 0, "ok"),
    GOTO,
    Ask("nd.stop"),
    AbortWaiting("nd.goto"),
    Report("nd.goto", 0, "failed", status="lost"),
    Report("nd.goto", 0, "ok", (3.0,)),
    Abort("nd.stop", 0),
    Observe("battery", 5),
    Observe("nd.speed", 0.2000001),
)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Let temporary files be made in a folder of the test's own, which is empty afterwards."""
    own = tmp_path / "temporary"
    own.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(own))
    yield own
    assert list(own.iterdir()) == []


def children() -> set[str]:
    """Return the processes that this one has started and not yet waited for."""
    path = Path(f"/proc/self/task/{os.getpid()}/children")
    return set(path.read_text().split()) if path.exists() else set()


def expected() -> list[object]:
    reference = Reference(ROVER.model)
    state, answers = reference.start(), []
    for event in EVENTS:
        state, actions = reference.step(state, event)
        answers.append(actions)
    return answers


def test_it_answers_one_by_one_and_all_at_once(folder: Path) -> None:
    before = children()
    with NativeEngine(ROVER.model, ROVER.tables) as engine:
        assert list(folder.iterdir()) == []  # even if the process is killed now, no file stays
        assert [engine.step(event) for event in EVENTS] == expected()
        assert list(engine.replay(EVENTS)) == expected()
        assert list(engine.replay(EVENTS[:2])) == expected()[:2]
    assert children() == before


def test_it_answers_in_this_process(folder: Path) -> None:
    engine, other = InProcessEngine(ROVER.model, ROVER.tables), InProcessEngine(ROVER.model, ROVER.tables)
    assert list(folder.iterdir()) == []
    for event, actions in zip(EVENTS, expected(), strict=True):
        assert engine.step(event) == actions
    assert [other.step(event) for event in EVENTS] == expected()
    assert engine.fault == 0


def test_what_is_not_sound_is_denied_in_this_process() -> None:
    engine = InProcessEngine(ROVER.model, ROVER.tables)
    assert isinstance(engine.step(Ask("pom.localize"))[0], Launched)
    for word in range(len(engine._memory) // 2, len(engine._memory)):
        engine._memory[word] ^= 1
    answers = engine.step(Ask("arm.calibrate"))
    assert engine.fault and all(
        isinstance(each, Killed) or each == Rejected(each.request, "faulty") for each in answers
    )


def test_it_runs_under_sanitizers() -> None:
    with NativeEngine(ROVER.model, ROVER.tables, ("-std=c99", *SANITIZERS)) as engine:
        assert list(engine.replay(EVENTS)) == expected()


def test_more_than_a_pipe_holds_is_no_trouble() -> None:
    with NativeEngine(ROVER.model, ROVER.tables) as engine:
        answers = engine.replay([GOTO] * 20_000)
    assert len(answers) == 20_000 and len(set(answers)) == 1


def test_a_broken_sensor_is_read_by_the_checker_itself() -> None:
    text = "spec s; poster a: int in 0 .. 5 = 0 else 5; poster b: bool = false else true; poster c: real = 0 else 1;"
    text += f"poster d: int in {-(1 << 63)} .. {(1 << 63) - 1} = 0 else 7;"  # no number tells that it is broken
    model = model_of(text + "module m { request r() { check a < 5; } request q() { check c < 1; check d != 7; } }")
    events: list[Event] = [
        Observe("a", 5, True),
        Ask("m.r"),
        Observe("b", True, True),
        Observe("c", 1.0, True),
        Ask("m.q"),
        Observe("c", 0.5),
        Ask("m.q"),
        Report("m.q", 0, "ok"),
        Observe("d", 7, True),
        Ask("m.q"),
    ]
    reference = Reference(model)
    state, library = reference.start(), InProcessEngine(model, build(model).tables)
    with NativeEngine(model, build(model).tables) as engine:
        for event in events:
            state, actions = reference.step(state, event)
            assert engine.step(event) == library.step(event) == actions


def test_results_of_a_request_without_parameters_are_read_anew() -> None:
    """They come at the same place each time, and there are no arguments by which they would differ."""
    clause = "check not past(m.look with d == 2);"
    model = model_of(f"spec s; module m {{ request look() returns (d: int in 0 .. 9) {{ {clause} }} }}")
    events: list[Event] = []
    for result in (3, 4, 2):
        events += [Ask("m.look"), Report("m.look", 0, "ok", (result,))]
    events.append(Ask("m.look"))
    reference = Reference(model)
    state, due = reference.start(), []
    for event in events:
        state, actions = reference.step(state, event)
        due.append(actions)
    with NativeEngine(model, build(model).tables) as engine:
        assert list(engine.replay(events)) == due


def test_no_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(NativeUnavailable, match="no C compiler"), NativeEngine(ROVER.model, ROVER.tables):
        pass


def test_another_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler -O3")
    with pytest.raises(NativeUnavailable, match="no-such-compiler"), NativeEngine(ROVER.model, ROVER.tables):
        pass


def test_a_compiler_that_fails_is_quoted() -> None:
    with (
        pytest.raises(NativeUnavailable, match="no-such-option"),
        NativeEngine(ROVER.model, ROVER.tables, ("--no-such-option",)),
    ):
        pass


def test_a_folder_that_cannot_be_written_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))
    with pytest.raises(NativeUnavailable, match="nowhere"), NativeEngine(ROVER.model, ROVER.tables):
        pass


def test_tables_that_the_runtime_refuses(monkeypatch: pytest.MonkeyPatch) -> None:
    """The sources hold other numbers than those whose checksum they name."""

    def damaged(model: Model, tables: Tables, name: str) -> tuple[Artefact, ...]:
        files = emit_tables(model, tables, name)
        return tuple(replace(file, content=file.content.replace(b"\n    0, 0,", b"\n    1, 0,", 1)) for file in files)

    monkeypatch.setattr(native, "emit_tables", damaged)
    with pytest.raises(NativeFault, match="refused: 8"), NativeEngine(ROVER.model, ROVER.tables):
        pass


def test_a_process_that_is_killed_is_a_fault() -> None:
    before = children()
    with NativeEngine(ROVER.model, ROVER.tables) as engine:
        process = engine._process
        assert process is not None
        process.kill()
        process.wait()
        with pytest.raises(NativeFault, match="status -9"):
            engine.step(GOTO)
    assert children() == before


def test_an_interruption_leaves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    before = children()

    def interrupt(self: NativeEngine, line: bytes) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(native.NativeEngine, "_expect", interrupt)
    with pytest.raises(KeyboardInterrupt), NativeEngine(ROVER.model, ROVER.tables):
        pass
    assert children() == before


UNDEFINED = ("-fsanitize=undefined", "-fno-sanitize-recover=all", "-fsanitize-undefined-trap-on-error")


@pytest.mark.parametrize("bound", [100, 32_767, 2_000_000_000, 2**31, 2**61])
def test_sums_are_exact_in_every_width(bound: int) -> None:
    model = model_of(
        f"spec s; poster a: int in -{bound} .. {bound} = 0; poster b: int in -{bound} .. {bound} = 0;"
        f"module m {{ request r(x: int in -{bound} .. {bound}) {{ check x + a - b <= {bound}; }} }}"
    )
    extremes = (-bound, 0, bound)
    events: list[Event] = []
    for x in extremes:
        for a in extremes:
            for b in extremes:
                asked = [Observe("a", a), Observe("b", b), Ask("m.r", (x,))]
                events += [*asked, Report("m.r", 0, "ok")]
    reference = Reference(model)
    state, due = reference.start(), []
    for event in events:
        state, actions = reference.step(state, event)
        due.append(actions)
    with NativeEngine(model, build(model).tables, ("-std=c99", "-O0", *UNDEFINED)) as engine:
        assert list(engine.replay(events)) == due
