"""Detailed messages: what the trace of a finding, the model and the properties add to the text of its check."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, replace

from exover.checks.causes.blocked_detail import (
    held_up,
    kept_from_launch,
    kept_from_truth,
    of_deadlock,
    of_lockout,
    of_obligation,
    of_starvation,
    refused,
)
from exover.checks.causes.blocking import Obstacles
from exover.checks.causes.broken_finding import SHADOWS, BrokenFinding, never_launched
from exover.checks.causes.cause_wording import arguments_read, read_there
from exover.checks.causes.excluded import crowded, facts, forbidden, unset, unwaiting
from exover.checks.causes.property_detail import (
    conditions,
    conjuncts,
    false_first,
    given_up,
    goals,
    how_broken,
    owed,
    owed_since,
    requests_named,
)
from exover.checks.causes.remedy import advice
from exover.checks.causes.shadow_detail import of_idle_guard, of_reachability, of_redundancy, of_rule_use
from exover.checks.causes.shadowing import RULES, WithoutRules, shadows
from exover.checks.finding import Finding
from exover.checks.questions.property import BROKEN, VIOLATED, named
from exover.loop.claim import CONTRADICTION, CONTRADICTORY
from exover.model.expression import Cond
from exover.model.model import Consumption, Location, Model, Parameter, Share
from exover.model.property import Atom, Formula, Properties
from exover.model.ranges import FixedComparison, Ranges
from exover.model.reads import reads
from exover.model.semantics import Reference
from exover.model.state import State

SEARCHED = ("rule-use", "reachability", "redundancy")
"""Checks whose causes are searched in steps near the runs of other findings."""
RUNLESS = ("consistency", "tables")
"""Checks that are not about runs, so that assumptions do not matter."""


def detailed(
    model: Model, properties: Properties, findings: Sequence[Finding], is_late: Callable[[], bool]
) -> Iterator[Finding]:
    """Yield the findings in order, with the causes of the violated ones in their messages.

    Once it `is_late`, causes are no longer searched by runs of the reference interpreter.
    """
    reference = Reference(model)
    without = WithoutRules(model)
    obstacles = Obstacles(reference, without, properties.assumptions, is_late)
    verdicts = {each.key: each.verdict for each in findings}
    broken = [each for each in findings if each.verdict == "violated"]
    dead = {each.subject for each in broken if each.check == "rule-use"}
    contradictory = any(CONTRADICTORY in each.message for each in broken)
    searched = [e for e in broken if e.check in SEARCHED and (e.check != "redundancy" or e.subject not in dead)][:RULES]
    unlaunched = frozenset(each.subject for each in broken if each.check == "reachability")
    looks = searched and not contradictory and not is_late()
    looking = shadows(reference, without, properties.assumptions, findings) if looks else None
    for finding in findings:
        stuck = finding.message == CONTRADICTION
        add = _contradiction if stuck else DETAILS.get(finding.check)
        shown = stuck or finding.check in RUNLESS or (finding.trace and finding.trace.moments)
        if finding.verdict != "violated" or (CONTRADICTORY in finding.message and not stuck):
            yield finding
        elif contradictory and not shown:
            yield replace(finding, message=f"{CONTRADICTORY}, mend that first; {finding.message}")
        elif add is None:
            yield finding
        else:
            near = looking if finding in searched and not is_late() else None
            told = add(BrokenFinding(reference, properties, finding, obstacles, near, verdicts, unlaunched))
            yield replace(finding, message=told)


def out_of_range(model: Model, properties: Properties) -> Iterator[str]:
    """Yield, in words, the comparisons in properties and assumptions that have one value whatever happens."""
    stated = [(f"property `{each.name}`", each.formula, each.location) for each in properties.properties]
    stated += [("an assumption", each.formula, each.location) for each in properties.assumptions]
    ranges = Ranges(model)
    for what, formula, where in stated:
        for each in _decided(ranges, formula):
            yield f"{where}: in {what}, {each}"


def unchanging(model: Model, findings: Sequence[Finding]) -> Iterator[str]:
    """Yield, in words, the comparisons of a spec that have one value whatever happens and of which no finding tells.

    Each is told where it stands first.
    """
    told = "; ".join(finding.message for finding in findings)
    first: dict[FixedComparison, str] = {}
    ranges = Ranges(model)
    for where, what, condition, params in sorted(_written(model), key=lambda written: astuple(written[0])):
        for each in ranges.decided(condition, params):
            first.setdefault(each, f"{where}: in {what}, {each}")
    yield from (text for each, text in first.items() if str(each) not in told)


def _written(model: Model) -> Iterator[tuple[Location, str, Cond, tuple[Parameter, ...]]]:
    """Yield the conditions that a spec writes, each with its place, its name and the parameters that it may read."""
    for latch in model.latches:
        yield latch.location, f"latch `{latch.name}`", latch.condition, ()
    for request in model.requests:
        for guard in request.guards:
            yield guard.location, f"`{guard.name}`", guard.condition, request.params
        clauses: tuple[Share | Consumption, ...] = (*request.shares, *request.consumptions, *request.productions)
        for when in (each.when for each in clauses if each.when is not None):
            yield request.location, f"`{request.name}`", when, request.params
    for rule in (each for each in model.rules if each.kind in ("forbid", "fail")):
        params = model.request[rule.slot_of].params if rule.slot_of else ()
        yield rule.location, f"`{rule.name}`", rule.condition, params
    for launch in model.launches:
        yield launch.location, f"launch rule `{launch.name}`", launch.condition, ()


def _never_true(model: Model, formula: Formula) -> list[str]:
    """Return, in words, the comparisons of a formula that are always false because of ranges."""
    return [str(each) for each in _decided(Ranges(model), formula) if not each.truth]


def _decided(ranges: Ranges, formula: Formula) -> Iterator[FixedComparison]:
    yield from dict.fromkeys(each for condition in conditions(formula) for each in ranges.decided(condition))


# ---- by check ----


def _contradiction(broken: BrokenFinding) -> str:
    """Return that the assumptions forbid every step, and which of them the steps break that break the fewest."""
    least = (
        broken.obstacles.least_broken(broken.end) if broken.end is not None and not broken.obstacles.is_late() else []
    )
    told = [" and ".join(f"that at {each.location}" for each in both) for both in least[:SHADOWS] if both]
    return "; ".join([broken.finding.message, *([f"steps there break {', or '.join(told)}"] if told else [])])


def _completeness(broken: BrokenFinding) -> str:
    state = broken.end
    if state is None:
        return broken.finding.message
    return f"{broken.finding.message}; {advice(broken.reference, state.once_stopped(), broken.finding.subject)}"


def _property(broken: BrokenFinding) -> str:
    """Return how the property is broken, with its text, and the causes or values at the end of the run."""
    finding = broken.finding
    prop = named(broken.properties, finding.subject)
    how, message = how_broken(prop, finding.trace), finding.message
    for said in (VIOLATED, BROKEN[prop.form]):
        message = message.replace(said, how, 1)
    parts = [f'"{prop.text}": {message}' if prop.text else message]
    since = owed_since(broken.reference, prop, finding.trace) if prop.form == "leads to" else None
    parts += owed(since)
    if prop.form == "ltl":
        parts += false_first(broken.reference, prop.formula, finding.trace)
    parts += given_up(finding.trace, since or 0, prop.formula)
    state = broken.end
    if state is not None and finding.trace is not None and finding.trace.loop_start is not None:
        names = dict.fromkeys(name for names in requests_named(prop.formula) for name in names)
        parts += [told for name in names if state.places[name] for told in held_up(broken, state, name)]
        parts += [told for each in broken.model.launches if each.request in names for told in refused(broken, each)]
    elif state is not None:
        where = "at the end of the run" if prop.form == "ctl" else "there"
        read = (each for condition in conditions(prop.formula) for each in sorted(reads(condition)))
        parts += read_there(broken.model, state, read, where, arguments_read(conditions(prop.formula)))
        if prop.form in ("always possible", "from possible"):
            missed = _never_true(broken.model, prop.formula) or _launch_missed(broken, state, prop.formula)
            wanted = [each.condition for each in goals(prop.formula) if isinstance(each, Atom)]
            parts += missed or kept_from_truth(broken, state, wanted)
    else:
        parts += _without_run(broken, prop.formula, goals(prop.formula) if prop.form == "possible" else [])
    return "; ".join(parts)


def _vacuity(broken: BrokenFinding) -> str:
    """Return that the premise is never true, with the causes that the model tells without a run."""
    premise = named(broken.properties, broken.finding.subject).premise
    assert premise is not None, "only properties with a premise are asked about"
    return "; ".join([broken.finding.message, *_without_run(broken, premise, conjuncts(premise))])


def _without_run(broken: BrokenFinding, formula: Formula, parts: Sequence[Formula]) -> list[str]:
    """Return what the model tells of a formula without a run: comparisons that are fixed, requests never launched, and
    rules that forbid what it wants, `parts` of it at the same time.
    """
    known, fixed = facts(parts), map(str, _decided(Ranges(broken.model), formula))
    named = (name for names in requests_named(formula) for name in names)
    never = never_launched(broken, [*named, *unset(broken.model, known, broken.unlaunched)])
    return [*fixed, *never, *_excluded(broken.model, known)]


def _excluded(model: Model, known: Sequence[Cond]) -> list[str]:
    """Return what excludes by its form that all of these conditions are true."""
    return [*crowded(model, known), *unwaiting(model, known), *forbidden(model, known)]


def _launch_missed(broken: BrokenFinding, state: State, formula: Formula) -> list[str]:
    """Return what keeps a request from a launch, if the formula asks for the launch or activity of that one alone."""
    launched, said = requests_named(formula)
    wanted = list(dict.fromkeys([*launched, *(name for name in said if not state.active([name]))]))
    return never_launched(broken, wanted) + kept_from_launch(broken, state, wanted[0]) if len(wanted) == 1 else []


DETAILS: Mapping[str, Callable[[BrokenFinding], str]] = {
    "completeness": _completeness,
    "property": _property,
    "vacuity": _vacuity,
    "rule-use": of_rule_use,
    "redundancy": of_redundancy,
    "idle-guard": of_idle_guard,
    "reachability": of_reachability,
    "obligation": of_obligation,
    "deadlock": of_deadlock,
    "lockout": of_lockout,
    "starvation": of_starvation,
}
