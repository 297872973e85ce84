"""The work of decision diagrams, limited by what their managers count, so that it ends alike on every machine."""

import warnings
from contextvars import ContextVar
from dataclasses import field
from math import inf
from typing import Any, Self

from exover.dataclass import dataclass

MEMORY = 1 << 30
"""The bytes that a manager may take where its steps are limited: about 25 million nodes.

It ends a single operation that would take too many steps."""
OFTEN, SIZE = 1 << 8, 1 << 6
"""A manager is looked at after `OFTEN` operations; one on a set of n times `SIZE` nodes counts as n more."""
SCANNED = 1 << 12
"""To look at a manager takes it the time of one operation for each so many slots of its tables."""


NO_NODE = ("is `NULL` pointer", "run out of memory", "compose failed", "cofactor failed", "swap failed")
"""What dd says where CUDD has made no node."""


STEP_LIMIT, NODE_LIMIT = "step limit of diagrams", "node limit of diagrams"
"""The reasons of questions without an answer where diagrams took all their steps, or all their memory."""


class OutOfSteps(Exception):
    """Diagrams have taken all the steps, or all the memory, that they may take; the message says which."""


@dataclass
class Effort:
    """The steps that managers have taken in the body of a `with` statement, and the most that they may take there.

    A step is a look-up in the computed table of CUDD, of which each call of a recursive operation makes one. It is no
    generator of `contextlib`: from Python 3.13 on what one raises anew is in a circle with the frames of the body,
    and so are the sets of a manager, which can only be freed before the manager is.
    """

    most: float
    taken: float = 0
    managers: list[tuple[Any, int]] = field(default_factory=list)
    """The managers whose memory is limited, each with what it might take before."""
    _around: "Effort | None" = None

    def __enter__(self) -> Self:
        """Count the steps of all managers here from now on."""
        self._around = current()
        _CURRENT.set(self)
        return self

    def __exit__(self, kind: object, error: BaseException | None, traceback: object) -> None:
        """Give managers the memory back that they might take before; raises `OutOfSteps` if one came to its limit."""
        _CURRENT.set(self._around)
        for manager, memory in self.managers:
            manager.configure(max_memory=memory)
        if self.managers and isinstance(error, ValueError | RuntimeError) and _says_no_node(error):
            self.taken = max(self.taken, self.most)
            raise OutOfSteps(NODE_LIMIT) from None

    def restrict(self, manager: Any) -> None:
        """Limit the memory of one of CUDD's managers until the body ends."""
        if self.most < inf:
            self.managers.append((manager, manager.configure(max_memory=MEMORY)["max_memory"]))

    def take(self, steps: float) -> None:
        """Count steps; raises `OutOfSteps` if they are too many."""
        self.taken += steps
        if self.taken > self.most:
            raise OutOfSteps(STEP_LIMIT)


_CURRENT: ContextVar[Effort | None] = ContextVar("effort", default=None)


def limited(most: float) -> Effort:
    """Return what raises `OutOfSteps` in the body of a `with` statement once all managers together have taken so many
    steps in it, or one its memory.
    """
    return Effort(most)


def current() -> Effort | None:
    """Return the effort of the innermost body of `limited`; None outside of all."""
    return _CURRENT.get()


def _says_no_node(error: Exception) -> bool:
    """Return whether dd has raised an error because CUDD made no node: dd has no exception of its own for that."""
    return any(text in str(error) for text in NO_NODE)


@dataclass
class Meter:
    """Counts the steps of one of CUDD's managers, which it reads now and then: CUDD scans its tables for that."""

    manager: Any
    _rest: int = 0
    _seen: float = 0
    _effort: Effort | None = None

    def work(self, nodes: int) -> None:
        """Count an operation on a set of so many nodes; raises `OutOfSteps` as `Effort.take` does."""
        self._rest -= 1 + nodes // SIZE
        if self._rest < 0:
            self._look()

    def _look(self) -> None:
        """Count the steps since the last look in the same body."""
        effort, self._rest = current(), OFTEN
        if effort is None or effort.most == inf:
            return
        with warnings.catch_warnings():  # dd warns of what another figure has meant in other versions
            warnings.simplefilter("ignore")
            figures = self.manager.statistics()
        self._rest = max(OFTEN, (figures["unique_size"] + figures["cache_size"]) // SCANNED)
        steps, self._seen = figures["cache_lookups"] - self._seen, figures["cache_lookups"]
        if effort is self._effort:
            effort.take(steps)
        else:
            self._effort = effort
            effort.restrict(self.manager)
