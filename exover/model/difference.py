"""Values that say how the answers of two versions of a spec differ (docs/diff.md)."""

from collections.abc import Iterator
from typing import Literal

from exover.dataclass import dataclass
from exover.model.event import Action, Event
from exover.model.model import Location
from exover.model.property import Properties
from exover.model.versions import Versions

DeedKind = Literal["launched", "rejected", "waiting", "killed", "violation"]
"""What an answer does with a request; a violation belongs to no request."""
DEED_KINDS: tuple[DeedKind, ...] = ("rejected", "launched", "waiting", "killed")


@dataclass(frozen=True, slots=True)
class AnswerChange:
    """A deed that NEW does in some step and OLD does not in the same step; with `gone`, OLD does it and NEW does not.

    `request`: as NEW calls it; None for violations. `weaker`: NEW launches what OLD rejects or leaves waiting.
    """

    request: str | None
    deed: DeedKind
    gone: bool = False
    weaker: bool = False

    @property
    def word(self) -> str:
        """The change in words, as reports write it: "newly launched", "no longer raised"."""
        return f"{'no longer' if self.gone else 'newly'} {'raised' if self.request is None else self.deed}"

    @property
    def subject(self) -> str:
        """The name of the request, or "violation"."""
        return self.request or "violation"


def changes(versions: Versions) -> Iterator[AnswerChange]:
    """Yield the changes to look for, request by request in the order of NEW, those of violations last."""
    for _, request in versions.requests:
        yield AnswerChange(request.name, "launched", weaker=True)
        yield from (AnswerChange(request.name, deed) for deed in DEED_KINDS)
        yield from (AnswerChange(request.name, deed, gone=True) for deed in DEED_KINDS)
    yield from (AnswerChange(None, "violation", gone) for gone in (False, True))


@dataclass(frozen=True, slots=True)
class CommonStep:
    """The events that OLD and NEW get in one step, and their answers; an event is None if the version has no such."""

    events: tuple[Event | None, Event | None]
    answers: tuple[tuple[Action, ...], tuple[Action, ...]]


@dataclass(frozen=True, slots=True)
class Difference:
    """A change, and a run of both whose last step shows it; `shortest`: no shorter run shows it, which is proved."""

    change: AnswerChange
    steps: tuple[CommonStep, ...]
    shortest: bool


@dataclass(frozen=True, slots=True)
class Undecided:
    """A change for which it is unknown whether some run shows it, and why it is unknown."""

    change: AnswerChange
    reason: str


@dataclass(frozen=True, slots=True)
class PropertyChange:
    """The verdict on a property in OLD and in NEW: `holds`, `violated`, `unknown`; `none` where it is not stated."""

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
    """The result of comparing two versions.

    `files`: the names of OLD and NEW; `properties`: their properties; `judged`: the verdicts on those.
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
        """`changed` if a difference is shown, else `unknown` if a change or a property is undecided, else `same`."""
        if self.differences or any(each.decided for each in self.judged):
            return "changed"
        return "unknown" if self.undecided or any(each.unknown for each in self.judged) else "same"

    @property
    def weaker(self) -> bool | None:
        """Whether NEW launches in some step what OLD rejects or leaves waiting; None if that is not known."""
        if any(each.change.weaker for each in self.differences):
            return True
        return None if any(each.change.weaker for each in self.undecided) else False

    @property
    def left_out(self) -> tuple[str, ...]:
        """Sentences on events that only one version has or may get, which are not compared."""
        alone = [
            f"{side} alone has {', '.join(self.versions.alone(number))}: what is answered about it is not compared, "
            "what it does to others is"
            for number, side in enumerate(("OLD", "NEW"))
            if self.versions.alone(number)
        ]
        old, new = (tuple(each.formula for each in found.assumptions) for found in self.properties)
        assumed = ["the assumptions differ: only steps that both allow are compared"] if old != new else []
        return (*alone, *self.versions.narrowed(), *assumed)

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on what is not compared, or only in part."""
        single = [
            f"{side} alone has the properties {', '.join(names)}"
            for side, names in (("OLD", self._properties_without("new")), ("NEW", self._properties_without("old")))
            if names
        ]
        before = {} if self.versions.renamed else {each.name: each.formula for each in self.properties[0].properties}
        after = {each.name: each.formula for each in self.properties[1].properties}
        other = [name for name, formula in after.items() if before.get(name, formula) != formula]
        restated = [f"NEW states otherwise the properties {', '.join(other)}"] if other else []
        return (*self.left_out, *single, *restated)

    def _properties_without(self, side: str) -> list[str]:
        return [each.name for each in self.judged if getattr(each, side) == "none"]
