"""ABC: its answers are those of enumeration; whatever it does wrong leaves questions open, and no process behind."""

import os
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import closing
from functools import reduce
from pathlib import Path
from time import monotonic, sleep

import pytest

from exover.engines.aig.abc import prover
from exover.engines.aig.abc.prover import BOTH, FIRST
from exover.engines.aig.circuit.answer import Answer, Clause, Open, Reachable, Unreachable
from exover.engines.aig.circuit.graph import Circuit, Graph, Literal
from exover.engines.aig.induction.inductive import Induction
from exover.engines.process import NotRunnable
from tests.support.circuits import counter, random_circuit, reachable, verdicts
from tests.support.confirming import confirms
from tests.support.needed import needs_abc

FAKE = """#!{python}
import os, signal, sys, time
from pathlib import Path
Path("{folder}/pids").open("a").write(f"{{os.getpid()}}\\n")
script = sys.argv[-1]
{body}
"""
HANG = "os.fork() or signal.pause(); time.sleep(600)"
TALLY = "Properties:  All = 1. Proved = {}. Disproved = {}. Undecided = {}."
COUNTED = "Properties:  All = 2. Proved = {}. Disproved = 0. Undecided = {}."
PROOF = f"""
Path("invariant.pla").write_text(".i 1\\n.o 1\\n.ilb l0\\n{{}} 1\\n.e\\n")
print("{TALLY.format(1, 0, 0)}")
"""
CLAIM = f"""
Path("runs.txt").write_text("#\\n#\\n# CEX for output 0\\n#\\n000\\n1\\n0\\n1# DONE\\n")
print("Output 0 was asserted in frame 2"); print("{TALLY.format(0, 1, 0)}")
"""


def decided(circuit: Circuit, program: str, seconds: float = 60) -> dict[int, Answer]:
    """Return what is said of each question, each once."""
    found: dict[int, Answer] = {}
    told: Counter[int] = Counter()

    def say(place: int, answer: Answer) -> None:
        found[place] = answer
        told[place] += 1

    prover.decide(circuit, say, seconds, program)
    assert told == dict.fromkeys(range(len(circuit.bad)), 1)
    return found


@pytest.fixture
def fake(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], str]:
    """Return what writes a program in the place of ABC, which is believed to be usable."""

    def write(body: str) -> str:
        program = tmp_path / "abc"
        program.write_text(FAKE.format(python=sys.executable, folder=tmp_path, body=body))
        program.chmod(0o755)
        return str(program)

    monkeypatch.setattr(prover, "unusable", lambda program: "")
    return write


@needs_abc
def test_the_program_that_is_found_is_usable() -> None:
    assert prover.unusable(prover.find()) == ""


@needs_abc
@pytest.mark.parametrize("seed", range(12))
def test_verdicts_are_those_of_enumeration(seed: int) -> None:
    circuit = random_circuit(seed, latches=4 + seed % 4, inputs=1 + seed % 3)
    answers = decided(circuit, prover.find())
    expected = reachable(circuit)
    assert verdicts(answers) == (expected, set(range(len(circuit.bad))) - expected)
    assert all(confirms(circuit, circuit.bad[place], answer) for place, answer in answers.items())


@needs_abc
def test_an_invariant_of_several_clauses_and_a_run_of_many_steps() -> None:
    never, late = counter(6, 40, 41), counter(6, 40, 40)
    unreachable, run = decided(never, prover.find())[0], decided(late, prover.find())[0]
    assert isinstance(unreachable, Unreachable) and confirms(never, never.bad[0], unreachable)
    assert isinstance(run, Reachable) and len(run.inputs) == 41 and confirms(late, late.bad[0], run)


@needs_abc
def test_circuits_without_inputs_latches_or_conjunctions() -> None:
    graph = Graph()
    one, other = graph.latch(True), graph.latch(False)
    both = graph.conjunction(one, other)
    assert verdicts(decided(graph.circuit([one ^ 1, one], [one, other, both]), prover.find())) == ({0, 1}, {2})
    graph = Graph()
    left, right = graph.input(), graph.input()
    asked = [0, 1, left, graph.conjunction(left, right)]
    answers = decided(graph.circuit([], asked), prover.find())
    assert verdicts(answers) == ({1, 2, 3}, {0})
    assert all(confirms(graph.circuit([], asked), bad, answers[place]) for place, bad in enumerate(asked))


