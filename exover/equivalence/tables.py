"""The comparison of tables and rules for the checks; each part is computed when it is first needed."""

from collections.abc import Iterator, Sequence
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.analysis import Analysis
from exover.equivalence.path_equivalence import PathComparison, UndecidedPaths
from exover.equivalence.path_feasibility import PathFeasibility
from exover.equivalence.record_equivalence import different_records
from exover.equivalence.state_equivalence import StateComparison
from exover.model.model import Rule


@dataclass(frozen=True)
class TableComparison:
    """The decoded tables of one loop, compared with the rules: path by path, else on sets of states."""

    analysis: Analysis

    @cached_property
    def by_paths(self) -> PathComparison:
        """The comparison path by path; it needs no closed loop."""
        return PathComparison(self.analysis.compiled, PathFeasibility(self.analysis.compiled))

    @cached_property
    def by_states(self) -> StateComparison:
        """The comparison on sets of states."""
        return StateComparison(self.analysis.sets)

    @cached_property
    def _different_steps(self) -> tuple[str, ...]:
        """What every step needs and the tables have otherwise than the rules: counters, rules, launches, latches."""
        return tuple(self.by_states.differences())

    def prevents(self, rules: Sequence[Rule]) -> bool:
        """Return whether rules can be seen never to be broken: they are false at first, and none but a launch could
        make them true, which the decisions of the tables prevent, being those of the rules in every state.
        """
        questions = self.by_paths.questions
        if any(map(questions.restored, rules)):
            return False
        asking = [name for rule in rules for name in questions.asking(rule)]
        try:
            return all(map(self.by_paths.decides, asking))
        except UndecidedPaths:
            return all(self.by_states.decides(self.analysis.loop.model.request[name]) for name in asking)

    def different(self, kind: str, name: str) -> Iterator[str]:
        """Yield in what the tables do otherwise than the rules say, for a kind of event and in every step."""
        try:
            yield from tuple(self.by_paths.different(kind, name))
            return
        except UndecidedPaths:
            pass
        yield from different_records(self.by_states.records, kind, name)
        if kind == "ask" and not self.by_states.decides(self.analysis.loop.model.request[name]):
            yield f"the decision on `{name}`"
        yield from self._different_steps
