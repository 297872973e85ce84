"""Classes of pasts: the arguments and results of the last ok that no test and no condition tells apart."""

from dataclasses import field
from functools import cached_property

from exover.dataclass import dataclass
from exover.loop.finite.argument_loader import ArgumentLoader
from exover.loop.tracked_predicates import TrackedPast
from exover.model.evaluate import Scope, bind, holds
from exover.model.event import Args
from exover.model.expression import Param, operands
from exover.model.state import State

PastSign = tuple[object, ...]
"""The signature of a past: equal iff no test of the tables and no condition tells two pasts apart."""


@dataclass
class PastClasses:
    """The classes of pasts of one request, numbered in the order of the samples.

    `tracked`: what conditions tell apart of a past. `nothing`: any state, for the evaluation of conditions that read
    only arguments.
    """

    loader: ArgumentLoader
    tracked: TrackedPast | None
    nothing: State
    samples: list[Args]
    result_samples: list[Args]
    _signs: dict[Args, tuple[PastSign, ...]] = field(default_factory=dict)
    _agreed: dict[tuple[tuple[int, ...], tuple[int, ...]], list[bool]] = field(default_factory=dict)
    _numbers: dict[tuple[Args, Args], int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._rows = self.loader.tables.pasts[self.loader.row.pasts : self.loader.row.pasts_end]
        self._told = self.tracked or TrackedPast()

    @property
    def remembered(self) -> bool:
        """Whether anything reads the past of the request."""
        return self.tracked is not None or bool(self._rows)

    @cached_property
    def representatives(self) -> list[Args]:
        """One tuple of arguments and results for each class."""
        return [values for _, values in self._by_sign.values()]

    @cached_property
    def _by_sign(self) -> dict[PastSign, tuple[int, Args]]:
        """By signature the number of the class, and its first sample."""
        told_apart: dict[Args, Args] = {}
        for args in self.samples:
            told_apart.setdefault(self._read_of(args), args)
        found: dict[PastSign, tuple[int, Args]] = {}
        for args in told_apart.values():
            for results, sign in zip(self.result_samples, self.signs(args), strict=True):
                found.setdefault(sign, (len(found), args + results))
        return found

    def number(self, args: Args, results: Args) -> int:
        """Return the number of the class of the past that an ok with these arguments and results leaves."""
        key = self._read_of(args), results
        if key not in self._numbers:
            self._numbers[key] = self._by_sign[self._sign(args, results)][0]
        return self._numbers[key]

    def signs(self, args: Args) -> tuple[PastSign, ...]:
        """Return for each sample of the results the signature of a past with these arguments.

        It is cached by the arguments that anything reads of a past.
        """
        if not self.remembered:
            return self._told_of_nothing
        known = self._read_of(args)
        if known not in self._signs:
            self._signs[known] = tuple(self._sign(args, results) for results in self.result_samples)
        return self._signs[known]

    @cached_property
    def _told_of_nothing(self) -> tuple[PastSign, ...]:
        return tuple(((), (), ()) for _ in self.result_samples)

    def _sign(self, args: Args, results: Args) -> PastSign:
        values = bind((*self.loader.params, *self.loader.results), args + results)
        scope = Scope(values)
        truths = tuple(holds(self.loader.model, self.nothing, each, scope) for each in self._told.comparisons)
        return self.entries(args, results), truths, tuple(values[name] for name in sorted(self._told.exact))

    def _read_of(self, args: Args) -> Args:
        """Return the arguments that a test or a condition reads of a past."""
        return tuple([args[number] for number in self._read])

    @cached_property
    def _read(self) -> tuple[int, ...]:
        read = {
            term.name for each in self._told.comparisons for term in operands(each) if isinstance(term, Param)
        } | self._told.exact
        named = {number for number, parameter in enumerate(self.loader.params) if parameter.name in read}
        return tuple(sorted(named.union(*(self.loader.looked_at(row.predicate) for row in self._rows))))

    def entries(self, args: Args, results: Args) -> tuple[int, ...]:
        """Return the values of the entries of the past after an ok with these arguments and results.

        They are cached by the values of the entries that they depend on.
        """
        entries = self.loader.loaded(args + results)
        found = [0] * len(self._rows)
        for tested, numbers in self._by_tested.items():
            key = tested, tuple([entries[entry] for entry in tested])
            if key not in self._agreed:
                self._agreed[key] = [self.loader.agrees(self._rows[number].predicate, entries) for number in numbers]
            for number, agreed in zip(numbers, self._agreed[key], strict=True):
                found[number] = int(agreed)
        return tuple(found)

    @cached_property
    def _by_tested(self) -> dict[tuple[int, ...], list[int]]:
        """The entries of the past, by number, by the entries that their predicates test."""
        found: dict[tuple[int, ...], list[int]] = {}
        for number, row in enumerate(self._rows):
            found.setdefault(tuple(sorted(self.loader.tables.tested(row.predicate))), []).append(number)
        return found