@needs_abc
def test_equal_questions_have_equal_answers() -> None:
    circuit = random_circuit(3)
    assert decided(circuit, prover.find()) == decided(circuit, prover.find())


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("sys.exit(3)", "ended with status 3"),
        ("os.kill(os.getpid(), signal.SIGSEGV)", "was ended by SIGSEGV"),
        ("os.kill(os.getpid(), signal.SIGKILL)", "was ended by SIGKILL"),
        ("print('hello')", "printed nothing that says what it found"),
        (f"print('{TALLY.format(0, 0, 1)}')", "did not decide it"),
        ("Path('runs.txt').write_bytes(bytes(range(256)))", "printed nothing that says"),
        ("Path('runs.txt').write_text('# CEX for output 0\\n#\\n0\\n1101# DONE')", "wrote what cannot be read"),
        ("Path('invariant.pla').write_text('.ilb zero\\n1 1\\n')", "wrote what cannot be read: the name of a latch"),
        ("Path('invariant.pla').write_text('.ilb l77\\n1 1\\n')", "printed nothing"),
        (PROOF.format("1"), prover.UNBELIEVED),
        (PROOF.format("0"), prover.UNBELIEVED),
        (CLAIM, prover.UNBELIEVED),
        (CLAIM.replace("output 0", "output 5"), prover.UNBELIEVED),
    ],
)
def test_what_is_not_shown_is_open(fake: Callable[[str], str], body: str, reason: str) -> None:
    (answer,) = decided(counter(3, 5, 5), fake(body)).values()
    assert isinstance(answer, Open) and reason in answer.reason


@pytest.mark.parametrize(
    ("printed", "unlimited"),
    [
        (
            ["Timing out on output  1 in frame 2.", COUNTED.format(1, 1)],
            [0],
        ),
        ([COUNTED.format(2, 0)], [0, 1]),
        ([COUNTED.format(0, 2)], []),
        ([], []),
    ],
)
def test_what_is_not_claimed_to_be_proved_is_looked_at_with_a_limit(
    fake: Callable[[str], str], monkeypatch: pytest.MonkeyPatch, printed: list[str], unlimited: list[int]
) -> None:
    """That its clauses exclude it is believed all the same."""
    graph = Graph()
    latches = [graph.latch(False), graph.latch(False)]
    limits: list[list[int | None]] = []
    excluded = Induction.excluded

    def noted(self: Induction, clauses: Sequence[Clause], asked: list[tuple[Literal, int | None]]) -> list[bool]:
        limits.append([granted for _, granted in asked])
        return excluded(self, clauses, asked)

    monkeypatch.setattr(Induction, "excluded", noted)
    clauses = ".i 2\n.o 1\n.ilb l0 l1\n1- 1\n-1 1\n.e\n"
    program = fake(f"Path('invariant.pla').write_text({clauses!r}); print({chr(10).join(printed)!r})")
    answers = decided(graph.circuit(latches, latches), program)
    assert limits == [[None if place in unlimited else prover.GUESS for place in range(2)]]
    assert verdicts(answers) == (set(), {0, 1})


def test_what_takes_more_than_its_limit_is_not_excluded() -> None:
    """Sums modulo two of the same inputs in two orders."""
    graph = Graph()
    inputs = [graph.input() for _ in range(14)]
    different = graph.differ(reduce(graph.differ, inputs), reduce(graph.differ, [*inputs[1::2], *inputs[::2]]))
    with closing(Induction(graph.circuit([], [different]))) as induction:
        assert induction.excluded((), [(different, 10), (different, None), (different, 10**9)]) == [False, True, True]


def test_a_true_run_is_believed_whoever_shows_it(fake: Callable[[str], str]) -> None:
    circuit = counter(3, 5, 1)
    assert isinstance(decided(circuit, fake(CLAIM))[0], Reachable)


