"""The decision-diagram engine, as the checks use it; each part is computed when it is first needed."""

from collections.abc import Callable, Iterable
from dataclasses import field
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.backward_reachability import Allowed, BackwardReachability, Ring
from exover.engines.bdd.concretize import Ends, RunConcretizer, follow
from exover.engines.bdd.home_states import HomeStates
from exover.engines.bdd.loopsets import LoopSets
from exover.engines.bdd.manager import Set
from exover.engines.bdd.queries import Queries
from exover.engines.bdd.space import Space
from exover.engines.bdd.steps import Stepper
from exover.engines.bdd.temporal import TemporalEngine
from exover.engines.bdd.wait_for import WaitForAnalysis
from exover.loop.claim import Progress
from exover.loop.finite.argument_classes import all_arguments
from exover.loop.finite.builder import ClosedLoop, LoopEvent
from exover.loop.finite.predicates import StatePredicates
from exover.loop.finite.tested_bounds import TestedBounds, TooLarge
from exover.loop.tracked_predicates import tracked_predicates
from exover.model.event import Abort, AbortWaiting, Ask
from exover.model.model import Rule
from exover.model.property import NO_PROPERTIES, Label, Properties
from exover.model.semantics import Reference
from exover.model.trace import Trace
from exover.ocrd.compile import DecodedTables


