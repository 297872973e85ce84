"""Berkeley ABC (Brayton, Mishchenko 2010) as a process: its claims about a circuit, as far as they can be checked.

It looks for runs and for proofs by property directed reachability (Bradley 2011). Its invariants count if they are
inductive in the circuit as it was given, its runs if they replay. It gets latches that are all false at the start, and
only combinational reductions: latches keep their names, clauses of them their meaning.

Its time is that of a processor, as it measures it itself, so that what it answers does not depend on what else the
machine is busy with. By the clock it has `SLACK` times as long.
"""

import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from exover.dataclass import dataclass
from exover.engines.aig.abc.output import NoOutput, clauses, runs, tally
from exover.engines.aig.abc.question import AbcQuestion
from exover.engines.aig.circuit.answer import (
    Answer,
    Clause,
    Inputs,
    Open,
    Reachable,
    SayAnswer,
    StopRequested,
    Unreachable,
    never,
)
from exover.engines.aig.circuit.graph import FALSE, TRUE, Circuit, Fanins, LatchNode
from exover.engines.aig.induction.inductive import Induction
from exover.engines.aig.simulation.replay import replayed
from exover.engines.process import NotRunnable, run

NAMES = ("berkeley-abc", "abc")
READ = "read_aiger circuit.aig"
REDUCE = "&get -n; &syn2; &fraig -x -C 10; &put; dc2"
PROVE = "pdr -a -x -i -d -I invariant.pla -T {seconds} -H {each}; write_cex -a runs.txt"
ROUNDS: tuple[tuple[int, str], ...] = (60, f"{READ}; {PROVE}"), (12, f"{READ}; {REDUCE}; {PROVE}")
"""By round of proofs: `n`, where a question may cost 1 / `n` of ABC's time, at least two seconds; and the script.
Most are proved sooner than the circuit could be reduced, some only of a reduced one."""
ALONE: tuple[tuple[int, str], ...] = (12, ROUNDS[0][1]), (1, ROUNDS[1][1])
"""The same for a single question."""
FIRST, BOTH = slice(1), slice(2)
"""Which of the rounds are run."""
BRIEF = 5.0
"""Seconds that it may take to look for short runs."""
UNROLL = f"{READ}; bmc3 -a -x -F 14 -H 200 -T {BRIEF:.0f}; write_cex -a runs.txt"
"""Bounded model checking of all questions together, a fifth of a second for each."""
GUESS = 200_000
"""Propagations for checking whether the clauses exclude a bad literal that the program does not claim to be proved."""
SLACK = 6
"""How many times as long as its time of a processor the program may take by the clock before it is ended."""
UNBELIEVED = "what it claims without a checkable invariant or a run that replays is not believed"


class _Stopped(Exception):
    """The program came to no answer; the message says why."""


@dataclass(frozen=True, slots=True)
class _Claims:
    """What the program claims: runs by output, clauses that exclude what is proved; and what it printed."""

    runs: Mapping[int, Inputs]
    invariant: tuple[Clause, ...]
    printed: str


def find(given: str | None = None) -> str:
    """Return the path of the program: the one given, else one on PATH. Raises `NotRunnable` if there is none."""
    for name in NAMES if given is None else (given,):
        found = shutil.which(name)
        if found is not None:
            return os.path.abspath(found)
    raise NotRunnable("no ABC was found on PATH" if given is None else f"cannot run {given}: it is no program")


@cache
def unusable(program: str) -> str:
    """Return why a program does not serve as ABC, "" if it does; it is asked once, about a latch that toggles."""
    fanins = Fanins.of((None, None, None, (3, 4)))
    circuit = Circuit(fanins, (1,), (LatchNode(2, True, 4),), (5, 6, 2))
    answers: dict[int, Answer] = {}
    try:
        _prove(AbcQuestion(circuit, [0, 1, 2]), answers.__setitem__, 10.0, program, ROUNDS[0][1])
    except _Stopped as reason:
        return str(reason)
    kinds = [type(answers.get(place)) for place in range(3)]
    if kinds != [Unreachable, Reachable, Reachable]:
        return f"{program} does not answer as ABC does, or is too old"
    return ""


def decide(
    circuit: Circuit,
    say: SayAnswer,
    seconds: float,
    program: str,
    rounds: slice = BOTH,
    stop: StopRequested = never,
) -> None:
    """Say the answer to each bad literal, by its place; claims of the program that are not confirmed are `Open`.

    `program`: its path. It has so many seconds of a processor. Once an answer is known it is said. `rounds`: which are
    run; what the first leaves open the second asks of a smaller circuit, unless it is to `stop`.
    """
    end = _spent() + seconds
    circuit = replace(circuit, latches=circuit.support(circuit.bad))
    left = dict.fromkeys(range(len(circuit.bad)))

    def tell(place: int, answer: Answer) -> None:
        del left[place]
        say(place, answer)

    for place, bad in enumerate(circuit.bad):
        if bad == FALSE:
            tell(place, Unreachable(()))
        elif bad == TRUE:
            tell(place, Reachable((frozenset(),)))
    reason = UNBELIEVED
    try:
        if left and (why := unusable(program)):
            raise _Stopped(why)
        scripts = ROUNDS if len(left) > 1 else ALONE
        for share, script in scripts[rounds]:
            if left and not stop():
                each = max(2.0, seconds / share)
                reason = _prove(AbcQuestion(circuit, list(left)), tell, _remaining(end), program, script, each)
    except _Stopped as stopped:
        reason = str(stopped)
    for place in list(left):
        tell(place, Open(reason))


