"""The states that a decision supposes, told by what differs from the present one."""

from dataclasses import field
from typing import Literal

from exover.dataclass import dataclass
from exover.model.model import Request

KillTarget = tuple[str, int | None]
"""All slots of a request, or one of them; the newcomer is none of these."""
Phases = tuple[Literal["running", "stopping"], ...]


@dataclass(frozen=True, slots=True)
class ParameterOwner:
    """Whose parameters `Param` reads: those of the request that is looked at now, or those of its slot `slot`."""

    request: str
    slot: int | None = None


@dataclass(frozen=True, slots=True)
class View:
    """A supposed state: what differs from the present one.

    `newcomer` runs in a slot of its own, its `on launch` and `consumes` applied; the slots of `idle`, by request and
    slot or None for all, are idle where their condition holds; `once_stopped`: so are all stopping ones; what is
    clearing at a request of `crowd` runs too.
    """

    newcomer: Request | None = None
    idle: dict[str, dict[int | None, int]] = field(default_factory=dict)
    once_stopped: bool = False
    crowd: frozenset[str] = frozenset()

    @property
    def phases(self) -> Phases:
        """The phases of the slots that are active."""
        return ("running",) if self.once_stopped else ("running", "stopping")

    def touches(self, request: str) -> bool:
        """Return whether more or less slots of a request may be active than those in `phases`."""
        newcomer = self.newcomer is not None and self.newcomer.name == request
        return newcomer or request in self.idle or request in self.crowd


PRESENT = View()
