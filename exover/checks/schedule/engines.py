"""Which engines answer, and whether one claim after the other or all at once."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal, Protocol, assert_never

from exover.dataclass import dataclass
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
    """Who is asked: each of `names` for what those before it left open, or if they are `compared` all for everything.

    `nusmv`: the program of that name, if it is among them; `abc`: Berkeley ABC, which helps `aig`, or nothing.
    `patience`: the seconds that one which could search for ever spends on a claim.
    """

    names: tuple[EngineName, ...] = ("bdd",)
    compared: bool = False
    nusmv: str = ""
    abc: str = ""
    patience: float = 60.0
    adaptive: bool = False
    """Whether diagrams are asked first where the loop is of a size that suits them."""


DIAGRAMS = Engines()
PORTFOLIO = Engines(("aig", "bdd", "z3"), adaptive=True)
MANY = 1000
"""Samples of the arguments of a request up to which diagrams may answer at once.

To count the bits of a state is to tell classes of arguments apart, which delays the first answer by half a second where
there are more."""
SMALL, LARGE = 64, 600
"""Bits of a state up to which diagrams may answer at once, and from which on the graph of a whole step is too large."""
LOOSE, FEW = 20, 5000
"""The coupling, and the nodes of what components do, up to which diagrams of a small state answer at once.

Measured on 40 specs: up to here all checks took diagrams at most about two seconds, and most of the others took them
longer than they took `aig`."""
LOCAL, NARROW = 32, 16
"""The nodes of what components do, for each bit of the state, up to which diagrams answer at once if each component
rests until something is written, and the bits that each may read, for its diagram to be small before it is made.

Measured on specs of `benchmarks/families.py` of 120 to 290 bits: up to here (2 to 22 nodes) all checks took diagrams
0.1 to 0.8 times as long as they took `aig`, and 1.4 times with 64 nodes. Of seven specs of teams each has a component
that reads 44 bits or more; to make these diagrams took up to minutes."""
CLASSES = 1000
"""The classes of arguments, of all requests, up to which components are made to see what they read: each is a part of
the component that settles its request. The specs of teams for which it took seconds have 5 600 and 8 200, and no
component of theirs reads few bits."""


def suited(engines: Engines, analysis: "Analysis") -> Engines:
    """Return the engines in the order in which they are asked about a loop."""
    if not engines.adaptive or not _suits_diagrams(analysis):
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
    """Return how many kinds of asks there are."""
    return sum(len(each.cells) for each in loop.arguments)


def _is_local(loop: "ClosedLoop") -> bool:
    """Return whether each component rests unless it is woken, and reads few bits; no diagram is made for that."""
    bits = [(variable.size - 1).bit_length() for variable in loop.variables]
    return all(not each.always and sum(bits[var] for var in each.reads) <= NARROW for each in loop.body)


class Batch(Protocol):
    """An engine that is asked all claims at once, because to read the loop is most of its work.

    As a `Judge` it raises nothing but for faults of exover's own, and may be halted or killed at any moment.
    """

    @property
    def name(self) -> str:
        """The engine, as findings name it."""
        ...

    def judge_all(self, claims: Sequence[Claim], say: SayOpinion) -> None:
        """Say of each claim, by its index and as soon as it is known, what `Judge.judge` would return.

        A claim of which nothing is said counts as given up.
        """
        ...


@dataclass(frozen=True)
class InOrder:
    """An engine that is asked one claim after the other."""

    judge: Judge

    @property
    def name(self) -> str:
        """The engine, as findings name it."""
        return self.judge.name

    def judge_all(self, claims: Sequence[Claim], say: SayOpinion) -> None:
        """Say of each claim what the engine says of it."""
        for number, claim in enumerate(claims):
            say(number, self.judge.judge(claim))


@dataclass(frozen=True)
class Whole:
    """NuSMV, which reads the loop once for all claims and then says everything."""

    engine: "NuSmv"

    @property
    def name(self) -> str:
        """The engine, as findings name it."""
        return self.engine.name

    def judge_all(self, claims: Sequence[Claim], say: SayOpinion) -> None:
        """Say of each claim what the program says."""
        for number, opinion in enumerate(self.engine.judge_all(claims)):
            say(number, opinion)


def at_once(name: EngineName, limited: bool) -> bool:
    """Return whether an engine is asked all claims at once; `limited`: any answer may be cut off.

    Z3 is, for what it answers depends on what it was asked before, and that must be the same for any number of
    processes. Where time decides anyway, it is better asked one claim after the other.
    """
    match name:
        case "bdd":
            return False
        case "aig":
            return True
        case "z3" | "nusmv":
            return not limited
        case _:
            assert_never(name)


def batch_of(
    name: EngineName, engines: Engines, compiled: Compiled, properties: Properties, spare: bool = False
) -> Batch:
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
    """Return an engine for claims about a compiled model, which gives up after so many seconds (default: its own)."""
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
