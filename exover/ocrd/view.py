"""The states that a decision supposes, described by their differences from the present state."""

from dataclasses import field
from typing import Literal

from exover.dataclass import dataclass
from exover.model.model import Request

KillTarget = tuple[str, int | None]
"""A request and one of its slots, or None for all; the slot of the newcomer is never meant."""
Phases = tuple[Literal["running", "stopping"], ...]


@dataclass(frozen=True, slots=True)
class ParameterOwner:
    """Whose parameters `Param` reads: the loaded ones of a request, those of its slot `slot`, or those of its waiting
    place (`in_place`).

    `of_copy`: the clause is that of a rule of which there is a copy for each slot, and this is the owner of one copy.
    `clause`: whose parameters `Own` reads inside a `with`, the owner of the clause in which that stands.
    """

    request: str
    slot: int | None = None
    in_place: bool = False
    of_copy: bool = False
    clause: "ParameterOwner | None" = None

    @property
    def held(self) -> bool:
        """Whether a slot or the waiting place holds the parameters."""
        return self.in_place or self.slot is not None


@dataclass(frozen=True, slots=True)
class View:
    """A supposed state, as differences from the present one.

    `newcomer` runs in a slot of its own, its `on launch` and `consumes` applied. `idle` maps a request and a slot, or
    None for all, to the condition under which it is idle; with `once_stopped`, stopping slots are idle too. What is
    clearing at a request of `clearing` runs too.
    """

    newcomer: Request | None = None
    idle: dict[str, dict[int | None, int]] = field(default_factory=dict)
    once_stopped: bool = False
    clearing: frozenset[str] = frozenset()

    @property
    def phases(self) -> Phases:
        """The phases of the slots that are active."""
        return ("running",) if self.once_stopped else ("running", "stopping")

    def touches(self, request: str) -> bool:
        """Return whether the view supposes another number of active slots of a request than those in `phases`."""
        newcomer = self.newcomer is not None and self.newcomer.name == request
        return newcomer or request in self.idle or request in self.clearing


PRESENT = View()
