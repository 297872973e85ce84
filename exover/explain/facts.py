"""The facts that determine the truth of a condition: its decisive comparisons and predicates, with what they read."""

from collections.abc import Iterator, Mapping
from dataclasses import field
from typing import assert_never

from exover.dataclass import dataclass
from exover.model.evaluate import NOTHING, Scope, bind, each_active, holds, share_of, value_of
from exover.model.event import Args
from exover.model.explanation import Fact
from exover.model.expression import (
    And,
    Compare,
    Cond,
    Const,
    Count,
    Last,
    ModelTerm,
    Not,
    Or,
    Own,
    Param,
    Past,
    Status,
    Used,
    leaves,
    operands,
)
from exover.model.model import Model
from exover.model.state import SlotId, State
from exover.model.wording import condition_text, named_text, term_text, value_text


@dataclass(frozen=True)
class Facts:
    """Reads facts off a state; `imagined`: by slot that is hypothetical, the words for what is in it."""

    model: Model
    state: State
    imagined: Mapping[SlotId, str] = field(default_factory=dict)

    def of(self, cond: Cond, scope: Scope = NOTHING) -> tuple[Fact, ...]:
        """Return the atoms that decide the truth, each once: of an `and` or `or` the parts that are true iff it is."""
        return tuple(dict.fromkeys(self._settling(cond, scope)))

    def _settling(self, cond: Cond, scope: Scope) -> Iterator[Fact]:
        match cond:
            case Not(part):
                yield from self._settling(part, scope)
            case And(parts) | Or(parts):
                truth = holds(self.model, self.state, cond, scope)
                for part in parts:
                    if holds(self.model, self.state, part, scope) == truth:
                        yield from self._settling(part, scope)
            case Compare() | Status() | Past() | Last():
                yield Fact(condition_text(cond), holds(self.model, self.state, cond, scope), self._read(cond, scope))
            case _:
                assert_never(cond)

    def active(self, slot: SlotId) -> Fact:
        """Return the fact that this slot is active, or that it is not."""
        name, index = slot
        return Fact(f"active({name})", bool(self.state.slots[name][index]), f"{self._slot(slot)} {self._phase(slot)}")

    def _read(self, atom: Compare | Status | Past | Last, scope: Scope) -> str:
        match atom:
            case Compare(_, left, right):
                terms = dict.fromkeys((*leaves(left), *leaves(right)))
                return ", ".join(self._term(term, scope) for term in terms if not isinstance(term, Const))
            case Status("waiting", name, where):
                place = self.state.places[name]
                return (
                    f"{name} waits{_having(self._where(where, name, place.args))}"
                    if place
                    else f"nothing waits at {name}"
                )
            case Status(phase, name, where):
                return self._slots(phase, name, where, scope)
            case Past(name, where):
                values = self.state.past[name]
                if values is None:
                    return f"{name} has no past"
                return f"{name} has ended ok{_having(self._where(where, name, values))}"
            case Last(name, _):
                return f"last({name}) is {self.state.last[name]}"
            case _:
                assert_never(atom)

    def _term(self, term: ModelTerm, scope: Scope) -> str:
        """Return a term with its value; of a count or a used share, also the slots that make it up."""
        value = value_of(self.model, self.state, term, scope)
        match term:
            case Count(requests):
                found = [self._slot(slot) for slot in self.state.active(requests)]
                return f"{value} active" + (f" ({', '.join(found)})" if found else "")
            case Used(resource):
                active = each_active(self.state)
                shares = [(name, share_of(self.model, self.state, name, slot, resource)) for name, slot in active]
                held = ", ".join(f"{name} {share}" for name, share in shares if share)
                return f"used({resource}) = {value}" + (f" ({held})" if held else "")
            case _:
                return f"{term_text(term)} = {value_text(value)}"

    def _slots(self, phase: str, name: str, where: Cond | None, scope: Scope) -> str:
        """Return the slots of this phase in words: those that satisfy `where`, or all if none does."""
        params = self.model.request[name].params
        inside: list[tuple[str, bool]] = []
        for index, slot in enumerate(self.state.slots[name]):
            if slot and phase in ("active", slot.phase):
                right = where is None or holds(self.model, self.state, where, scope.about(bind(params, slot.args)))
                read = self._where(where, name, slot.args, scope)
                told = f"has {read}" if read else self._phase((name, index))
                inside.append((f"{self._slot((name, index))} {told}", right))
        found = [text for text, right in inside if right] or [text for text, _ in inside]
        return ", ".join(found) or f"{name} is {'idle' if phase == 'active' else f'not {phase}'}"

    def _where(self, where: Cond | None, name: str, values: Args, scope: Scope = NOTHING) -> str:
        """Return in words those of the values that `where` reads."""
        if where is None:
            return ""
        request = self.model.request[name]
        read = set(operands(where))
        pairs = zip((*request.params, *request.results), values, strict=False)
        told = [named_text((p,), (v,)) for p, v in pairs if Param(p.name) in read]
        told += [f"self.{p} = {value_text(v)}" for p, v in scope.params.items() if Own(p) in read]
        return ", ".join(told)

    def _slot(self, slot: SlotId) -> str:
        name, index = slot
        imagined = self.imagined.get(slot)
        return imagined or (f"slot {index} of {name}" if self.model.request[name].instances > 1 else name)

    def _phase(self, slot: SlotId) -> str:
        name, index = slot
        content = self.state.slots[name][index]
        return f"is {content.phase}" if content else "is idle"


def _having(values: str) -> str:
    return f" with {values}" if values else ""
