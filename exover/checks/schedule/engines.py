"""The engines that are asked, in which order, and whether one claim after the other or all at once."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal, Protocol, assert_never

from exover.dataclass import dataclass
from exover.engines.bdd.effort import OutOfSteps, limited
from exover.loop.claim import Claim, Judge, SayOpinion
from exover.model.property import Properties
from exover.ocrd.compile import Compiled

if TYPE_CHECKING:
    from exover.engines.bdd.analysis import Analysis
    from exover.engines.smv.engine import NuSmv
    from exover.loop.finite.builder import ClosedLoop

EngineName = Literal["aig", "bdd", "z3", "nusmv"]


@dataclass(frozen=True, slots=True)
class Engines:
    """The engines: each of `names` is asked what those before it left unknown or, if they are `compared`, everything.

    `nusmv`, `abc`: the programs NuSMV and Berkeley ABC (which `aig` uses), empty if there is none. `patience`: the
    seconds that an engine whose search may not terminate spends on a claim.
    """

    names: tuple[EngineName, ...] = ("bdd",)
    compared: bool = False
    nusmv: str = ""
    abc: str = ""
    patience: float = 60.0
    adaptive: bool = False
    """Whether diagrams are asked first if the loop is of a size that suits them."""


DIAGRAMS = Engines()
PORTFOLIO = Engines(("aig", "bdd", "z3"), adaptive=True)
MANY = 1000
"""Samples of the arguments of a request up to which diagrams may be asked first.

The bits of a state are known only when the argument classes are, which takes half a second if there are more."""
SMALL, LARGE = 64, 600
"""Bits of a state up to which diagrams may be asked first, and from which on the graph of `aig` is too large."""
LOOSE, FEW = 20, 5000
"""The coupling, and the diagram nodes of components, up to which diagrams of a small state are asked first.

Measured on 40 specs: up to here diagrams answered all checks in about two seconds at most; on most of the others they
took longer than `aig`."""
LOCAL, NARROW = 32, 16
"""Limits up to which diagrams are asked first if no component is spontaneous: diagram nodes of components for each bit
of the state, and bits that a component reads, from which it is known before that its diagram is small.

