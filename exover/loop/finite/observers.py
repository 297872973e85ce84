"""History variables for properties: what the last step did (`asked`, `launched`, …; docs/language.md 8).

Each such predicate of a property or assumption has a variable, which every step clears at its beginning.
"""

from collections.abc import Sequence
from functools import cached_property

from exover.loop.finite.program import Assign, Mark, Program, Switch
from exover.loop.finite.variables import LoopStates, VariableKey
from exover.model.evaluate import Scope, bind, holds
from exover.model.event import Args
from exover.model.property import Happened, Occurrence, Passed
from exover.model.state import resting


class Observers(LoopStates):
    """The parts of programs that note what happens."""

    @cached_property
    def anew(self) -> tuple[Assign, ...]:
        """The assignments with which every step begins: they clear the history variables."""
        return tuple(Assign(var, 0) for var in self.history.values())

    def noted(self, occurrence: Occurrence, request: int, args: Args) -> Program:
        """Return the part that notes an occurrence of the request with these arguments."""
        watching = self._watching.get((occurrence, self.model.requests[request].name), ())
        return tuple(Assign(var, 1) for var, each in watching if self._concerns(each, args))

    def noted_in_slot(self, occurrence: Occurrence, request: int, number: int) -> Program:
        """Return the part that notes an occurrence of the request in this slot."""
        slot = self.tables.requests[request].slots + number
        kinds = [kind.args for kind in self.arguments[request].classes]
        return self._noted_of(occurrence, request, ("class", slot), kinds)

    def marked(self, *label: str) -> Program:
        """Return the part that passes a mark, and notes it if some property asks for it."""
        if label not in self._marks:
            var = self._asked_for.get(label)
            noted = () if var is None else (Assign(var, 1),)
            self._marks[label] = (Mark(label), *noted)
        return self._marks[label]

    @cached_property
    def _marks(self) -> dict[tuple[str, ...], Program]:
        """By label the mark, once it was made."""
        return {}

    @cached_property
    def _asked_for(self) -> dict[tuple[str, ...], int]:
        """By label of a mark that some property asks for, its history variable."""
        return {each.label: var for each, var in self.history.items() if isinstance(each, Passed)}

    def refused(self, request: int) -> Program:
        """Return the part that notes the rejection of the waiting request."""
        if request not in self._refused:
            kinds = [cell.args for cell in self.arguments[request].cells]
            self._refused[request] = self._noted_of("rejected", request, ("cell", request), kinds)
        return self._refused[request]

    @cached_property
    def _refused(self) -> dict[int, Program]:
        """By request the note that what waits is rejected, once it was made."""
        return {}

    def _noted_of(self, occurrence: Occurrence, request: int, holder: VariableKey, kinds: Sequence[Args]) -> Program:
        if (occurrence, self.model.requests[request].name) not in self._watching:
            return ()
        cases = tuple(self.noted(occurrence, request, args) for args in kinds)
        if holder in self.index and any(cases):
            return (Switch(self.index[holder], cases),)
        return cases[0]

    @cached_property
    def _watching(self) -> dict[tuple[Occurrence, str], list[tuple[int, Happened]]]:
        found: dict[tuple[Occurrence, str], list[tuple[int, Happened]]] = {}
        for each, var in self.history.items():
            if isinstance(each, Happened):
                found.setdefault((each.occurrence, each.request), []).append((var, each))
        return found

    def _concerns(self, each: Happened, args: Args) -> bool:
        if each.where is None:
            return True
        scope = Scope(bind(self.model.request[each.request].params, args))
        return holds(self.model, resting(self.model), each.where, scope)
