"""Prints statements of a tree as canonical text: parsing the text gives an equal tree.

The tree has no comments and no layout of the source, so the text has none of them. Parentheses are printed only where
the shape of the tree needs them. Each statement is one line; lines are not broken.
"""

from collections.abc import Iterable
from typing import assert_never

from exover.syntax import tree
from exover.syntax.lex import string_literal


def format_resource(resource: tree.Resource) -> str:
    """Return the text of a resource, `;` included."""
    consumable = " consumable" if resource.consumable else ""
    consumable += f" = {resource.initial.text}" if resource.initial else ""
    ending = _by(resource.remedies) + _because(resource.because)
    return f"resource {resource.name.text}: {resource.capacity.text}{consumable}{ending};"


def format_clause(clause: tree.Clause) -> str:
    """Return the text of one clause, `;` included."""
    return f"{_clause_body(clause)}{_because(clause.because)};"


def _clause_body(clause: tree.Clause) -> str:
    match clause:
        case tree.Check(label, condition):
            return f"check {_label(label)}{format_condition(condition)}"
        case tree.WaitUntil(label, condition):
            return f"wait {_label(label)}until {format_condition(condition)}"
        case tree.SettleUntil(label, condition):
            return f"settle {_label(label)}until {format_condition(condition)}"
        case tree.FailWhen(label, condition, else_wait):
            return f"fail {_label(label)}when {format_condition(condition)}{_else_wait(else_wait)}"
        case tree.After(requests):
            return f"after {_refs(requests)}"
        case tree.Before(requests):
            return f"before {_refs(requests)}"
        case tree.Interrupts(targets, else_wait):
            return f"interrupts {', '.join(map(_target, targets))}{_else_wait(else_wait)}"
        case tree.Uses(resource, amount, condition):
            return f"uses {resource.text} {amount.text}{_when(condition)}"
        case tree.Consumes(resource, amount, condition):
            return f"consumes {resource.text} {amount.text}{_when(condition)}"
        case tree.Produces(resource, amount, condition):
            return f"produces {resource.text} {amount.text}{_when(condition)}"
        case tree.OnSet(occasion, state, value):
            return f"on {occasion} set {_term(state)} = {_value(value)}"
        case tree.OnForget(occasion, requests):
            return f"on {occasion} forget {_refs(requests)}"
        case _:
            assert_never(clause)


def format_rule(rule: tree.Rule) -> str:
    """Return the text of one rule, `;` included."""
    ending = f"{_because(rule.because)};"
    label = _label(rule.label)
    match rule:
        case tree.Mutex(_, requests, remedies):
            return f"mutex {label}{_refs(requests)}{_by(remedies)}{ending}"
        case tree.MutexOver(_, winners, losers, else_wait):
            return f"mutex {label}{_refs(winners)} over {_refs(losers)}{_else_wait(else_wait)}{ending}"
        case tree.Limit(_, most, requests, remedies):
            return f"limit {label}at most {most.text} of {_refs(requests)}{_by(remedies)}{ending}"
        case tree.Forbid(_, condition, remedies):
            return f"forbid {label}{format_condition(condition)}{_by(remedies)}{ending}"
        case tree.Launch(_, request, arguments, condition):
            values = ", ".join(map(_value, arguments))
            return f"launch {label}{_listed(request)}({values}) when {format_condition(condition)}{ending}"
        case _:
            assert_never(rule)


def format_condition(condition: tree.Cond) -> str:
    """Return the text of a condition, with no more parentheses than its shape needs."""
    match condition:
        case tree.Implies(left, right):
            return f"{_inside(left, 1)} implies {_inside(right, 0)}"
        case tree.Or(parts):
            return " or ".join(_inside(part, 2) for part in parts)
        case tree.And(parts):
            return " and ".join(_inside(part, 3) for part in parts)
        case tree.Not(operand):
            return f"not {_inside(operand, 3)}"
        case tree.Predicate(kind, requests, inner):
            return f"{kind}({_refs(requests)}{'' if inner is None else f' with {format_condition(inner)}'})"
        case tree.Last(request, equal, outcome):
            return f"last({_listed(request)}) {'==' if equal else '!='} {outcome}"
        case tree.Used(resource, relation, amount):
            return f"used({resource.text}) {relation} {amount.text}"
        case tree.Level(resource, relation, amount):
            return f"level({resource.text}) {relation} {amount.text}"
        case tree.Compare(left, relation, right):
            return f"{_term(left)} {relation} {_term(right)}"
        case tree.InRange(term, low, high):
            return f"{_term(term)} in {_term(low)} .. {_term(high)}"
        case tree.InSet(term, members):
            return f"{_term(term)} in {{{', '.join(map(_term, members))}}}"
        case _:
            return _term(condition)


def _inside(condition: tree.Cond, least: int) -> str:
    """Return the text of a part, in parentheses if its precedence is below ``least``."""
    text = format_condition(condition)
    return f"({text})" if _strength(condition) < least else text


def _strength(condition: tree.Cond) -> int:
    match condition:
        case tree.Implies():
            return 0
        case tree.Or():
            return 1
        case tree.And():
            return 2
        case _:
            return 3


def _term(term: tree.Term) -> str:
    match term:
        case tree.Sum(first, rest):
            return _term(first) + "".join(f" {'-' if part.negative else '+'} {_term(part.term)}" for part in rest)
        case tree.Product(factors):
            return " * ".join(map(_term, factors))
        case tree.Number() | tree.Truth():
            return _value(term)
        case tree.NameUse(module, name):
            return name.text if module is None else f"{module.text}.{name.text}"
        case tree.SelfName(name):
            return f"self.{name.text}"
        case _:
            assert_never(term)


def _value(value: tree.Value) -> str:
    match value:
        case tree.Number(text, negative):
            return f"-{text}" if negative else text
        case tree.Truth(truth):
            return "true" if truth else "false"
        case tree.Word(name):
            return name.text
        case _:
            assert_never(value)


def _refs(requests: Iterable[tree.Listed]) -> str:
    return ", ".join(map(_listed, requests))


def _listed(listed: tree.Listed) -> str:
    match listed:
        case tree.Ref(module, request):
            return f"{module.text}.{request.text}"
        case tree.ModuleAll(module):
            return f"{module.text}.*"
        case tree.GroupName(name):
            return name.text
        case _:
            assert_never(listed)


def _target(target: tree.Target) -> str:
    match target:
        case tree.SelfTarget():
            return "self"
        case tree.AllTarget():
            return "all"
        case _:
            return _listed(target)


def _by(remedies: tuple[tree.Remedy, ...]) -> str:
    return " by " + " or ".join(map(_remedy, remedies)) if remedies else ""


def _remedy(remedy: tree.Remedy) -> str:
    match remedy:
        case tree.Reject():
            return "reject"
        case tree.Wait():
            return "wait"
        case tree.Kill(requests):
            return f"kill {_refs(requests)}"
        case _:
            assert_never(remedy)


def _label(label: tree.Name | None) -> str:
    return "" if label is None else f"{label.text}: "


def _when(condition: tree.Cond | None) -> str:
    return "" if condition is None else f" when {format_condition(condition)}"


def _else_wait(present: bool) -> str:
    return " else wait" if present else ""


def _because(text: str | None) -> str:
    return "" if text is None else f" because {string_literal(text)}"