Measured on specs of `benchmarks/families.py` of 120 to 290 bits: up to here (2 to 22 nodes) diagrams took 0.1 to 0.8
times as long as `aig` for all checks, and with 64 nodes 1.4 times. Each of seven specs of teams has a component that
reads 44 bits or more; to make these diagrams took up to minutes."""
CLASSES = 1000
"""The argument cells of all requests up to which components are made to see what they read: each cell is a part of the
component that settles its request. Specs of teams for which this took seconds have 5 600 and 8 200 cells, and none of
their components reads few bits."""

GLANCE = 20_000_000
"""The steps that diagrams may take until it is known whether they are asked first: some 20 seconds, where specs of
teams take a hundredth of that."""


def suited(engines: Engines, analysis: "Analysis") -> Engines:
    """Return the engines in the order in which they are asked: `bdd` first if the loop suits diagrams."""
    if not engines.adaptive:
        return engines
    try:
        with limited(GLANCE):
            suits = _suits_diagrams(analysis)
    except OutOfSteps:
        suits = False
    if not suits:
        return engines
    return replace(engines, names=tuple(sorted(engines.names, key=lambda name: name != "bdd")))


def _suits_diagrams(analysis: "Analysis") -> bool:
    samples = analysis.most_samples
    if samples is None or samples > MANY:
        return False
    bits = analysis.state_bits
    if bits is None:
        return False
    if SMALL < bits < LARGE:
        if _classes(analysis.loop) > CLASSES or not _is_local(analysis.loop) or analysis.stepper.waking.always:
            return False
        return len(analysis.space.bdd) <= LOCAL * bits
    return bits >= LARGE or (analysis.coupling <= LOOSE and len(analysis.space.bdd) <= FEW)


def _classes(loop: "ClosedLoop") -> int:
    """Return the number of argument cells of all requests."""
    return sum(len(each.cells) for each in loop.arguments)


def _is_local(loop: "ClosedLoop") -> bool:
    """Return whether no component is spontaneous, and each reads at most `NARROW` bits; this makes no diagram."""
    bits = [(variable.size - 1).bit_length() for variable in loop.variables]
    return all(not each.always and sum(bits[var] for var in each.reads) <= NARROW for each in loop.body)


class Batch(Protocol):
    """An engine that is asked all claims at once, because most of its work is shared by them.

    Like a `Judge`, it raises only for faults of exover, and may be halted or killed at any time.
    """

    @property
    def name(self) -> str:
        """The engine, as findings name it."""
        ...

    def judge_all(self, claims: Sequence[Claim], say: SayOpinion) -> None:
        """Pass the index and the opinion of each claim, as `Judge.judge` returns it, to `say` as soon as it is known.

        A claim without an opinion counts as given up.
        """
        ...


@dataclass(frozen=True)
class InOrder:
    """A `Judge` as a `Batch`: it is asked one claim after the other."""

    judge: Judge

    @property
    def name(self) -> str:
        """The engine, as findings name it."""
        return self.judge.name

    def judge_all(self, claims: Sequence[Claim], say: SayOpinion) -> None:
        """Pass the opinion of each claim to `say`, in order."""
        for number, claim in enumerate(claims):
            say(number, self.judge.judge(claim))


@dataclass(frozen=True)
class Whole:
    """NuSMV, which reads the loop once for all claims and returns all opinions at its end."""

    engine: "NuSmv"

    @property
    def name(self) -> str:
        """The engine, as findings name it."""
        return self.engine.name

    def judge_all(self, claims: Sequence[Claim], say: SayOpinion) -> None:
        """Pass the opinion of each claim to `say`, once the program has ended."""
        for number, opinion in enumerate(self.engine.judge_all(claims)):
            say(number, opinion)


def at_once(name: EngineName, engines: Engines, cut_off: bool) -> bool:
    """Return whether an engine is asked all claims at once; `cut_off`: any answer may be, by a time limit.

    Z3 is, unless time is limited: its answers depend on what it was asked before, which must be the same for any number
    of processes. With a time limit it is better asked one claim after the other. So are diagrams where they are asked
    what is left: the hardest questions, which may come to a limit of steps.
    """
    match name:
        case "bdd":
            return not cut_off and engines.names[0] != "bdd"
        case "aig":
            return True
        case "z3" | "nusmv":
            return not cut_off
        case _:
            assert_never(name)


def batch_of(name: EngineName, engines: Engines, compiled: Compiled, properties: Properties, spare: bool) -> Batch:
    """Return an engine that is asked all claims about a compiled model at once; `spare`: it may have two processes."""
    match name:
        case "aig":
            from exover.engines.aig.engine import Aig

            return Aig(compiled, properties, engines.abc, spare=spare)
        case "nusmv":
            from exover.engines.smv.engine import NuSmv

            return Whole(NuSmv(compiled, properties, engines.nusmv))
        case "bdd" | "z3":
            return InOrder(judge_of(name, engines, compiled, properties))
        case _:
            assert_never(name)


def judge_of(
    name: EngineName,
    engines: Engines,
    compiled: Compiled,
    properties: Properties,
    seconds: float | None = None,
) -> Judge:
    """Return an engine that is asked one claim at a time and gives up after so many seconds (default: its own limit).

    Raises `ValueError` for `aig` and `bdd`.
    """
    match name:
        case "z3":
            from exover.engines.smt.solver import forget
            from exover.equivalence.engine import Z3

            forget()
            return Z3(compiled, properties, engines.patience if seconds is None else seconds)
        case "nusmv":
            from exover.engines.smv.engine import NuSmv

            return NuSmv(compiled, properties, engines.nusmv, seconds)
        case "aig" | "bdd":
            raise ValueError(f"{name} is not asked one claim after the other")
        case _:
            assert_never(name)
