"""The circuit of the command line: the same bytes each time, whatever the checks say, and read by others."""

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from exover.checks.schedule.engines import DIAGRAMS
from exover.checks.schedule.plan import CheckPlan
from exover.cli.main import main
from exover.engines.aig.abc import prover
from exover.engines.aig.circuit.aiger import Document
from exover.engines.aig.circuit.answer import Answer, Reachable
from exover.engines.aig.circuit.graph import Circuit, Graph, Literal
from exover.engines.aig.induction.pdr import decide
from exover.engines.process import run
from exover.pipeline import build, check, load, load_properties
from exover.source import Source
from tests.support.aiger_reader import read
from tests.support.command import Run, environment
from tests.support.needed import needs_abc

SPEC = """spec s; module m { request r(); }
forbid f: active(m.r) by kill m.r; launch l: m.r() when past(m.r);"""
PROPERTIES = "for s; property p: never past(m.r); property q: ltl G !past(m.r); property w: never active(m.r);"


def emitted(folder: Path, *more: str, spec: str = SPEC, name: str = "s.aig") -> bytes:
    """Return the file that the command writes for a spec, here for one that is violated."""
    (folder / "s.exo").write_text(spec)
    assert main(["emit", str(folder / "s.exo"), "--target", "aiger", "--out", str(folder / "out"), *more]) == 0
    files = {file.name: file.read_bytes() for file in (folder / "out").iterdir()}
    assert {"s.aig"} <= files.keys() <= {"s.aig", "s.live.aig"}
    return files[name]


def meanings(document: Document) -> dict[str, str]:
    """Return what each finding holds iff, as the comment says."""
    return dict(line.split(": ", 1) for line in document.comment[4:])


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
    assert meanings(document)["property.q"] == "no run satisfies it" and "property.q" not in document.names.bad


@needs_abc
def test_abc_reads_it(tmp_path: Path) -> None:
    document = read(emitted(tmp_path))
    printed = run([prover.find(), "-q", "read_aiger s.aig; print_stats"], tmp_path / "out", seconds=60).printed
    assert f"/{len(document.names.bad):5d}  lat ={len(document.circuit.latches):5d}" in printed


@needs_abc
def test_what_abc_finds_is_what_the_checks_say(tmp_path: Path) -> None:
    (tmp_path / "s.prop").write_text(PROPERTIES)
    document = read(emitted(tmp_path))
    answers: dict[int, Answer] = {}
    prover.decide(document.circuit, answers.__setitem__, 60, prover.find())
    names = document.names.bad
    reached = {name for place, name in enumerate(names) if isinstance(answers[place], Reachable)}
    assert "unsettled" not in reached
    model = load(Source("s.exo", SPEC)).model
    assert model is not None
    properties = load_properties(Source("s.prop", PROPERTIES), model).properties
    assert properties is not None
    findings = check(build(model), lambda _: None, CheckPlan(properties=properties, engines=DIAGRAMS)).findings
    said = {f"{each.check}.{each.subject}".replace(" ", "-"): each.verdict == "holds" for each in findings}
    simple = {name: text for name, text in meanings(document).items() if text.startswith("it ")}
    assert {name: (name in reached) == (text == "it can be reached") for name, text in simple.items()} == {
        name: said[name] for name in simple
    }
    assert set(map(said.__getitem__, simple)) == {True, False}


STOCKS = """spec s;
resource energy: 5 consumable by wait;
resource memory: 4 consumable by wait;
module m {
    request a() { consumes energy 3; consumes memory 2; produces energy 2; }
    request b() { produces memory 3; produces energy 1; wait until not active(m.a); }
}"""


def test_every_process_writes_the_same(tmp_path: Path, run: Run) -> None:
    """A launch writes two levels, whose names each process hashes in its own way."""
    (tmp_path / "s.exo").write_text(STOCKS)
    for seed in ("1", "6"):
        arguments = "emit", "s.exo", "--target", "aiger", "--out", seed, "--unchecked"
        assert run(*arguments, env=environment(PYTHONHASHSEED=seed)).returncode == 0
    first, second = ((tmp_path / seed / "s.aig").read_bytes() for seed in ("1", "6"))
    assert first == second


WAITS = """spec s;
module m { request a() { interrupts m.b; } request b() { wait until not active(m.a); }
    request c(); request d() { wait until not active(m.c); } }
"""
ENDLESS = "for s; property p: ltl G F !active(m.a); property q: ltl F G active(m.c); assume fair reports;"


def lassos(document: Document) -> dict[str, bool]:
    """Return of each justice property whether a run satisfies it: one that comes back to a state that it kept."""
    circuit, found = document.circuit, {}
    for name, signals in zip(document.names.justice, document.justice, strict=True):
        answers: dict[int, Answer] = {}
        decide(returning(circuit, signals), answers.__setitem__)
        found[name] = isinstance(answers[0], Reachable)
    return found


def returning(circuit: Circuit, signals: Sequence[Literal]) -> Circuit:
    """Return the circuit that is asked whether a run keeps a state, sees all signals, and is there again."""
    graph = Graph(circuit.fanins.copy(), list(circuit.inputs), [(each.node, each.initial) for each in circuit.latches])
    following = [each.next for each in circuit.latches]

    def latch(after: Callable[[Literal], Literal]) -> Literal:
        made = graph.latch(False)
        following.append(after(made))
        return made

    keep = graph.input()
    kept = latch(lambda me: graph.any((me, keep)))
    now = graph.conjunction(keep, kept ^ 1)
    since = graph.any((kept, keep))
    seen = [latch(lambda me, s=signal: graph.conjunction(since, graph.any((me, s)))) for signal in signals]  # type: ignore[misc]
    alike = []
    for each in circuit.latches:
        copy = latch(lambda me, old=2 * each.node: graph.choose(now, old, me))  # type: ignore[misc]
        alike.append(graph.differ(copy, 2 * each.node) ^ 1)
    return graph.circuit(following, [graph.all((kept, *seen, *alike))])


def test_justice_properties_are_satisfied_iff_the_checks_say_so(tmp_path: Path) -> None:
    (tmp_path / "s.prop").write_text(ENDLESS)
    found = lassos(read(emitted(tmp_path, spec=WAITS, name="s.live.aig")))
    model = load(Source("s.exo", WAITS)).model
    assert model is not None
    properties = load_properties(Source("s.prop", ENDLESS), model).properties
    assert properties is not None
    findings = check(build(model), lambda _: None, CheckPlan(properties=properties, engines=DIAGRAMS)).findings
    verdicts = {f"{f.check}.{f.subject}": f.verdict for f in findings}
    assert {name: "violated" if lasso else "holds" for name, lasso in found.items()} == {
        name: verdict for name, verdict in verdicts.items() if name in found
    }
    assert len(found) > 2 and len(set(found.values())) == 2