def unrolled(circuit: Circuit, program: str) -> dict[int, Inputs]:
    """Return short runs that make bad literals true, by their places, those that the program finds soon."""
    found: dict[int, Inputs] = {}

    def say(place: int, answer: Answer) -> None:
        if isinstance(answer, Reachable):
            found[place] = answer.inputs

    question = AbcQuestion(replace(circuit, latches=circuit.support(circuit.bad)), range(len(circuit.bad)))
    if not unusable(program):
        with suppress(_Stopped):
            _confirm_runs(question, _asked(question, UNROLL, BRIEF, program).runs, say)
    return found


def _spent() -> float:
    """Return the processor time, in seconds, of child processes that have ended (Windows: 0)."""
    times = os.times()
    return times.children_user + times.children_system


def _remaining(end: float) -> float:
    """Return the seconds that are left until `end`, as `_spent` counts. Raises `_Stopped` if there are none."""
    left = end - _spent()
    if left <= 0:
        raise _Stopped("time limit")
    return left


def _prove(question: AbcQuestion, say: SayAnswer, seconds: float, program: str, script: str, each: float = 0.0) -> str:
    """Say what is proved or reached, and return why nothing is said of the rest. Raises `_Stopped`.

    `each`: the seconds that one question may cost, if there is a limit.
    """
    whole = max(1, int(seconds * 0.8))
    begun = _spent()
    claims = _asked(question, script.format(seconds=whole, each=int(each * 1000)), seconds, program)
    reached = _confirm_runs(question, claims.runs, say)
    known = tally(claims.printed)
    unclaimed = set(range(len(question.places))) if known is None or not known.proved else known.late
    rest = {p: GUESS if n in unclaimed else None for n, p in enumerate(question.places) if p not in reached}
    for place, kept in _confirm_proofs(question.circuit, rest, claims.invariant):
        say(place, Unreachable(kept))
    if known is None:
        return f"{program} printed nothing that says what it found"
    late = _spent() - begun > seconds * 0.7
    return f"{program} did not decide it{' in time' if late else ''}" if known.undecided else UNBELIEVED


def _confirm_proofs(
    circuit: Circuit, places: Mapping[int, int | None], invariant: Sequence[Clause]
) -> Iterator[tuple[int, tuple[Clause, ...]]]:
    """Yield the places of bad literals that clauses exclude, with those of the clauses that are inductive.

    `places`: each with the propagations that it may cost, if there is a limit.
    """
    if not places:
        return
    with closing(Induction(circuit)) as induction:
        kept = induction.kept(invariant)
        excluded = induction.excluded(kept, [(circuit.bad[place], granted) for place, granted in places.items()])
    yield from ((place, kept) for place, proved in zip(places, excluded, strict=True) if proved)


def _confirm_runs(question: AbcQuestion, found: Mapping[int, Inputs], say: SayAnswer) -> set[int]:
    """Say which bad literals are reached by runs that replay, and return their places."""
    claimed = [(question.places[n], each) for n, each in sorted(found.items()) if n < len(question.places)]
    goals = [(question.circuit.bad[place], each) for place, each in claimed]
    reached = set()
    for (place, inputs), shown in zip(claimed, replayed(question.circuit, goals), strict=True):
        if shown:
            say(place, Reachable(inputs))
            reached.add(place)
    return reached


def _asked(question: AbcQuestion, script: str, seconds: float, program: str) -> _Claims:
    """Return what the program claims. Raises `_Stopped`."""
    with TemporaryDirectory(prefix="exover-") as name:
        folder = Path(name)
        printed = _ran(question, script, folder, seconds, program)
        try:
            cubes = clauses(_text(folder / "invariant.pla"))
            shown = runs(_text(folder / "runs.txt"), max(1, len(question.circuit.inputs)))
        except NoOutput as wrong:
            raise _Stopped(f"{program} wrote what cannot be read: {wrong}") from wrong
    width = len(question.circuit.latches)
    if any(place >= width for cube in cubes for place in cube):
        cubes = []
    found = {output: question.inputs(steps) for output, steps in shown.items()}
    return _Claims(found, question.invariant(cubes), printed)


def _ran(question: AbcQuestion, script: str, folder: Path, seconds: float, program: str) -> str:
    """Run the program on a question, written into a folder, and return what it prints. Raises `_Stopped`."""
    (folder / "circuit.aig").write_bytes(question.written())
    try:
        ended = run([program, "-s", "-q", script], folder, seconds=seconds * SLACK)
    except (NotRunnable, TimeoutError) as reason:
        raise _Stopped(str(reason)) from reason
    if ended.status:
        raise _Stopped(f"{program} {ended.how}")
    return ended.printed


def _text(file: Path) -> str:
    with suppress(FileNotFoundError):
        return file.read_text("utf-8", "replace")
    return ""
