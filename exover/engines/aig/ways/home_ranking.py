"""Termination proof that reports and observations lead home: what is active and to come decreases in an order.

A request is *to come* while it waits, or while a required launch of it is due and it is neither active nor waits. What
is active and to come before a step and after it is compared as multisets (Dershowitz, Manna 1979): what goes may leave
any number of smaller things. To come is more than active. A request that no rule launches and that is to come is more
than all that rules launch. Beside that a request is larger than those that its reports may newly launch, as long as
this is acyclic. So reports of one slot after the other lead to where none is active, once the posters are observed to
read as in a home state, which as a rule disables the launch rules, if the levels are observed after each.

What a rule launches again and again, as while a latch holds that some request ends, is in no such order. It does not
count, and may be active in home states.
"""

from collections.abc import Iterable, Iterator
from contextlib import closing
from dataclasses import replace

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Answer, StopRequested, Unreachable
from exover.engines.aig.circuit.graph import FALSE, Graph, Literal, valuation
from exover.engines.aig.circuit.solver import Solver
from exover.engines.aig.circuit.symbolic_simulation import substituted
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.induction.implicants import Decide
from exover.engines.aig.simulation.reached import Cube
from exover.engines.aig.ways.home_states import HomeSpace, StepInputs

MOST = 4
"""If at most so many cases are left, model checkers are asked whether they are reachable."""


def home_space(
    encoding: Encoding,
    graph: Graph,
    readings: Iterable[frozenset[int] | None],
    decide: Decide,
    stop: StopRequested,
) -> HomeSpace | None:
    """Return home states to which reports and observations lead from every reachable state; None if none are found.

    `graph`: a copy of the graph of the encoding, which grows. `readings`: states whose readings home states may have;
    the first is taken that leaves no case open, or else the one that leaves the fewest.
    """
    launches = _Launches(encoding, graph)
    best: _Ranking | None = None
    for each in readings:
        ranking = _Ranking(HomeSpace(encoding, each), launches)
        if best is None or ranking.cost < best.cost:
            best = ranking
        if not best.left:
            break
    return None if best is None else best.proved(decide, stop)


class _Launches:
    """Where a step makes a request active, or to come, that was not to come before.

    `required`: the requests that rules launch.
    """

    def __init__(self, encoding: Encoding, graph: Graph) -> None:
        layout = encoding.latches
        self.encoding, self.graph = encoding, graph
        self.required = sorted({launch.request for launch in layout.model.launches})
        self._comes, self._goes = dict[str, Literal](), dict[str, Literal]()
        for name, place in layout.places.items():
            (taken,) = layout.literals[place.taken]
            owed, owes = encoding.moments.owed.get(name, (FALSE, FALSE))
            before, after = graph.any((taken, owed)), graph.any((encoding.following[taken], owes))
            self._comes[name] = graph.conjunction(after, before ^ 1)
            self._goes[name] = graph.conjunction(before, after ^ 1)
        self._larger_goes = graph.any(literal for name, literal in self._goes.items() if name not in self.required)
        self._slots: dict[str, list[str]] = {name: [] for name in layout.places}
        for (name, _), slot in layout.slots.items():
            self._slots[name].append(slot.active)
        self._found: dict[tuple[str, str | None], Literal] = {}

    def of(self, request: str, reported: str | None) -> Literal:
        """Return where a request is newly active or to come, and nothing larger has gone but perhaps what was reported.

        `reported`: the variable that says whether the slot is active whose report the step is. If it is active
        afterwards, it became so.
        """
        asked = request, reported if reported in self._slots[request] else None  # another's slot makes no difference
        if asked not in self._found:
            self._found[asked] = self._of(*asked)
        return self._found[asked]

    def _of(self, request: str, reported: str | None) -> Literal:
        graph, fresh = self.graph, []
        for slot in self._slots[request]:
            (active,) = self.encoding.latches.literals[slot]
            after = self.encoding.following[active]
            fresh.append(after if slot == reported else graph.conjunction(after, active ^ 1))
        active = graph.conjunction(graph.any(fresh), self._goes[request] ^ 1)
        larger = self._larger_goes if request in self.required else FALSE
        return graph.conjunction(graph.any((active, self._comes[request])), larger ^ 1)

    def wrong(self, reported: str | None) -> Literal:
        """Return where the inputs are no step, or a request that no rule launches is newly active or to come."""
        others = [self.of(name, reported) for name in self._comes if name not in self.required]
        return self.graph.any((self.encoding.legal ^ 1, *others))


@dataclass(frozen=True, slots=True)
class _Case:
    """Events, any of which leads on from all states of a cube if what it launches is smaller than what it reports.

    `launched`: by event what it may newly launch; None if it may be no step, or launch what no rule does. `request`,
    `reported`: whose slot they report, and the variable that says whether it is active; none if they are observations.
    `once`: it is done but once, before the others, whatever it launches.
    """

    state: Cube
    events: tuple[StepInputs, ...]
    launched: tuple[frozenset[str] | None, ...]
    request: str | None = None
    reported: str | None = None
    once: bool = False

    def event(self, smaller: set[str]) -> StepInputs | None:
        """Return an event that launches nothing but smaller requests."""
        options = zip(self.events, self.launched, strict=True)
        return next((event for event, names in options if names is not None and names <= smaller), None)

    def fewest(self, smaller: set[str]) -> frozenset[str]:
        """Return the requests launched that are not smaller, by the event that launches the fewest of them."""
        return min((names - smaller for names in self.launched if names is not None), key=len, default=frozenset())


