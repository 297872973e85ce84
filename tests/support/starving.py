"""Whether a request can wait for ever, by explicit search."""

from dataclasses import dataclass, field

from exover.model.event import AbortWaiting, Args, Event, Launched, Rejected, Report
from exover.model.expression import Status
from exover.model.model import Launch
from exover.model.property import (
    Atom,
    SomeAlways,
)
from exover.model.semantics import Reference, Step
from exover.model.state import State
from tests.support import explicit_ctl
from tests.support.moments import Moment, Moments
from tests.support.oracle import Graph


@dataclass(frozen=True)
class Leaving(Reference):
    """The reference interpreter, which notes at which requests what stood in the waiting place does so no longer."""

    gone: set[str] = field(default_factory=set)

    def left(self, state: State, event: Event) -> set[str]:
        """Return these requests for one step."""
        self.gone.clear()
        self.step(state, event)
        return self.gone | ({event.request} if isinstance(event, AbortWaiting) else set())

    def _ask(self, step: Step, name: str, args: Args, required: Launch | None = None) -> Step:
        after = super()._ask(step, name, args, required)
        for action in after.actions[len(step.actions) :]:
            refused = isinstance(action, Rejected) and action.request == name and action.rule != "superseded"
            if isinstance(action, Launched | Rejected) and not refused:
                self.gone.add(action.request)
        return after

    def _settle(self, step: Step) -> Step:
        after = super()._settle(step)
        self.gone.update(a.request for a in after.actions[len(step.actions) :] if isinstance(a, Launched | Rejected))
        return after


def starved(graph: Graph, request: str) -> bool:
    """Return whether on some fair run one and the same request waits for ever, by explicit search."""
    leaving = Leaving(graph.model)
    number: dict[Moment, int] = {}
    found = Moments(graph.model, graph.states, fair=True)

    def moment(state: int, reported: frozenset[tuple[str, int]]) -> int:
        made = Moment(state, frozenset(), reported)
        if made not in number:
            number[made] = len(number)
            found.moments.append(made)
            found.after.append([])
        return number[made]

    out: dict[int, list[tuple[int, frozenset[tuple[str, int]]]]] = {}
    for edge in graph.edges:
        stays = graph.states[edge.source].places[request] and graph.states[edge.target].places[request]
        if stays and request not in leaving.left(graph.states[edge.source], edge.event):
            event = edge.event
            reported = frozenset({(event.request, event.slot)}) if isinstance(event, Report) else frozenset()
            out.setdefault(edge.source, []).append((edge.target, reported))
    for state in range(len(graph.states)):
        moment(state, frozenset())
    for source in found.moments:
        found.after[number[source]] = [moment(*step) for step in out.get(source.state, [])]
    waiting = Atom(Status("waiting", request))
    return bool(explicit_ctl.satisfying(found, SomeAlways(waiting)))
