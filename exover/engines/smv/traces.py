"""Runs that NuSMV and nuXmv print, read as runs of the loop and followed on the reference interpreter."""

from itertools import pairwise
from xml.etree import ElementTree

from exover.dataclass import dataclass
from exover.engines.smv.names import SmvNames
from exover.loop.finite.abstraction import abstract, concretes
from exover.model.event import Event, Invalid
from exover.model.semantics import Reference
from exover.model.trace import Trace, run

LONGEST = 1000
"""The greatest number of times that the loop of a lasso is followed until a concrete state recurs."""


class InvalidTrace(Exception):
    """The printed run is no run of the reference interpreter."""


@dataclass(frozen=True, slots=True)
class ShownRun:
    """A printed run: for each step the event and the known values of the state after it; where its loop begins.

    An event of None is any: the program leaves out what its answer does not depend on.
    """

    steps: tuple[tuple[int | None, dict[int, int]], ...]
    loop_start: int | None


def shown(names: SmvNames, printed: str) -> ShownRun | None:
    """Return the run in the output of the program; None if there is none.

    Steps from the first one on that the assumptions forbid are left out.
    """
    start, end = printed.find("<counter-example"), printed.find("</counter-example>")
    if start < 0 or end < 0:
        return None
    tree = ElementTree.fromstring(printed[start:][: end - start + len("</counter-example>")])
    nodes = tree.findall("node")
    event_of = {name: number for number, name in enumerate(names.events)}
    variable = {names.state(n): n for n in range(len(names.loop.variables))}
    steps: list[tuple[int | None, dict[int, int]]] = []
    for before, after in pairwise(nodes):
        inputs, states = _values(before, "input"), _values(after, "state")
        if states.get("environment.live") == "FALSE":
            return ShownRun(tuple(steps), None) if steps else None
        known = {
            variable[name]: names.literals[variable[name]].index(value)
            for name, value in states.items()
            if name in variable
        }
        steps.append((event_of.get(inputs.get("environment.event", "")), known))
    loops = [int(each) for each in (tree.findtext("loops") or "").split(",") if each.strip()]
    begins = min(loops) - 1 if loops else None
    return ShownRun(tuple(steps), begins if begins is not None and begins < len(steps) else None)


def _values(node: ElementTree.Element, kind: str) -> dict[str, str]:
    return {str(each.get("variable")): each.text or "" for each in node.findall(f"{kind}/value")}


def concrete(names: SmvNames, reference: Reference, what: ShownRun) -> Trace:
    """Return a run of the reference interpreter that follows the printed one; raises `InvalidTrace` if none does."""
    follower = _Follower(names, reference)
    for step in what.steps:
        follower.follow(step)
    if what.loop_start is None:
        return run(reference, tuple(follower.events))
    heads = {follower.keys[what.loop_start]: what.loop_start, follower.keys[-1]: len(follower.events)}
    if len(heads) == 1:
        return run(reference, tuple(follower.events), what.loop_start)
    for _ in range(LONGEST):
        for step in what.steps[what.loop_start :]:
            follower.follow(step)
        if follower.keys[-1] in heads:
            return run(reference, tuple(follower.events), heads[follower.keys[-1]])
        heads[follower.keys[-1]] = len(follower.events)
    raise InvalidTrace("what is repeated never comes to the same state again")


class _Follower:
    def __init__(self, names: SmvNames, reference: Reference) -> None:
        self._loop, self._reference = names.loop, reference
        self._state = reference.start()
        self.events: list[Event] = []
        self.keys = [self._state.key()]

    def follow(self, step: tuple[int | None, dict[int, int]]) -> None:
        """Take a concrete step to a state with the printed values; raises `InvalidTrace` if there is none."""
        number, wanted = step
        kinds = self._loop.events if number is None else self._loop.events[number : number + 1]
        for event in (each for kind in kinds for each in concretes(self._loop, kind, self._state)):
            after, actions = self._reference.step(self._state, event)
            if any(isinstance(action, Invalid) for action in actions):
                continue
            values = abstract(self._loop, after)
            if all(self._happened(var) or values[var] == value for var, value in wanted.items()):
                self.events.append(event)
                self._state = after
                self.keys.append(after.key())
                return
        raise InvalidTrace(f"step {len(self.events) + 1} of what NuSMV shows is none of the reference")

    def _happened(self, var: int) -> bool:
        return self._loop.variables[var].key[0] == "happened"
