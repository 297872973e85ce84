"""The state of a checker and its modules (docs/language.md section 3), as values."""

from collections.abc import Callable, Iterable
from dataclasses import field, replace
from typing import Literal

from exover.dataclass import dataclass
from exover.model.event import Args
from exover.model.expression import Outcome
from exover.model.model import Model
from exover.model.types import Value


@dataclass(frozen=True, slots=True)
class Slot:
    """A slot that is not idle, with the arguments it was launched with."""

    phase: Literal["running", "stopping"]
    args: Args


@dataclass(frozen=True, slots=True)
class Place:
    """A waiting place that is taken; it is `clearing` or else waiting.

    `launch_rule` is the origin, None if it was asked for; answers name it, and no decision depends on it.
    """

    clearing: bool
    args: Args
    launch_rule: str | None = field(default=None, compare=False)


SlotId = tuple[str, int]
"""A request's name and the index of one of its slots."""


@dataclass(frozen=True, slots=True)
class State:
    """Everything that an answer depends on; an idle slot, an empty waiting place and a missing past are None.

    Equal states have the same decisions: equality ignores `refused` and origins, which no decision depends on.
    """

    slots: dict[str, tuple[Slot | None, ...]]
    places: dict[str, Place | None]
    past: dict[str, Args | None]
    last: dict[str, Outcome]
    readings: dict[str, Value]
    """Posters, module states and latches by full name."""
    levels: dict[str, int]
    held: frozenset[SlotId] = frozenset()
    """The slots that are not idle: redundant with `slots`, kept for speed."""
    refused: dict[str, str] = field(default_factory=dict, compare=False)
    """The launch rules that the last step tried and refused, each with the rule that refused it."""

    def key(self) -> tuple[object, ...]:
        """Return a hashable value, equal for equal states of one model."""
        parts = (self.slots, self.places, self.past, self.last, self.readings, self.levels)
        return tuple(tuple(part.values()) for part in parts)

    def observed(self, name: str) -> Value:
        """Return what a poster reads, or the level of a consumable."""
        return self.levels[name] if name in self.levels else self.readings[name]

    def with_slot(self, slot: SlotId, content: Slot | None) -> "State":
        """Return the state with this content of a slot; an index one past the last adds a slot."""
        name, index = slot
        before = self.slots[name]
        slots = {**self.slots, name: (*before[:index], content, *before[index + 1 :])}
        held = self.held | {slot} if content else self.held - {slot}
        rest = (self.places, self.past, self.last, self.readings, self.levels)
        return State(slots, *rest, held, self.refused)  # `replace` takes three times as long

    def with_place(self, request: str, place: Place | None) -> "State":
        """Return the state with this waiting place of a request."""
        return replace(self, places={**self.places, request: place})

    def with_reading(self, name: str, value: Value) -> "State":
        """Return the state in which a poster, module state or latch has this value."""
        return replace(self, readings={**self.readings, name: value})

    def with_level(self, resource: str, level: int) -> "State":
        """Return the state with this level of a consumable."""
        return replace(self, levels={**self.levels, resource: level})

    def with_observed(self, name: str, value: Value) -> "State":
        """Return the state in which a poster reads so, or a consumable has this level."""
        if name not in self.levels:
            return self.with_reading(name, value)
        assert isinstance(value, int), "validated"
        return self.with_level(name, value)

    def with_past(self, request: str, values: Args | None) -> "State":
        """Return the state with this past of a request."""
        return replace(self, past={**self.past, request: values})

    def unrefused(self) -> "State":
        """Return the state without remembered refusals, so that the next step answers every refusal."""
        return replace(self, refused={})

    def idle(self, slots: Iterable[SlotId]) -> "State":
        """Return the state with these slots taken as idle."""
        found = frozenset(slots)
        if not found:
            return self
        contents = dict(self.slots)
        for name, index in found:
            before = contents[name]
            contents[name] = (*before[:index], None, *before[index + 1 :])
        rest = (self.places, self.past, self.last, self.readings, self.levels)
        return State(contents, *rest, self.held - found, self.refused)

    def once_stopped(self) -> "State":
        """Return the state with the stopping slots taken as idle."""
        return self.idle(slot for slot in self.held if self.phase(slot) == "stopping")

    def phase(self, slot: SlotId) -> Literal["idle", "running", "stopping"]:
        """Return the phase of a slot."""
        content = self.slots[slot[0]][slot[1]]
        return content.phase if content else "idle"

    def find(self, wanted: Callable[[Slot], bool], requests: Iterable[str] | None = None) -> list[SlotId]:
        """Return the active slots whose content is `wanted`, of all requests or of the listed ones in that order."""
        names = self.slots if requests is None else requests
        return [(name, i) for name in names for i, slot in enumerate(self.slots[name]) if slot and wanted(slot)]

    def active(self, requests: Iterable[str] | None = None) -> list[SlotId]:
        """Return the active slots."""
        return self.find(lambda slot: True, requests)

    def running(self, requests: Iterable[str] | None = None) -> list[SlotId]:
        """Return the running slots."""
        return self.find(lambda slot: slot.phase == "running", requests)

    def stopping(self) -> list[SlotId]:
        """Return the stopping slots."""
        return self.find(lambda slot: slot.phase == "stopping")


def resting(model: Model) -> State:
    """Return the initial state but with every latch clear: all idle, nothing waits, no past, initial values."""
    return State(
        slots={request.name: (None,) * request.instances for request in model.requests},
        places={request.name: None for request in model.requests},
        past={request.name: None for request in model.requests},
        last={request.name: "none" for request in model.requests},
        readings={v.name: v.initial for v in model.variables} | {latch.name: False for latch in model.latches},
        levels={resource.name: resource.initial for resource in model.resources if resource.consumable},
    )
