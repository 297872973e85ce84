"""Where the answers of two versions to one step differ, by request and deed, as literals of their graph.

Answers are compared without the rules and texts that they name, and as sets: what is launched in which slot, killed,
rejected with which arguments, put into the waiting place. Until then both have answered alike, so slots and waiting
places hold the same in both.
"""

from collections.abc import Iterable, Sequence
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import FALSE, Literal
from exover.engines.aig.circuit.words import as_word, lit
from exover.engines.aig.encoding.common_events import NEW, OLD, converted
from exover.engines.aig.encoding.versions import Version, VersionPair
from exover.loop.exact.symbolic_state import Note
from exover.loop.exact.term import Term
from exover.model.difference import DEED_KINDS, AnswerChange, DeedKind
from exover.model.model import Request
from exover.model.property import Broken, Disjunction
from exover.model.types import Enum

ArgumentTerms = tuple[Term, ...]
"""Arguments by parameter, in the order of NEW and as values of the types of NEW."""


@dataclass(frozen=True, slots=True)
class SymbolicDeeds:
    """What a step does with a request in one version.

    By slot where it is launched, with which arguments, and where it is killed; where it is rejected, with which
    arguments; where a newcomer is put into the waiting place, where something stands there then, and what.
    """

    launched: tuple[tuple[Literal, ArgumentTerms], ...]
    killed: tuple[Literal, ...]
    rejected: tuple[tuple[Literal, ArgumentTerms], ...]
    put: Literal
    taken: Literal
    standing: ArgumentTerms


