"""How a run breaks a property, in the words of the property's form, and at which step."""

from collections.abc import Iterator

from exover.checks.questions.property import BROKEN
from exover.model.event import Abort, AbortWaiting, Ask, Event, Rejected
from exover.model.expression import And, Cond, Status
from exover.model.expression import atoms as condition_atoms
from exover.model.property import (
    TRUE,
    Atom,
    Conjunction,
    Formula,
    Happened,
    Negation,
    Property,
    SomeAlways,
    SomeUntil,
    Until,
    atoms,
    subformulas,
    until_of,
)
from exover.model.run_moments import is_true, moments_of
from exover.model.semantics import Reference
from exover.model.trace import Answers, Trace, visited
from exover.model.wording import condition_text

LONG = 60
"""The greatest length of a condition, in characters, that is written out in such a message."""
ABORTS = 2
"""The greatest number of aborts, and of asks that supersede a wait, that a message names."""


def how_broken(prop: Property, trace: Trace | None) -> str:
    """Return, in words, how a run breaks a property."""
    until = until_of(prop.formula)
    match prop.form, prop.formula:
        case "until", _ if trace and until:
            first, second = until
            if trace.loop_start is not None:
                return f"a run never comes to {_phrase(second, 'the second')}"
            return f"a run gives up {_phrase(first, 'the first')} before {_phrase(second, 'the second')}"
        case "precedes", Negation(SomeUntil(Negation(first), Conjunction((second, _)))):
            return f"a run comes to {_phrase(second, 'the second')} before {_phrase(first, 'the first')}"
        case "leads to", formula:
            (missed,) = (each.part for each in subformulas(formula) if isinstance(each, SomeAlways))
            assert prop.premise is not None and isinstance(missed, Negation), "A leads to B"
            premise, conclusion = _phrase(prop.premise, "the premise"), _phrase(missed.part, "the conclusion")
            return f"a run comes to where {premise} is true, and from there on {conclusion} never is"
        case _:
            return BROKEN[prop.form]


def _phrase(formula: Formula, otherwise: str) -> str:
    """Return a condition as it is written, or `otherwise` if that has more than `LONG` characters."""
    text = condition_text(formula)
    return f"`{text}`" if len(text) <= LONG else otherwise


def false_first(reference: Reference, formula: Formula, trace: Trace | None) -> list[str]:
    """Return, as at most one part of a sentence, the step of a lasso after which the operand of the outermost `G` is
    first false.
    """
    match formula:
        case Negation(Until(left, wrong)) if left == TRUE and trace is not None and trace.loop_start is not None:
            moments = moments_of(reference, trace.events[: trace.loop_start], trace.events[trace.loop_start :])
            known = sorted(moments.where(wrong)) if moments is not None else []
            first = known[0] if known and known[0] <= len(trace.events) else None
            when = f"after step {first}" if first else "at the start"
            return [f"what its `G` says is false first {when}"] if first is not None else []
        case _:
            return []


def owed_since(reference: Reference, prop: Property, trace: Trace | None) -> int | None:
    """Return the number of steps after which the conclusion of `leads to` is owed and never comes; None if actions do
    not tell.
    """
    premise = prop.premise
    missed = next((each.part for each in subformulas(prop.formula) if isinstance(each, SomeAlways)), None)
    if trace is None or premise is None or missed is None:
        return None
    moments: list[tuple[Event | None, Answers]] = [(None, ()), *((each.event, each.actions) for each in trace.moments)]
    since: int | None = None
    for number, ((event, actions), state) in enumerate(zip(moments, visited(reference, trace.events), strict=True)):
        if not is_true(reference.model, event, state, actions, missed):
            since = None
        elif since is None and is_true(reference.model, event, state, actions, premise):
            since = number
    return since


def owed(since: int | None) -> list[str]:
    """Return, as at most one part of a sentence, the step from which on the conclusion is owed."""
    return [] if since is None else [f"the premise is true {f'after step {since}' if since else 'at the start'}"]


def given_up(trace: Trace | None, since: int, formula: Formula) -> list[str]:
    """Return, as parts of a sentence, the first waits and slots that a lasso ends by an abort after a number of steps,
    and the waits for requests of the formula that an ask supersedes.

    Each step of a lasso is needed, so an abort has its share in that what must come never does.
    """
    if trace is None or trace.loop_start is None:
        return []
    names = {name for named in requests_named(formula) for name in named}
    told: dict[str, int] = {}
    for number, moment in enumerate(trace.moments[since:], since + 1):
        match moment.event:
            case AbortWaiting(request):
                told.setdefault(f"the wait of `{request}` is given up by the abort", number)
            case Abort(request):
                told.setdefault(f"`{request}` is ended by the abort", number)
            case Ask(request) if request in names and _supersedes(moment.actions):
                told.setdefault(f"the wait of `{request}` is superseded by the ask", number)
            case _:
                pass
    return [f"{what} in step {number}" for what, number in list(told.items())[:ABORTS]]


def _supersedes(actions: Answers) -> bool:
    return any(isinstance(each, Rejected) and each.rule == "superseded" for each in actions)


def requests_named(formula: Formula) -> tuple[list[str], list[str]]:
    """Return the requests of a formula's atoms: those that must be launched, and those whose status is read."""
    happened = [each.request for each in atoms(formula) if isinstance(each, Happened) and each.occurrence == "launched"]
    said = [each for condition in conditions(formula) for each in condition_atoms(condition)]
    return happened, [each.request for each in said if isinstance(each, Status)]


def goals(formula: Formula) -> list[Formula]:
    """Return the parts that must all be true where `possible`, `always possible` or `from … possible` wants to come."""
    *_, last = (each.right for each in subformulas(formula) if isinstance(each, SomeUntil))
    return conjuncts(last)


def conjuncts(formula: Formula) -> list[Formula]:
    """Return the parts of which a formula is the conjunction, inside of conditions too."""
    match formula:
        case Conjunction(parts):
            return [each for part in parts for each in conjuncts(part)]
        case Atom(And(parts)):
            return [each for part in parts for each in conjuncts(Atom(part))]
        case _:
            return [formula]


def conditions(formula: Formula) -> Iterator[Cond]:
    """Return an iterator of the conditions on states in a formula."""
    return (atom.condition for atom in atoms(formula) if isinstance(atom, Atom))
