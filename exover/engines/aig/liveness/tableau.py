"""Formulas of LTL as monitors, by tableaux: a run satisfies its formula if it stays for ever and sees all signals.

What a formula promises of the next moment is guessed by inputs and checked there (Clarke, Grumberg, Hamaguchi 1994).
That an until comes true is a signal, to be seen again and again. The guesses of the start enter with the first step.
"""

from collections.abc import Mapping
from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import FALSE, TRUE, Literal
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.liveness.k_liveness import Staying, fair_reports
from exover.loop.formula_classes import Lingering, lingering_of, undoubled
from exover.model.property import TRUE as ALWAYS
from exover.model.property import Conjunction, Disjunction, Formula, Negation, Next, Until, momentary, parts_of


def staying(encoding: Encoding, path: Formula, fair: bool) -> Staying:
    """Return the monitor of a formula of LTL; if `fair`, its signals include that each slot is idle or reported."""
    signals = fair_reports(encoding) if fair else ()
    formula = undoubled(path)
    match formula:
        case Until(left, goal) if left == ALWAYS and momentary(goal):
            return _lingering(encoding, Lingering(goal, ALWAYS), signals)
        case Until() if lingering := lingering_of(formula):
            return _lingering(encoding, lingering, signals)
        case Negation(Until(left, bad)) if left == ALWAYS and momentary(bad):
            return _always(encoding, Negation(bad), signals)
    return Tableau(encoding, formula).staying(signals)


def _lingering(encoding: Encoding, lingering: Lingering, signals: tuple[Literal, ...]) -> Staying:
    """Return the monitor of a run that comes to where it must stay; it needs no guesses."""
    graph, stays = encoding.graph, encoding.moments.truth(lingering.stays)
    begun = graph.latch(encoding.moments.at_start(lingering.whole))
    after = graph.conjunction(stays, graph.any((begun, encoding.moments.truth(lingering.since))))
    encoding.follow(begun, after)
    return Staying(begun, graph.all((encoding.legal, begun, stays)), signals)


def _always(encoding: Encoding, stays: Formula, signals: tuple[Literal, ...]) -> Staying:
    """Return the monitor of a formula of one moment that must be true from the start on; it needs no guesses."""
    graph, here = encoding.graph, encoding.moments.truth(stays)
    begun = graph.latch(encoding.moments.at_start(stays))
    after = graph.conjunction(begun, here)
    encoding.follow(begun, after)
    return Staying(begun, graph.conjunction(encoding.legal, after), signals)


@dataclass
class Tableau:
    """The promises that a formula makes about the next moment, each with the latch of the last guess."""

    encoding: Encoding
    formula: Formula
    promises: dict[Formula, Literal] = field(default_factory=dict)
    """By promise, a next or until formula, a latch: what was guessed of it at the last moment."""

    def __post_init__(self) -> None:
        self._collect(self.formula)

    def _collect(self, formula: Formula) -> None:
        for part in parts_of(formula) if not momentary(formula) else ():
            self._collect(part)
        if isinstance(formula, Next | Until) and formula not in self.promises:
            self.promises[formula] = self.encoding.graph.latch(False)

    def staying(self, signals: tuple[Literal, ...]) -> Staying:
        """Return the monitor: a run stays as long as no guess has been wrong."""
        encoding, graph = self.encoding, self.encoding.graph
        taken, going = graph.latch(False), graph.latch(True)
        first = {part: graph.input() for part in self.promises}
        here = {part: graph.choose(taken, latch, first[part]) for part, latch in self.promises.items()}
        guessed = {part: graph.input() for part in self.promises}
        truth: dict[Formula, Literal] = {}
        self._truths(self.formula, guessed, truth, after=True)
        right = [graph.differ(here[part], truth[_of_next(part)]) ^ 1 for part in self.promises]
        start: dict[Formula, Literal] = {}
        self._truths(self.formula, first, start, after=False)
        right.append(graph.any((taken, start[self.formula])))
        good = graph.all((going, *right))
        for part, latch in self.promises.items():
            encoding.follow(latch, guessed[part])
        encoding.following[taken] = graph.any((taken, encoding.legal))
        encoding.follow(going, good)
        kept = [graph.any((truth[part] ^ 1, truth[part.right])) for part in self.promises if isinstance(part, Until)]
        return Staying(going, graph.conjunction(encoding.legal, good), (*signals, *kept))

    def _truths(
        self, formula: Formula, guesses: Mapping[Formula, Literal], found: dict[Formula, Literal], after: bool
    ) -> None:
        """Put into `found` the literal of each part of a formula at the moment after the step, or at the start."""
        if formula in found:
            return
        graph, encoding = self.encoding.graph, self.encoding
        if momentary(formula):
            found[formula] = (
                encoding.moments.truth(formula) if after else (FALSE, TRUE)[encoding.moments.at_start(formula)]
            )
            return
        for part in parts_of(formula):
            self._truths(part, guesses, found, after)
        match formula:
            case Negation(part):
                found[formula] = found[part] ^ 1
            case Conjunction(parts):
                found[formula] = graph.all(found[part] for part in parts)
            case Disjunction(parts):
                found[formula] = graph.any(found[part] for part in parts)
            case Next():
                found[formula] = guesses[formula]
            case Until(left, right):
                found[formula] = graph.any((found[right], graph.conjunction(found[left], guesses[formula])))
            case _:
                raise TypeError("a formula of LTL has no path quantifier")


def _of_next(part: Formula) -> Formula:
    """Return what a promise says is true of the next moment."""
    return part.part if isinstance(part, Next) else part