@dataclass
class Analysis:
    """One closed loop, and the questions that checks ask about it."""

    compiled: DecodedTables
    reference: Reference
    progress: Progress
    properties: Properties = NO_PROPERTIES
    _loop: ClosedLoop | TooLarge | None = None
    _rings: dict[Set, list[Ring] | None] = field(default_factory=dict)

    @property
    def loop(self) -> ClosedLoop:
        """The closed loop of the decoded tables; raises `TooLarge`, each time, if it is too large for diagrams."""
        if self._loop is None:
            try:
                self._loop = ClosedLoop(
                    self.compiled.model, self.compiled.tables, self.compiled.entries, self.properties
                )
            except TooLarge as reason:
                self._loop = reason
        if isinstance(self._loop, TooLarge):
            raise self._loop
        return self._loop

    @property
    def state_bits(self) -> int | None:
        """The number of bits of the loop's state; None if the loop is too large for diagrams."""
        try:
            return self.loop.bit_count
        except TooLarge:
            return None

    @property
    def most_samples(self) -> int | None:
        """The greatest number of argument samples of a request, found without a loop; None as for `state_bits`."""
        model, tables = self.compiled.model, self.compiled.tables
        try:
            found = all_arguments(model, tables, TestedBounds(tables), tracked_predicates(model, self.properties))
        except TooLarge:
            return None
        return max((len(each.samples) for each in found), default=0)

    @cached_property
    def sets(self) -> LoopSets:
        """The space, steps and conditions, all of one loop."""
        return LoopSets(self.loop, self.properties)

    @property
    def stepper(self) -> Stepper:
        """Images and preimages of the steps that the assumptions allow."""
        return self.sets.stepper

    @property
    def space(self) -> Space:
        """Sets of states."""
        return self.sets.space

    @property
    def meaning(self) -> StatePredicates[Set]:
        """Conditions of the model as sets."""
        return self.sets.meaning

    @property
    def coupling(self) -> int:
        """How much components wake each other: the number of pairs (waking, woken) times (1 + the number of components
        that may be unstable before anything is written in a step).
        """
        return self.stepper.waking.pairs * (1 + len(self.stepper.waking.always))

    @cached_property
    def _search(self) -> Queries:
        return Queries(self.stepper, self.progress)

    @property
    def reached(self) -> Set:
        """The reachable states, by forward search; backward reachability does not need them."""
        return self._search.reached

    @cached_property
    def _home(self) -> HomeStates:
        """The home states: nothing is active."""
        return HomeStates(self.stepper)

    @cached_property
    def _lone(self) -> HomeStates:
        """The lone home states: nothing is active and nothing waits."""
        return HomeStates(self.stepper, lone=True)

    @cached_property
    def _waits(self) -> WaitForAnalysis:
        """Which waits can end."""
        return WaitForAnalysis(self.stepper, self._home)

    def ends_waiting(self, request: str) -> bool:
        """Return whether wait-for analysis proves that observations and reports can end every wait of the request."""
        return self._waits.end(self.loop.request_number[request])

    def _walker(self) -> RunConcretizer:
        return RunConcretizer(self.stepper, self.reference)

    @cached_property
    def temporal(self) -> TemporalEngine:
        """Questions about runs."""
        universe = self.stepper.universe
        way = self._search.way
        return TemporalEngine(self.stepper, self.meaning, self.reference, universe, way, self.properties.fair)

    def passes(self, mark: Label) -> bool:
        """Return whether some run passes a mark."""
        return self._either(lambda backwards: backwards.rings(_past(backwards, mark))) is not None

    def _either(self, rings: Callable[[BackwardReachability], list[Ring] | None]) -> list[Ring] | None:
        """Return rings of a run, by quiescent steps if possible, perhaps not a shortest one; None if there is none."""
        return self._search.shown(rings) or self._search.asked(rings)

    def reaches(self, states: Set) -> bool:
        """Return whether some of these states can be reached."""
        return self._either(lambda backwards: backwards.rings(Ring(states, ()))) is not None

    def reaches_into(self, states: Set) -> bool:
        """Return whether some step ends in these states."""
        return self._either(lambda backwards: self._rings_into(backwards, states)) is not None

    def run_into(self, states: Set) -> Trace | None:
        """Return a shortest run of one step or more that ends in these states; None if none does."""
        rings = self._into(states)
        if rings is None:
            return None
        return follow(self._walker(), rings, states)

    def _into(self, states: Set) -> list[Ring] | None:
        """Return the rings of the runs of one step or more into these states; asked once for the same states."""
        if states not in self._rings:
            self._rings[states] = self._search.asked(lambda backwards: self._rings_into(backwards, states))
        return self._rings[states]

    def _rings_into(self, backwards: BackwardReachability, states: Set) -> list[Ring] | None:
        if self.space.initial & states == self.space.none:
            return backwards.rings(Ring(states, ()))
        ways = backwards.before(states, range(len(self.loop.events)))
        return backwards.rings(Ring(backwards.union(ways), ways))

    def run_past(self, mark: Label, ends: Ends) -> Trace | None:
        """Return a run whose last step passes a mark, which its actions show; None if none does."""
        rings = self._either(lambda backwards: backwards.rings(_past(backwards, mark)))
        return None if rings is None else follow(self._walker(), rings, self.space.all, ends)

    def excluded(self, states: Set) -> bool:
        """Return True only if no step ends in these states: in each of them some component is unstable."""
        return self.stepper.excluded(states)

    def always_possible(self, since: Set, goal: Set, mark: Label, allowed: Allowed) -> Trace | None:
        """Return a shortest run to a state of `since` from which no allowed events lead into `goal` or past `mark`.

        None iff there is none: AG (since -> EF).
        """

        def unable(backwards: BackwardReachability, covered: Callable[[Set], bool]) -> Set:
            """Return a superset of the states of `since` without such a path."""
            events = self.loop.events
            passing = [number for number in backwards.passing(mark) if allowed(events[number])]
            first = goal | backwards.union(backwards.before(self.space.none, passing, mark))
            return since & ~backwards.possible(first, allowed, lambda found: covered(since & ~found))

        def stuck(backwards: BackwardReachability) -> list[Ring] | None:
            missing = unable(backwards, self._covered)
            return None if self._covered(missing) else backwards.rings(Ring(missing & backwards.within, ()))

        def shown(backwards: BackwardReachability) -> bool | None:
            lone = backwards is self._search.lone
            if lone and not self._waits.all_end:
                return None
            home = self._lone if lone else self._home
            return home.lacks(unable(backwards, home.lacks)) or None

        if self._search.shown(shown):
            return None
        rings = self._search.asked(stuck)
        return None if rings is None else follow(self._walker(), rings, self.space.all)

    def _covered(self, missing: Set) -> bool:
        """Return True only if no reachable state without a path is left: no state between steps is `missing`, or no
        home state is, in which case reports and observations lead from every state to one with a path.
        """
        return self._home.lacks(missing) or self.stepper.excluded(missing)

    def broken(self, rules: Iterable[Rule]) -> Set:
        """Return the states in which `violation` is raised for one of the rules: F holds with stopping slots idle."""
        return self.space.disjunction(self.meaning.rule(rule, once_stopped=True) for rule in rules)


def _past(backwards: BackwardReachability, mark: Label) -> Ring:
    """Return the states from which a step may pass a mark, with the steps that do."""
    ways = backwards.before(backwards.stepper.space.none, backwards.passing(mark), mark)
    return Ring(backwards.union(ways), ways)


def is_abort(event: LoopEvent) -> bool:
    """Return whether an event is an abort, of a slot or of a waiting request."""
    return isinstance(event.event, Abort | AbortWaiting)


def asks(event: LoopEvent, request: str) -> bool:
    """Return whether an event is an ask of this request."""
    return isinstance(event.event, Ask) and event.event.request == request