@pytest.mark.parametrize(("rounds", "reduced"), [(FIRST, [False]), (BOTH, [False, True])])
def test_what_is_left_open_is_asked_of_a_smaller_circuit_if_that_is_wanted(
    fake: Callable[[str], str], tmp_path: Path, rounds: slice, reduced: list[bool]
) -> None:
    said: list[Answer] = []
    asked = tmp_path / "asked"
    program = fake(f'print("{TALLY.format(0, 0, 1)}"); print(sys.argv[-1], file=open({str(asked)!r}, "a"))')
    prover.decide(counter(3, 5, 7), lambda _, answer: said.append(answer), 60, program, rounds)
    assert [type(each) for each in said] == [Open]
    assert ["&fraig" in script for script in asked.read_text().splitlines()] == reduced


def test_it_is_not_asked_again_when_it_is_to_stop(fake: Callable[[str], str], tmp_path: Path) -> None:
    """The first round has begun by then."""
    said: list[Answer] = []
    asked = tmp_path / "asked"
    program = fake(f'print("{TALLY.format(0, 0, 1)}"); print(sys.argv[-1], file=open({str(asked)!r}, "a"))')
    circuit = counter(3, 5, 7)
    prover.decide(circuit, lambda _, answer: said.append(answer), 60, program, BOTH, asked.exists)
    assert [type(each) for each in said] == [Open]
    assert len(asked.read_text().splitlines()) == 1


def test_a_program_that_hangs_leaves_no_process(
    fake: Callable[[str], str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(prover, "SLACK", 1)
    started = monotonic()
    (answer,) = decided(counter(3, 5, 7), fake(HANG), 1).values()
    assert isinstance(answer, Open) and "took longer than" in answer.reason and monotonic() - started < 10
    pids = [int(pid) for pid in (tmp_path / "pids").read_text().split()]
    until = monotonic() + 2
    while any(map(lives, pids)) and monotonic() < until:
        sleep(0.02)
    assert pids and not any(map(lives, pids))


def lives(pid: int) -> bool:
    """Return whether a process is there and no zombie."""
    try:
        os.kill(pid, 0)
        return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except (ProcessLookupError, FileNotFoundError):
        return False


def test_a_program_that_is_not_there_leaves_all_open(tmp_path: Path) -> None:
    circuit = counter(3, 5, 7)
    (answer,) = decided(circuit, str(tmp_path / "none")).values()
    assert isinstance(answer, Open) and answer.reason.startswith("cannot run ")
    with pytest.raises(NotRunnable, match="it is no program"):
        prover.find(str(tmp_path / "none"))


def test_another_program_is_found_out() -> None:
    assert "does not answer as ABC does" in prover.unusable("/bin/true")
    assert "ended with status" in prover.unusable("/bin/false")


def test_nothing_is_asked_after_the_time() -> None:
    (answer,) = decided(counter(3, 5, 7), "/bin/true", 0).values()
    assert isinstance(answer, Open)


@needs_abc
def test_time_is_that_of_a_processor(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the clock says, a program that had no time of a processor may go on."""
    circuit, answer = counter(3, 5, 5), prover.find()
    monkeypatch.setattr(prover, "_spent", lambda: 5.0)
    assert isinstance(decided(circuit, answer, 20)[0], Reachable)
    spent = iter([0.0, 30.0])
    monkeypatch.setattr(prover, "_spent", lambda: next(spent))
    (late,) = decided(circuit, answer, 20).values()
    assert isinstance(late, Open) and late.reason == "time limit"


@pytest.mark.parametrize("seed", range(10))
def test_what_is_kept_is_the_most(seed: int) -> None:
    circuit = random_circuit(seed, latches=4)
    literals = [2 * latch.node + sign for latch in circuit.latches for sign in (0, 1)]
    candidates = [(a, b) for a in literals for b in literals if a < b and a ^ b != 1] + [(a,) for a in literals]
    induction = Induction(circuit)
    kept = induction.kept(candidates)
    induction.close()
    assert confirms(circuit, 0, Unreachable(kept))
    for clause in set(candidates) - set(kept):
        assert not confirms(circuit, 0, Unreachable((*kept, clause)))
