"""What differs between the answers of two versions of a spec (docs/diff.md)."""

from collections.abc import Iterator
from typing import Literal

from exover.dataclass import dataclass
from exover.model.event import Action, Event
from exover.model.model import Location
from exover.model.property import Properties
from exover.model.versions import Versions

DeedKind = Literal["launched", "rejected", "waiting", "killed", "violation"]
"""What an answer does with a request; a violation is of no request."""
DEED_KINDS: tuple[DeedKind, ...] = ("rejected", "launched", "waiting", "killed")


@dataclass(frozen=True, slots=True)
class AnswerChange:
    """What NEW does with a request in a step in which OLD does not, or, if it is `gone`, the other way round.

    `request`: as NEW calls it; None for violations. `weaker`: NEW launches what OLD rejects or leaves waiting.
    """

    request: str | None
    deed: DeedKind
    gone: bool = False
    weaker: bool = False

    @property
    def word(self) -> str:
        """The change in words, as reports have it."""
        return f"{'no longer' if self.gone else 'newly'} {'raised' if self.request is None else self.deed}"

    @property
    def subject(self) -> str:
        """What changes."""
        return self.request or "violation"


def changes(versions: Versions) -> Iterator[AnswerChange]:
    """Yield the changes that are asked about, request by request in the order of NEW."""
    for _, request in versions.requests:
        yield AnswerChange(request.name, "launched", weaker=True)
        yield from (AnswerChange(request.name, deed) for deed in DEED_KINDS)
        yield from (AnswerChange(request.name, deed, gone=True) for deed in DEED_KINDS)
    yield from (AnswerChange(None, "violation", gone) for gone in (False, True))


@dataclass(frozen=True, slots=True)
class CommonStep:
    """What came to OLD and to NEW, and what they answered; None: it is nothing that this version knows."""

    events: tuple[Event | None, Event | None]
    answers: tuple[tuple[Action, ...], tuple[Action, ...]]


@dataclass(frozen=True, slots=True)
class Difference:
    """A change, and a run of both that shows it in its last step; `shortest`: it is proved that none is shorter."""

    change: AnswerChange
    steps: tuple[CommonStep, ...]
    shortest: bool


@dataclass(frozen=True, slots=True)
class Undecided:
    """A change of which it is not known whether some run shows it, for this reason."""

    change: AnswerChange
    reason: str


@dataclass(frozen=True, slots=True)
class PropertyChange:
    """What is known of a property in OLD and in NEW: `holds`, `violated`, `unknown`; `none` where it is not there."""

    name: str
    old: str
    new: str
    location: Location

    @property
    def decided(self) -> bool:
        """Whether it holds in one version and is violated in the other."""
        return {self.old, self.new} == {"holds", "violated"}

    @property
    def unknown(self) -> bool:
        """Whether it could not be decided in some version."""
        return "unknown" in (self.old, self.new)


@dataclass(frozen=True)
class Compared:
    """All that is known of what differs between two versions.

    `files`: what OLD and NEW are called; `properties`: their properties files.
    """

    version: str
    versions: Versions
    files: tuple[str, str]
    properties: tuple[Properties, Properties]
    differences: tuple[Difference, ...]
    undecided: tuple[Undecided, ...]
    judged: tuple[PropertyChange, ...]

    @property
    def verdict(self) -> Literal["changed", "unknown", "same"]:
        """`changed` if something is shown to differ, else `unknown` if something is not known."""
        if self.differences or any(each.decided for each in self.judged):
            return "changed"
        return "unknown" if self.undecided or any(each.unknown for each in self.judged) else "same"

    @property
    def weaker(self) -> bool | None:
        """Whether NEW launches what OLD refuses or lets wait; None if that is not known."""
        if any(each.change.weaker for each in self.differences):
            return True
        return None if any(each.change.weaker for each in self.undecided) else False

    @property
    def notes(self) -> tuple[str, ...]:
        """What is not compared, or only in part."""
        alone = [
            f"{side} alone has {', '.join(self.versions.alone(number))}: what is answered about it is not compared, "
            "what it does to others is"
            for number, side in enumerate(("OLD", "NEW"))
            if self.versions.alone(number)
        ]
        old, new = (tuple(each.formula for each in found.assumptions) for found in self.properties)
        single = [
            f"{side} alone has the properties {', '.join(names)}"
            for side, names in (("OLD", self._properties_without("new")), ("NEW", self._properties_without("old")))
            if names
        ]
        before = {} if self.versions.renamed else {each.name: each.formula for each in self.properties[0].properties}
        after = {each.name: each.formula for each in self.properties[1].properties}
        other = [name for name, formula in after.items() if before.get(name, formula) != formula]
        restated = [f"NEW states otherwise the properties {', '.join(other)}"] if other else []
        assumed = ["the assumptions differ: only steps that both allow are compared"] if old != new else []
        return (*alone, *self.versions.narrowed(), *assumed, *single, *restated)

    def _properties_without(self, side: str) -> list[str]:
        return [each.name for each in self.judged if getattr(each, side) == "none"]