class _Ranking:
    """What reports and observations launch on the way to one kind of home states, and an order of the requests."""

    def __init__(self, home: HomeSpace, launches: _Launches) -> None:
        self._home, self._launches = home, launches
        self._graph = launches.graph
        with closing(Solver(self._graph.within_step())) as self._solver:
            self._cases = list(self._all_cases())
        self._order()

    # ---- what events launch ----

    def _all_cases(self) -> Iterator[_Case]:
        home = self._home
        state: Cube = (home.encoding.moments.domain,)
        for event in home.posters.values():
            yield replace(self._case(state, (event,)), once=True)
        state += tuple(literal for name in home.posters for literal in home.like(name))
        levels = dict(home.levels)
        while levels:
            cases = {name: self._case(state, (event,)) for name, event in levels.items()}
            name = min(cases, key=lambda each: (cases[each].event(set()) is None, len(cases[each].fewest(set()))))
            yield cases[name]
            del levels[name]
            state += tuple(home.like(name))
        for slot in home.slots():
            active = home.encoding.latches.literals[slot.active]
            yield self._case((*active, *state), slot.events, slot.request, slot.active)

    def _case(
        self, state: Cube, events: tuple[StepInputs, ...], request: str | None = None, reported: str | None = None
    ) -> _Case:
        wrong = self._launches.wrong(reported)
        where = {name: self._launches.of(name, reported) for name in self._launches.required}
        some = self._graph.any(where.values())
        self._solver.grow(self._graph.within_step())

        def launched(event: StepInputs) -> frozenset[str] | None:
            if self._may(state, event, wrong):
                return None
            if not self._may(state, event, some):
                return frozenset()
            return frozenset(name for name, literal in where.items() if self._may(state, event, literal))

        return _Case(state, events, tuple(map(launched, events)), request, reported)

    def _may(self, state: Cube, event: StepInputs, literal: Literal) -> bool:
        """Return whether an event makes a literal true in some state of a cube."""
        inputs = valuation(self._home.encoding.graph.inputs, event)
        return self._solver.possible((*state, *inputs, literal))

    # ---- the order ----

    def _order(self) -> None:
        """Order the requests; one after the other is made free, until none is in the way of an order."""
        self.free = set[str]()
        self._sort()
        while (request := self._in_the_way()) is not None:
            self.free.add(request)
            self._sort()

    def _sort(self) -> None:
        """Put requests into the order while each slot of one has a report that launches only smaller requests."""
        self._smaller, self._reports = set(self.free), tuple[StepInputs, ...]()
        self.left = [case for case in self._cases if case.request not in self.free]
        grown = True
        while grown:
            grown = False
            for request in dict.fromkeys(case.request for case in self.left if case.request is not None):
                events = [case.event(self._smaller) for case in self._cases if case.request == request]
                if all(event is not None for event in events):
                    self._smaller.add(request)
                    self._reports = (*(event for event in events if event is not None), *self._reports)
                    self.left = [case for case in self.left if case.request != request]
                    grown = True
        self.left = [case for case in self.left if case.event(self._allowed(case)) is None]

    def _allowed(self, case: _Case) -> set[str]:
        """Return what the events of a case may launch."""
        if case.once:
            return set(self._launches.required)
        return self.free if case.request is None else self._smaller

    def _in_the_way(self) -> str | None:
        """Return a request that a case left launches, by its own report if there is one; None if there is none."""
        wanted = [(case, case.fewest(self._allowed(case))) for case in self.left]
        own = (case.request for case, names in wanted if names == {case.request})
        any_ = (min(names) for _, names in wanted if names)
        return next(own, None) or next(any_, None)

    @property
    def cost(self) -> tuple[int, int]:
        """How many cases are left, and how many requests may be active in home states."""
        return len(self.left), len(self.free)

    # ---- reachable states ----

    def proved(self, decide: Decide, stop: StopRequested) -> HomeSpace | None:
        """Return the home states; None if a case is left after it was asked which are reachable."""
        if any(self.cost):
            self._ask(decide, stop)
            self._order()
        if self.left:
            return None
        freed = tuple(slot.events[0] for slot in self._home.slots() if slot.request in self.free)
        return replace(self._home, free=frozenset(self.free), reports=(*self._reports, *freed))

    def _ask(self, decide: Decide, stop: StopRequested) -> None:
        """Ask which of the cases that are left without free requests are unreachable, and close these."""
        self.free = set()
        self._sort()
        asked = self.left
        if len(asked) > MOST:
            return
        answers: dict[int, Answer] = {}
        following = [self._home.encoding.following[2 * node] for node, _ in self._graph.latches]
        bad = [self._missed(case) for case in asked]
        decide(self._graph.circuit(following, bad), answers.__setitem__, stop)
        for index, case in enumerate(asked):
            if isinstance(answers.get(index), Unreachable):
                allowed = frozenset(self._allowed(case))
                known = replace(case, events=(*case.events, case.events[0]), launched=(*case.launched, allowed))
                self._cases[self._cases.index(case)] = known

    def _missed(self, case: _Case) -> Literal:
        """Return the states of a case in which each event is no step or launches a request that is not smaller."""
        graph, launches, allowed = self._graph, self._launches, self._allowed(case)
        larger = [launches.of(name, case.reported) for name in launches.required if name not in allowed]
        wanted = graph.any((launches.wrong(case.reported), *larger)) ^ 1
        leaves = {x >> 1: 1 - (x & 1) for x in case.state if graph.fanins.is_leaf(x >> 1)}
        constants = ({node: int(node in event) for node in self._home.encoding.graph.inputs} for event in case.events)
        good = [substituted(graph, [wanted], each | leaves)[0] for each in constants]
        return graph.all((*case.state, graph.any(good) ^ 1))
