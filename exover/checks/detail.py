"""What the run of a finding, the model and the properties add to what its check says of every subject."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import islice, takewhile

from exover.checks.blocking import Blocked, Forbidden, Obstacles
from exover.checks.cause_wording import arguments_read, asked_text, beyond_capacity, read_there, reason_text
from exover.checks.finding import Finding
from exover.checks.kleene import every, negated, some
from exover.checks.near_events import least_arguments
from exover.checks.property import BROKEN, VIOLATED, named
from exover.checks.property_detail import conditions, false_first, how_broken, owed, requests_named
from exover.checks.remedy import advice
from exover.checks.rule_use import ADVICE, CAREFUL, NEVER, SILENT, UNCALLED, standing
from exover.checks.rule_use import VIOLATED as UNNAMED
from exover.checks.shadowing import RULES, Shadowing, Shadows, WithoutRules, shadows
from exover.dataclass import dataclass
from exover.loop.claim import CONTRADICTORY, Verdict
from exover.model.expression import And, Cond, Not, Or, Past, Status
from exover.model.model import Launch, Model, Parameter
from exover.model.property import Assumption, Formula, Properties
from exover.model.ranges import FixedComparison, decided
from exover.model.reads import reads
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import end_of, visited

LINKS = 4
"""So many causes of causes are told."""
SHADOWS = 3
"""So many rules are named that decide before another."""
SEARCHED = ("rule-use", "reachability", "redundancy")
"""Checks whose causes are looked for in steps near the runs of other findings."""
MENDED, LATER = "once all else is mended, ", "in a later state "
"""How it is told that something is so only in a state that random runs come to from the end of the run."""
RUNLESS = ("consistency", "tables")
"""Checks that are not about runs, whatever is assumed."""


def detailed(
    model: Model, properties: Properties, findings: Sequence[Finding], is_late: Callable[[], bool] = lambda: False
) -> Iterator[Finding]:
    """Yield the findings, those that are violated with all that is known of their causes in their messages.

    Nothing is looked for by runs of the reference interpreter once `is_late`.
    """
    reference = Reference(model)
    without = WithoutRules(model)
    obstacles = Obstacles(reference, without, properties.assumptions, is_late)
    verdicts = {(each.check, each.subject): each.verdict for each in findings}
    broken = [each for each in findings if each.verdict == "violated"]
    dead = {each.subject for each in broken if each.check == "rule-use"}
    contradictory = any(CONTRADICTORY in each.message for each in broken)
    searched = [e for e in broken if e.check in SEARCHED and (e.check != "redundancy" or e.subject not in dead)][:RULES]
    unlaunched = frozenset(each.subject for each in broken if each.check == "reachability")
    looks = searched and not contradictory and not is_late()
    looking = shadows(reference, without, properties.assumptions, findings) if looks else None
    for finding in findings:
        add = DETAILS.get(finding.check)
        if finding.verdict != "violated" or CONTRADICTORY in finding.message:
            yield finding
        elif contradictory and finding.check not in RUNLESS and not (finding.trace and finding.trace.moments):
            yield replace(finding, message=f"{CONTRADICTORY}, mend that first; {finding.message}")
        elif add is None:
            yield finding
        else:
            near = looking if finding in searched and not is_late() else None
            told = add(_Broken(reference, properties, finding, obstacles, near, verdicts, unlaunched))
            yield replace(finding, message=told)


@dataclass(frozen=True)
class _Broken:
    """A finding that is violated, with what its message can be made of."""

    reference: Reference
    properties: Properties
    finding: Finding
    obstacles: Obstacles
    near: Shadows | None
    """Looks for what decides first in steps near runs, if it is to be looked for."""
    verdicts: Mapping[tuple[str, str], Verdict]
    """Of all findings, by check and subject."""
    unlaunched: frozenset[str]
    """Requests that no run launches, as far as that is found."""

    @property
    def model(self) -> Model:
        return self.reference.model

    @cached_property
    def end(self) -> State | None:
        """The state at the end of the run, if there is one."""
        trace = self.finding.trace
        return None if trace is None else end_of(self.reference, trace.events)

    @cached_property
    def loop(self) -> Sequence[State]:
        """The states after the moments that a lasso repeats; none of another run."""
        trace = self.finding.trace
        if trace is None or trace.loop_start is None:
            return ()
        return tuple(islice(visited(self.reference, trace.events), trace.loop_start + 1, None))


def out_of_range(model: Model, properties: Properties) -> Iterator[str]:
    """Yield, in words, which comparisons of properties and assumptions ranges decide, whatever happens."""
    stated = [(f"property `{each.name}`", each.formula, each.location) for each in properties.properties]
    stated += [("an assumption", each.formula, each.location) for each in properties.assumptions]
    for what, formula, where in stated:
        for each in _decided(model, formula):
            yield f"{where}: in {what}, {each}"


def _never_true(model: Model, formula: Formula) -> list[str]:
    """Return, in words, which comparisons of a formula are false whatever happens."""
    return [str(each) for each in _decided(model, formula) if not each.truth]


def _decided(model: Model, formula: Formula) -> Iterator[FixedComparison]:
    yield from dict.fromkeys(each for condition in conditions(formula) for each in decided(model, condition))


# ---- by check ----


def _completeness(broken: _Broken) -> str:
    state = broken.end
    if state is None:
        return broken.finding.message
    return f"{broken.finding.message}; {advice(broken.reference, state.once_stopped(), broken.finding.subject)}"


def _property(broken: _Broken) -> str:
    """Return what the form means, beside the text of the property, and what it reads in the last moment of a run."""
    finding = broken.finding
    prop = named(broken.properties, finding.subject)
    how, message = how_broken(prop, finding.trace), finding.message
    for said in (VIOLATED, BROKEN[prop.form]):
        message = message.replace(said, how, 1)
    parts = [f'"{prop.text}": {message}' if prop.text else message]
    if prop.form == "leads to":
        parts += owed(broken.reference, prop, finding.trace)
    if prop.form == "ltl":
        parts += false_first(broken.reference, prop.formula, finding.trace)
    state = broken.end
    if state is not None and finding.trace is not None and finding.trace.loop_start is not None:
        names = dict.fromkeys(name for names in requests_named(prop.formula) for name in names)
        parts += [told for name in names if state.places[name] for told in _held_up(broken, state, name)]
        parts += [told for each in broken.model.launches if each.request in names for told in _refused(broken, each)]
    elif state is not None:
        where = "at the end of the run" if prop.form == "ctl" else "there"
        read = (each for condition in conditions(prop.formula) for each in sorted(reads(condition)))
        parts += read_there(broken.model, state, read, where=where, asked=arguments_read(conditions(prop.formula)))
        if prop.form in ("always possible", "from possible"):
            parts += _never_true(broken.model, prop.formula) or _launch_missed(broken, state, prop.formula)
    else:
        parts += map(str, _decided(broken.model, prop.formula))
        parts += _never_launched(broken, (name for names in requests_named(prop.formula) for name in names))
    return "; ".join(parts)


def _launch_missed(broken: _Broken, state: State, formula: Formula) -> list[str]:
    """Return what keeps the one request from a launch that a formula wants to see launched, or active, if it is one."""
    launched, said = requests_named(formula)
    wanted = list(dict.fromkeys([*launched, *(name for name in said if not state.active([name]))]))
    return _never_launched(broken, wanted) + _stuck(broken, state, wanted[0]) if len(wanted) == 1 else []


def _rule_use(broken: _Broken) -> str:
    """Return why no answer names it, beside what engines add to what the check says."""
    return f"{_unnamed(broken)}{broken.finding.message.removeprefix(UNNAMED)}"


def _unnamed(broken: _Broken) -> str:
    """Return why a rule never acts, if ranges tell, or what decides first; or that it decides without a word."""
    model, name = broken.model, broken.finding.subject
    stands = standing(model, broken.verdicts, name)
    shadowing = broken.near.of(name) if broken.near else Shadowing()
    if stands == "silent":
        where = [f"where an answer would name it, {_decide(shadowing.rules)}"] if shadowing.rules else []
        return "; ".join([SILENT, *where, _taken_out(broken)])
    found = [each for condition, params in _conditions_of(model, name) for each in decided(model, condition, params)]
    never, one, advice = (NEVER, "it", ADVICE) if stands == "idle" else (UNNAMED, "one", CAREFUL)
    if shadowing.forbids is not None and not found:
        return f"{never}, since {_forbid(shadowing.forbids)} the steps in which {one} would"
    causes = list(map(str, dict.fromkeys(found)))
    causes += _never_launched(broken, _settled_by(broken, name))
    if shadowing.rules:
        causes.append(f"where {one} would, {_decide(shadowing.rules)}")
    if shadowing.unassumed and not causes:
        causes.append(f"without the assumptions, {_listed(shadowing.unassumed)} would decide in its place")
    if stands == "idle" and not causes:
        causes.append(UNCALLED)
    return "; ".join([f"{never}: {'; '.join(causes)}" if causes else never, advice])


def _taken_out(broken: _Broken) -> str:
    """Return what it changes to take out a rule that decides without a word."""
    match broken.verdicts.get(("redundancy", broken.finding.subject)):
        case "violated":
            return ADVICE
        case "holds":
            return "to take it out changes decisions"
        case _:
            return "to take it out may change decisions"


def _conditions_of(model: Model, name: str) -> Iterator[tuple[Cond, tuple[Parameter, ...]]]:
    """Yield the conditions of guards, rules and launch rules of a name, each with the parameters that it may read."""
    for request in model.requests:
        yield from ((guard.condition, request.params) for guard in request.guards if guard.name == name)
    for rule in (each for each in model.rules if each.name == name):
        yield rule.condition, model.request[rule.slot_of].params if rule.slot_of else ()
    yield from ((each.condition, ()) for each in model.launches if each.name == name)


def _settled_by(broken: _Broken, rule: str) -> Iterator[str]:
    """Yield requests that no run launches and that settle what the condition of a rule, guard or launch rule is."""
    for condition, _ in _conditions_of(broken.model, rule):
        if _is_settled(condition, broken.unlaunched):
            yield from (each.name for each in sorted(reads(condition)) if each.kind in ("active", "past"))


def _is_settled(condition: Cond, unlaunched: Collection[str]) -> bool:
    """Return whether a condition has one value only if some requests are never active and have no past."""

    def truth(part: Cond) -> bool | None:
        match part:
            case Status("active" | "running" | "stopping", request) | Past(request) if request in unlaunched:
                return False
            case Not(inner):
                return negated(truth(inner))
            case And(parts):
                return every(map(truth, parts))
            case Or(parts):
                return some(map(truth, parts))
            case _:
                return None

    return truth(condition) is not None


def _never_launched(broken: _Broken, names: Iterable[str]) -> list[str]:
    """Return of which requests it is known that no run launches them, as parts of a sentence."""
    found = (name for name in dict.fromkeys(names) if name in broken.unlaunched)
    return [f"no run launches `{name}`: see reachability" for name in found]


def _redundancy(broken: _Broken) -> str:
    """Return which rules decide in its place."""
    rules = broken.near.instead_of(broken.finding.subject) if broken.near else ()
    return "; ".join([broken.finding.message, *([f"in its place {_decide(rules)}"] if rules else [])])


def _reachability(broken: _Broken) -> str:
    """Return what keeps it from a launch."""
    shadowing = broken.near.before_launch(broken.finding.subject) if broken.near else Shadowing()
    request = broken.model.request[broken.finding.subject]
    found = [each for guard in request.guards for each in decided(broken.model, guard.condition, request.params)]
    parts = [broken.finding.message, *(str(each) for each in dict.fromkeys(found) if not each.truth)]
    parts += beyond_capacity(broken.model, request)
    if shadowing.rules:
        parts.append(f"it is kept from a launch by {_listed(shadowing.rules)}")
    if shadowing.alone:
        without = " or without ".join(f"`{each}`" for each in shadowing.alone[:SHADOWS])
        forbidden = "there" if shadowing.forbids is None else f"only in steps that {_forbid(shadowing.forbids)}"
        parts.append(f"without {without} it would be launched {forbidden}")
        settled = (name for rule in shadowing.alone[:SHADOWS] for name in _settled_by(broken, rule))
        parts += _never_launched(broken, (name for name in settled if name != request.name))
    elif shadowing.forbids is not None:
        parts.append(f"it would be launched only in steps that {_forbid(shadowing.forbids)}")
    return "; ".join(parts)


def _forbid(assumptions: Sequence[Assumption]) -> str:
    """Return that these assumptions forbid something; if there are none, that the assumptions do."""
    match assumptions:
        case []:
            return "the assumptions forbid"
        case [one]:
            return f"the assumption at {one.location} forbids"
        case _:
            places = " and at ".join(str(each.location) for each in assumptions)
            return f"the assumptions at {places} forbid"


def _decide(rules: Sequence[str]) -> str:
    """Return that these rules decide."""
    return f"{_listed(rules)} decide{'s' * (len(rules) == 1)}"


def _listed(rules: Sequence[str]) -> str:
    first, others = ", ".join(f"`{each}`" for each in rules[:SHADOWS]), len(rules) - SHADOWS
    return f"{first} and {others} more" if others > 0 else first


def _obligation(broken: _Broken) -> str:
    """Return what refuses the launch at the end of its run."""
    (launch,) = (each for each in broken.model.launches if each.name == broken.finding.subject)
    return "; ".join([broken.finding.message, *_refused(broken, launch)])


def _refused(broken: _Broken, launch: Launch) -> list[str]:
    """Return what the last step of a run refused a required launch for, if it did."""
    state = broken.end
    found = broken.obstacles.refusal(state, launch) if state else None
    return [_link(broken, state, found)] if state and found else []


def _waiting(broken: _Broken) -> str:
    """Return by what the request waits at the end of its run."""
    state, name = broken.end, broken.finding.subject
    told = _held_up(broken, state, name) if state is not None and state.places[name] else []
    return "; ".join([broken.finding.message, *told])


def _held_up(broken: _Broken, state: State, name: str) -> list[str]:
    """Return by what a request waits in a state, and launch rules that require again what holds it up; at the end of a
    lasso also what else holds it up in the loop.
    """
    found = broken.obstacles.blocked(state, name)
    if found is None:
        return []
    links = broken.obstacles.chain(state, name)
    told = [next(links), *takewhile(lambda each: isinstance(each[1], Launch), links)]
    return [_link(broken, there, each) for there, each in told] + _elsewhere(broken, found)


def _elsewhere(broken: _Broken, last: Blocked) -> list[str]:
    """Return by what else a request waits in the loop of a lasso than at its end, as one part of a sentence."""
    others: dict[str, str] = {}
    for state in broken.loop:
        found = broken.obstacles.blocked(state, last.request.name)
        if found is not None and found.waits and found.reason.rule not in (last.reason.rule, *others):
            others[found.reason.rule] = reason_text(broken.model, state, found)
    told = list(others.values())
    more = [f"{len(told) - SHADOWS} more"] if len(told) > SHADOWS else []
    return [f"earlier in the loop by {'; by '.join([*told[:SHADOWS], *more])}"] if told else []


def _deadlock(broken: _Broken) -> str:
    """Return by what the request waits at the end of its run, and what would mend that and cannot be either."""
    state, name = broken.end, broken.finding.subject
    first = None if state is None else broken.obstacles.blocked(state, name)
    if state is None or first is None:
        return broken.finding.message
    return f"{broken.finding.message}; {_chain(broken, state, name)}"


def _lockout(broken: _Broken) -> str:
    """Return by what the request waits at the end of its run, or what refuses an ask of it whatever follows."""
    state, request = broken.end, broken.model.request[broken.finding.subject]
    if state is None or state.places[request.name]:
        return _deadlock(broken)
    never = _never_launched(broken, [request.name])
    stuck = _stuck(broken, state, request.name)
    if not stuck:
        args = next(iter(broken.obstacles.launchable(state, request.name)), least_arguments(request))
        stuck = [f"{asked_text(request, args)} would be launched, but the assumptions leave no such step"]
    return "; ".join([broken.finding.message, *never, *stuck])


def _stuck(broken: _Broken, state: State, name: str) -> list[str]:
    """Return what keeps a request from a launch from a state on, as one part of a sentence, if something does."""
    _, last = broken.obstacles.stays(state, name)
    return [] if last is None else [_chain(broken, state, name)]


DETAILS: Mapping[str, Callable[[_Broken], str]] = {
    "completeness": _completeness,
    "property": _property,
    "rule-use": _rule_use,
    "redundancy": _redundancy,
    "reachability": _reachability,
    "obligation": _obligation,
    "deadlock": _deadlock,
    "lockout": _lockout,
    "starvation": _waiting,
}


# ---- causes in words ----


def _chain(broken: _Broken, state: State, name: str) -> str:
    """Return what keeps a request from a launch in a state, and what would mend that and cannot be either."""
    links = islice(broken.obstacles.chain(state, name), LINKS)
    return "; ".join(_link(broken, there, each) for there, each in links)


def _link(broken: _Broken, state: State, link: Blocked | Forbidden | Launch) -> str:
    if isinstance(link, Launch):
        return f"launch rule `{link.name}` requires `{link.request}` there"
    asked, so = asked_text(link.request, link.args), _so(broken, state, link)
    if isinstance(link, Forbidden):
        return f"{so}{asked} would be launched, but {_forbid([link.assumption])} the step"
    by = reason_text(broken.model, state, link)
    if so != LATER and broken.end is not None and by != reason_text(broken.model, broken.end, link):
        by = reason_text(broken.model, state, link, LATER.strip())
    if link.waits and broken.end is not None and broken.end.places[link.request.name]:
        return f"{so}`{link.request.name}` waits by {by}"
    return f"{so}{asked} is {'refused' if link.refused else 'kept waiting'} by {by}"


def _so(broken: _Broken, state: State, link: Blocked | Forbidden) -> str:
    """Return how what is so in a state that random runs come to is told, if it is not so at the end of the run."""
    if broken.end is None or state is broken.end or broken.obstacles.is_so(link, broken.end):
        return ""
    return MENDED if isinstance(link, Blocked) and broken.obstacles.is_alone(link, state) else LATER
