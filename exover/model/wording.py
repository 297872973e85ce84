"""Conditions as texts of the exo language; events and actions in the words of docs/language.md."""

from collections.abc import Sequence
from typing import assert_never

from exover.model.event import (
    Abort,
    AbortWaiting,
    Action,
    Args,
    Ask,
    Event,
    Invalid,
    Killed,
    Launched,
    Observe,
    Rejected,
    Report,
    Violated,
    Waits,
)
from exover.model.expression import (
    And,
    Compare,
    Cond,
    Const,
    Count,
    Last,
    Level,
    ModelTerm,
    Not,
    Or,
    Own,
    Param,
    Past,
    Reading,
    Status,
    Sum,
    Used,
)
from exover.model.model import Kill, KillSlot, Model, Parameter, Reject, Remedy, Wait
from exover.model.property import (
    Atom,
    Broken,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Next,
    Passed,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
)
from exover.model.types import Value
from exover.model.wire import number

# ---- values ----


def value_text(value: Value) -> str:
    """Return a value as the language writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(number(value)) if isinstance(value, float) else str(value)


def counted(count: int, one: str, several: str = "") -> str:
    """Return a number of things in words; `several`: the plural, if it is not `one` with an s."""
    return f"{count} {one if count == 1 else several or f'{one}s'}"


def named_text(parameters: Sequence[Parameter], values: Args) -> str:
    """Return arguments or results with their names; parameters past the last value are left out."""
    return ", ".join(f"{p.name} = {value_text(v)}" for p, v in zip(parameters, values, strict=False))


def slot_text(model: Model, name: str, slot: int) -> str:
    """Return `name`, or `name[slot]` if the request has several slots."""
    return f"{name}[{slot}]" if model.request[name].instances > 1 else name


# ---- conditions ----


def condition_text(cond: Cond | Formula) -> str:
    """Return a condition of the core as the language writes it, with as few parentheses as possible.

    Shorthand stays spelled out. A count of active slots, which has no syntax of its own, is `active slots of a, b`.
    A formula is written as in a properties file; raises `ValueError` for temporal operators, `Passed` and `Broken`.
    """
    match cond:
        case Atom(condition):
            return condition_text(condition)
        case Happened(occurrence, request, where):
            return f"{occurrence}({request}{_with(where)})"
        case Compare("==", left, Const(True)):
            return term_text(left)
        case Compare(operator, left, right):
            return f"{term_text(left)} {operator} {term_text(right)}"
        case Status(kind, request, where):
            return f"{kind}({request}{_with(where)})"
        case Past(request, where):
            return f"past({request}{_with(where)})"
        case Last(request, outcome):
            return f"last({request}) == {outcome}"
        case Not(part) | Negation(part):
            return f"not {_inside(part, 3)}"
        case And(parts) | Conjunction(parts):
            return " and ".join(_inside(part, 3) for part in parts) or "true"
        case Or(parts) | Disjunction(parts):
            return " or ".join(_inside(part, 2) for part in parts) or "false"
        case Passed() | Broken() | SomeNext() | SomeUntil() | SomeAlways() | Next() | Until():
            raise ValueError("it speaks of more than one moment, or of what no properties file can say")
        case _:
            assert_never(cond)


def _with(where: Cond | None) -> str:
    return "" if where is None else f" with {condition_text(where)}"


def _inside(cond: Cond | Formula, least: int) -> str:
    inner = cond.condition if isinstance(cond, Atom) else cond
    strength = 1 if isinstance(inner, Or | Disjunction) else 2 if isinstance(inner, And | Conjunction) else 3
    return condition_text(cond) if strength >= least else f"({condition_text(cond)})"


def term_text(term: ModelTerm) -> str:
    """Return a term as the language writes it."""
    match term:
        case Const(value):
            return value_text(value)
        case Param(name) | Reading(name):
            return name
        case Own(name):
            return f"self.{name}"
        case Used(resource):
            return f"used({resource})"
        case Level(resource):
            return f"level({resource})"
        case Count(requests):
            return f"active slots of {', '.join(requests)}"
        case Sum(constant, terms):
            return _sum_text(constant, terms)
        case _:
            assert_never(term)


def _sum_text(constant: int, terms: tuple[tuple[int, ModelTerm], ...]) -> str:
    parts = [
        (factor < 0, f"{abs(factor)} * {term_text(t)}" if abs(factor) != 1 else term_text(t)) for factor, t in terms
    ]
    if constant or not parts:
        parts.append((constant < 0, str(abs(constant))))
    (negative, first), *rest = parts
    text = f"-{first}" if negative else first
    return text + "".join(f" {'-' if minus else '+'} {part}" for minus, part in rest)


def remedy_text(remedy: Remedy) -> str:
    """Return a remedy as the language writes it; the kill of a `fail when`, which it does not write, in words."""
    match remedy:
        case Reject():
            return "reject"
        case Wait():
            return "wait"
        case Kill(requests):
            return f"kill {', '.join(requests)}"
        case KillSlot():
            return "kill that slot"
        case _:
            assert_never(remedy)


# ---- events and actions ----


def event_text(model: Model, event: Event) -> str:
    """Return an event in the words of docs/language.md section 4."""
    match event:
        case Ask(name, args):
            return f"ask {name}({named_text(model.request[name].params, args)})"
        case Report(name, slot, "ok", results):
            declared = model.request[name].results
            return f"report {slot_text(model, name, slot)} ok" + (
                f"({named_text(declared, results)})" if declared else ""
            )
        case Report(name, slot, outcome, _, status):
            return f"report {slot_text(model, name, slot)} {outcome}" + (f"({status})" if status else "")
        case Observe(name, value, broken):
            reading = f"broken, taken as {value_text(value)}" if broken else f"= {value_text(value)}"
            return f"observe {name} {reading}"
        case Abort(name, slot):
            return f"abort {slot_text(model, name, slot)}"
        case AbortWaiting(name):
            return f"abort {name} waiting"
        case _:
            assert_never(event)


def action_text(model: Model, action: Action) -> str:
    """Return an action in the words of docs/language.md section 5, with the rule in brackets and its text.

    The launch rule that raised a request follows `of`; if it launches at once, it is the rule in brackets instead.
    """
    match action:
        case Launched(name, slot, args, rule, because, launch_rule):
            launched = f"launch {slot_text(model, name, slot)}({named_text(model.request[name].params, args)})"
            return launched + (_why(rule, because) if rule else _origin(launch_rule))
        case Waits(name, rule, because, launch_rule):
            return f"wait {name}{_origin(launch_rule)}{_why(rule, because)}"
        case Rejected(name, rule, because, launch_rule):
            return f"reject {name}{_origin(launch_rule)}{_why(rule, because)}"
        case Killed(name, slot, rule, because):
            return f"kill {slot_text(model, name, slot)}{_why(rule, because)}"
        case Violated(rule, because):
            return f"violation{_why(rule, because)}"
        case Invalid(code, detail):
            return f"invalid {code}" + (f": {detail}" if detail else "")
        case _:
            assert_never(action)


def _why(rule: str, because: str | None) -> str:
    return f" [{rule}]" + ("" if because is None else f" {because}")


def _origin(launch_rule: str | None) -> str:
    return f" of {launch_rule}" if launch_rule else ""