@dataclass(frozen=True)
class Differences:
    """Asks of two versions what the next step does in one and not in the other."""

    pair: VersionPair

    def literals(self, changes: Sequence[AnswerChange]) -> list[Literal]:
        """Return by change where a step that can happen shows it."""
        found = []
        for change in changes:
            where = self._violation(change.gone) if change.request is None else self._of_request(change)
            found.append(self.pair.graph.conjunction(self.pair.legal, where))
        return found

    @cached_property
    def agree(self) -> Literal:
        """Where the deeds and violations of a step are the same."""
        graph = self.pair.graph
        found = [self._violation(gone) for gone in (False, True)]
        for _, request in self.pair.loops.versions.requests:
            for gone in (False, True):
                found += self._by_deed[request.name, gone].values()
        return graph.any(found) ^ 1

    # ---- by request ----

    def _of_request(self, change: AnswerChange) -> Literal:
        assert change.request is not None
        graph = self.pair.graph
        where = self._by_deed[change.request, change.gone][change.deed]
        if change.gone:
            return graph.conjunction(where, graph.any(self._by_deed[change.request, False].values()) ^ 1)
        if change.deed != "launched":
            return where
        weaker = self._weaker(change.request)
        return weaker if change.weaker else graph.conjunction(where, weaker ^ 1)

    @cached_property
    def _by_deed(self) -> dict[tuple[str, bool], dict[DeedKind, Literal]]:
        """By request, and whether it is OLD that does it, where only one version does something."""
        found = {}
        for _, request in self.pair.loops.versions.requests:
            both = self._deeds[request.name]
            for gone in (False, True):
                mine, other = both if gone else both[::-1]
                found[request.name, gone] = dict(zip(DEED_KINDS, self._only(mine, other), strict=True))
        return found

    def _only(self, mine: SymbolicDeeds, other: SymbolicDeeds) -> tuple[Literal, ...]:
        """Return where one version does something that the other does not, in the order of `DEED_KINDS`."""
        graph = self.pair.graph
        rejected = [
            graph.conjunction(where, graph.any(self._alike(each, args, values) for each, values in other.rejected) ^ 1)
            for where, args in mine.rejected
        ]
        superseding = graph.conjunction(other.put, mine.put ^ 1)
        rejected += [
            graph.all((superseding, where, self._alike(other.taken, args, other.standing)))
            for where, args in mine.rejected
        ]
        launched = [self._newly(mine, other, slot) for slot in range(len(mine.launched))]
        there = [*other.killed, *[FALSE] * len(mine.killed)]
        killed = [graph.conjunction(where, no ^ 1) for where, no in zip(mine.killed, there, strict=False)]
        stands = graph.conjunction(mine.taken, self._alike(other.taken, mine.standing, other.standing) ^ 1)
        waiting = (graph.conjunction(mine.put, other.put ^ 1), stands)
        return graph.any(rejected), graph.any(launched), graph.any(waiting), graph.any(killed)

    def _newly(self, mine: SymbolicDeeds, other: SymbolicDeeds, slot: int) -> Literal:
        """Return where one version launches a request in a slot, and the other does not with the same arguments."""
        where, args = mine.launched[slot]
        if slot >= len(other.launched):
            return where
        its, values = other.launched[slot]
        return self.pair.graph.conjunction(where, self._alike(its, args, values) ^ 1)

    def _weaker(self, request: str) -> Literal:
        """Return where NEW launches what OLD rejects or leaves waiting."""
        graph = self.pair.graph
        old, new = self._deeds[request]
        refused = (*old.rejected, (old.taken, old.standing))
        return graph.any(
            graph.conjunction(
                self._newly(new, old, slot), graph.any(self._alike(where, args, values) for where, values in refused)
            )
            for slot, (_, args) in enumerate(new.launched)
        )

    def _alike(self, where: Literal, args: ArgumentTerms, values: ArgumentTerms) -> Literal:
        """Return where `where` is true and the arguments are equal."""
        terms = self.pair.terms
        equal = [lit(terms.equal(a, b)) for a, b in zip(args, values, strict=True)]
        return self.pair.graph.all((where, *equal))

    # ---- what one version does ----

    @cached_property
    def _deeds(self) -> dict[str, tuple[SymbolicDeeds, SymbolicDeeds]]:
        """By request, as NEW calls it, what OLD and NEW do with it."""
        return {
            new.name: (self._of_version(self.pair.old, old, new), self._of_version(self.pair.new, new, new))
            for old, new in self.pair.loops.versions.requests
        }

    def _of_version(self, version: Version, mine: Request, new: Request) -> SymbolicDeeds:
        graph, then = self.pair.graph, version.then
        launched, killed = [], []
        for number in range(mine.instances):
            slot = version.latches.slots[mine.name, number]
            active, stopping = lit(then[slot.active]), lit(then[slot.stopping])
            ended = graph.conjunction(version.steps, self._ends(version, mine.name, number))
            fresh = graph.any((lit(version.before[slot.active]) ^ 1, ended))
            spared = graph.any((lit(version.before[slot.stopping]) ^ 1, ended))
            values = tuple(then[name] for name in slot.args)
            launched.append((graph.conjunction(active, fresh), self._values(values, mine, new)))
            killed.append(graph.conjunction(stopping, spared))
        place = version.latches.places[mine.name]
        standing = tuple(then[name] for name in place.args)
        put = graph.conjunction(version.steps, version.moments.mark(("put", mine.name)))
        return SymbolicDeeds(
            tuple(launched),
            tuple(killed),
            tuple(self._rejected(version.moments.notes("rejected", mine.name), version, mine, new)),
            put,
            lit(then[place.taken]),
            self._values(standing, mine, new),
        )

    def _rejected(
        self, notes: Iterable[Note], version: Version, mine: Request, new: Request
    ) -> Iterable[tuple[Literal, ArgumentTerms]]:
        for note in notes:
            yield self.pair.graph.conjunction(version.steps, lit(note.guard)), self._values(note.args, mine, new)

    def _ends(self, version: Version, request: str, slot: int) -> Literal:
        """Return where the event is a report of a slot."""
        return self.pair.graph.any(lit(version.events[number].chosen) for number in version.reports[request, slot])

    def _values(self, args: Sequence[Term], mine: Request, new: Request) -> ArgumentTerms:
        """Return arguments in the order of NEW; enum values that NEW has not come after those that it has."""
        known = {p.name: (p.type, term) for p, term in zip(mine.params, args, strict=True)}
        found = []
        for parameter in new.params:
            kind, term = known[parameter.name]
            if isinstance(kind, Enum) and isinstance(parameter.type, Enum) and kind.values != parameter.type.values:
                extra = tuple(value for value in kind.values if value not in parameter.type.values)
                wider = Enum((*parameter.type.values, *extra))
                term = converted(self.pair.terms, as_word(term), kind, wider)
            found.append(term)
        return tuple(found)

    # ---- violations ----

    def _violation(self, gone: bool) -> Literal:
        """Return where a step of one version leaves a rule broken, and none is in the other after it."""
        mine, other = (OLD, NEW) if gone else (NEW, OLD)
        raised = (self.pair.sides[mine].steps, self._broken[mine])
        return self.pair.graph.all((*raised, self._broken[other] ^ 1))

    @cached_property
    def _broken(self) -> tuple[Literal, Literal]:
        """Where a rule is broken after the step in each version, also if the event is none of it."""
        old, new = map(self._broken_in, self.pair.sides)
        return old, new

    def _broken_in(self, version: Version) -> Literal:
        broken = Disjunction(tuple(Broken(rule, True) for rule in version.compiled.model.rules))
        moments = version.moments
        return self.pair.graph.choose(version.steps, moments.truth(broken), moments.now(broken))
