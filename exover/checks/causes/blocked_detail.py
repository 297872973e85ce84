"""Details of findings whose run ends where a request waits or is refused: the rules that hold it up."""

from collections.abc import Iterable, Sequence
from itertools import islice

from exover.checks.causes.blocking import Blocked, Forbidden, Link, Unended
from exover.checks.causes.broken_finding import SHADOWS, BrokenFinding, forbid_text, never_launched
from exover.checks.causes.cause_wording import asked_text, reason_text
from exover.checks.causes.near_events import least_arguments
from exover.model.expression import Cond
from exover.model.model import Launch
from exover.model.state import State

LINKS = 4
"""The greatest number of links of a chain of causes in a message."""
MENDED, LATER = "once all else is mended, ", "in a later state "
"""Words for a cause that is found only in a state which random runs reach from the end of the run."""

BESIDES = "among others, "
"""Words for a cause beside others that decide first and can be mended."""


def of_obligation(broken: BrokenFinding) -> str:
    """Return the message of the finding, with the rule that refuses the required launch at the end of its run."""
    (launch,) = (each for each in broken.model.launches if each.name == broken.finding.subject)
    return "; ".join([broken.finding.message, *refused(broken, launch)])


def refused(broken: BrokenFinding, launch: Launch) -> list[str]:
    """Return the rule for which the last step of a run refused a required launch, as at most one part of a sentence."""
    state = broken.end
    found = broken.obstacles.refusal(state, launch) if state else None
    return [_link(broken, state, found)] if state and found else []


def of_starvation(broken: BrokenFinding) -> str:
    """Return the message of the finding, with what the request waits by at the end of its run."""
    state, name = broken.end, broken.finding.subject
    told = held_up(broken, state, name) if state is not None and state.places[name] else []
    return "; ".join([broken.finding.message, *told])


def held_up(broken: BrokenFinding, state: State, name: str) -> list[str]:
    """Return, as parts of a sentence, what a request waits by in a state, and the launch rules that launch again the
    request that holds it up; of a lasso also by what else it waits in the loop.
    """
    found = broken.obstacles.blocked(state, name)
    if found is None:
        return []
    told: list[Blocked | Launch] = [found, *broken.obstacles.requiring(state, found)]
    return [_link(broken, state, each) for each in told] + _elsewhere(broken, found)


def _elsewhere(broken: BrokenFinding, last: Blocked) -> list[str]:
    """Return, as at most one part of a sentence, the rules by which a request waits in the loop but not at its end."""
    others: dict[str, str] = {}
    for state in broken.loop:
        found = broken.obstacles.blocked(state, last.request.name)
        if found is not None and found.waits and found.reason.rule not in (last.reason.rule, *others):
            others[found.reason.rule] = reason_text(broken.model, state, found)
    told = list(others.values())
    more = [f"{len(told) - SHADOWS} more"] if len(told) > SHADOWS else []
    return [f"earlier in the loop by {'; by '.join([*told[:SHADOWS], *more])}"] if told else []


def of_deadlock(broken: BrokenFinding) -> str:
    """Return the message of the finding, with the chain of causes for which the request waits at the end of its run."""
    state, name = broken.end, broken.finding.subject
    first = None if state is None else broken.obstacles.blocked(state, name)
    if state is None or first is None:
        return broken.finding.message
    return f"{broken.finding.message}; {_chain(broken, state, name)}"


def of_lockout(broken: BrokenFinding) -> str:
    """Return the message of the finding, with what the request waits by at the end of its run or, if it does not wait,
    what keeps an ask of it from a launch whatever follows.
    """
    state, request = broken.end, broken.model.request[broken.finding.subject]
    if state is None or state.places[request.name]:
        return of_deadlock(broken)
    never = never_launched(broken, [request.name])
    stuck = kept_from_launch(broken, state, request.name)
    if not stuck:
        args = next(iter(broken.obstacles.launchable(state, request.name)), least_arguments(request))
        stuck = [f"{asked_text(request, args)} would be launched, but the assumptions leave no such step"]
    return "; ".join([broken.finding.message, *never, *stuck])


def kept_from_launch(broken: BrokenFinding, state: State, name: str) -> list[str]:
    """Return the causes that keep a request from a launch from a state on, as at most one part of a sentence."""
    _, last = broken.obstacles.stays(state, name)
    return [] if last is None else [_chain(broken, state, name)]


def kept_from_truth(broken: BrokenFinding, state: State, conditions: Sequence[Cond]) -> list[str]:
    """Return, as parts of a sentence, the causes that keep requests from a launch from a state on which would
    make one of the conditions true.
    """
    return _told(broken, broken.obstacles.missing(state, conditions))


def _chain(broken: BrokenFinding, state: State, name: str) -> str:
    """Return up to `LINKS` causes: what keeps a request from a launch, then what keeps its mending from happening."""
    return "; ".join(_told(broken, broken.obstacles.chain(state, name)))


def _told(broken: BrokenFinding, links: Iterable[tuple[State, Link]]) -> list[str]:
    """Return up to `LINKS` causes as parts of a sentence, and whether there are more."""
    first = list(islice(links, LINKS + 1))
    return [_link(broken, *each) for each in first[:LINKS]] + ["and so on"] * (len(first) > LINKS)


def _link(broken: BrokenFinding, state: State, link: Link) -> str:
    if isinstance(link, Launch):
        return f"launch rule `{link.name}` requires `{link.request}` there"
    if isinstance(link, Unended):
        return f"`{link.request.name}` does not end there, for {forbid_text([link.assumption])} each report of it"
    asked, so = asked_text(link.request, link.args), _so(broken, state, link)
    if isinstance(link, Forbidden):
        return f"{so}{asked} would be launched, but {forbid_text([link.assumption])} the step"
    by = reason_text(broken.model, state, link)
    if so != LATER and broken.end is not None and by != reason_text(broken.model, broken.end, link):
        by = reason_text(broken.model, state, link, LATER.strip())
    by = f"{'first ' * (link.rank == 'first')}by {by}"
    if link.waits and broken.end is not None and broken.end.places[link.request.name]:
        return f"{so}`{link.request.name}` waits {by}"
    return f"{so}{asked} is {'refused' if link.refused else 'kept waiting'} {by}"


def _so(broken: BrokenFinding, state: State, link: Blocked | Forbidden) -> str:
    """Return the words that introduce a cause found in `state`: none if it decides at the end of the run, too."""
    if isinstance(link, Blocked) and link.rank == "besides":
        return BESIDES
    if broken.end is None or state is broken.end or broken.obstacles.is_so(link, broken.end):
        return ""
    return MENDED if isinstance(link, Blocked) and broken.obstacles.is_alone(link, state) else LATER
