"""From the tree of a properties file to its properties and assumptions on a model (docs/language.md section 8)."""

from collections.abc import Iterator
from typing import assert_never

from exover.diagnostics import Diagnostic, did_you_mean, quote
from exover.model.model import NOWHERE, Location, Model
from exover.model.property import (
    Assumption,
    Atom,
    Conjunction,
    Form,
    Formula,
    Negation,
    Properties,
    Property,
    SomeUntil,
    all_always,
    all_finally,
    all_until,
    implies,
    some_finally,
)
from exover.resolve.circles import in_order, note_circle
from exover.resolve.conditions import names_in
from exover.resolve.formulas import Reader, negated
from exover.resolve.idle import note_fixed
from exover.resolve.mistakes import Mistakes, same_name
from exover.resolve.scope import PROPERTY, NameScope
from exover.resolve.vocabulary import meanings_of, names_of
from exover.source import Source, Span
from exover.syntax import tree


def resolve_properties(
    file: tree.Properties, source: Source, model: Model
) -> tuple[Properties | None, tuple[Diagnostic, ...]]:
    """Return the properties, None iff there is a mistake, and all mistakes in the order of the text.

    For a file of another spec this is the only mistake, since all its names would be unknown.
    """
    mistakes = Mistakes(source)
    if file.spec.text != model.name:
        message = f"the properties are for {quote(file.spec.text)}, the spec is {quote(model.name)}"
        mistakes.add("E419", message, file.spec.span, hint=did_you_mean(file.spec.text, [model.name]))
        return None, mistakes.in_order()
    reader = Reader(NameScope(names_of(model), meanings_of(model), mistakes, PROPERTY))
    _read_defines(reader, file)
    _check_doubles(reader, file)
    properties = [_property(reader, item) for item in file.items if isinstance(item, tree.Property)]
    assumptions = list(_assumptions(reader, file))
    found = mistakes.in_order()
    if found:
        return None, found
    fair = next((_where(reader, item.span) for item in file.items if isinstance(item, tree.AssumeFair)), None)
    stated = tuple(filter(None, properties)), tuple(assumptions)
    return Properties(*stated, fair is not None, source.name, fair or NOWHERE), ()


def _where(reader: Reader, span: Span) -> Location:
    return Location(*reader.mistakes.source.place(span.start))


# ---- names ----


def _read_defines(reader: Reader, file: tree.Properties) -> None:
    """Resolve the defines of the file, each after those that it uses, and note cycles and names declared twice."""
    names, known = reader.scope.names, reader.scope.meanings
    taken: dict[str, Span] = {}
    for item in file.items:
        if isinstance(item, tree.Define):
            name, span = item.name.text, item.name.span
            if name in names.quantities or name in names.constants.consts or name in known:
                reader.mistakes.add("E210", f"define {quote(name)} is a name of the spec already", span)
            elif first := same_name(taken, name, span):
                reader.mistakes.again(name, "define", span, first)
            else:
                names.defines[name] = item
    nodes = names.defines
    order, circles = in_order({name: sorted(names_in(node.condition)) for name, node in nodes.items()})
    for circle in circles:
        note_circle("define", [nodes[name].name for name in circle], reader.mistakes)
        reader.defines.update(dict.fromkeys(circle))
    for name in order:
        if name not in reader.defines:
            node = nodes[name].condition
            reader.defines[name] = reader.bounded(reader.condition(node), node.span)


def _check_doubles(reader: Reader, file: tree.Properties) -> None:
    """Note a second property of one name, and a second assumption of fair reports."""
    taken: dict[str, Span] = {}
    fair: Span | None = None
    for item in file.items:
        if isinstance(item, tree.Property):
            first = same_name(taken, item.name.text, item.name.span)
            if first:
                reader.mistakes.again(item.name.text, "property", item.name.span, first)
        elif isinstance(item, tree.AssumeFair):
            if fair:
                _assumed_twice(reader, "fair reports are", fair, item.span)
            fair = fair or item.span


# ---- statements ----


def _assumptions(reader: Reader, file: tree.Properties) -> Iterator[Assumption]:
    """Yield the assumptions; a second one with the same formula is a mistake."""
    first: dict[Formula, Span] = {}
    for item in (each for each in file.items if isinstance(each, tree.Assume)):
        found = _assumption(reader, item)
        if found is None:
            continue
        if found.formula in first:
            _assumed_twice(reader, "this is", first[found.formula], item.span)
        first.setdefault(found.formula, item.span)
        yield found


def _assumed_twice(reader: Reader, what: str, first: Span, span: Span) -> None:
    line, _ = reader.mistakes.source.position(first.start)
    reader.mistakes.add("E420", f"{what} assumed twice", span, label=f"first assumed on line {line}")


def _assumption(reader: Reader, item: tree.Assume) -> Assumption | None:
    read = reader.condition(item.condition)
    found = reader.bounded(negated(read) if item.never else read, item.condition.span)
    if read and isinstance(read.formula, Atom):
        so = "nothing is assumed"
        note_fixed(reader.mistakes, read.formula.condition, not item.never, so, item.condition.span)
    return Assumption(found.formula, _where(reader, item.span)) if found else None


def _property(reader: Reader, item: tree.Property) -> Property | None:
    found = _raw(reader, item.form) if isinstance(item.form, tree.Raw) else _form(reader, item.form)
    if found is None:
        return None
    kind, formula, premise = found
    meant = reader.condition(premise) if premise else None
    where = _where(reader, item.name.span)
    return Property(item.name.text, item.text, kind, formula, meant.formula if meant else None, where)


Read = tuple[Form, Formula, tree.Cond | None]
"""A form, its formula, and its premise as a node of the tree, None if it has none."""


def _raw(reader: Reader, form: tree.Raw) -> Read | None:
    found = reader.bounded(reader.formula(form.formula, form.logic), form.span)
    return (form.logic, found.formula, _premise_of(form.formula)) if found else None


def _form(reader: Reader, form: tree.SimpleForm) -> Read | None:
    """Return the formula of a form as in docs/language.md section 8, or None with its mistakes noted."""
    parts = _parts(reader, form)
    match form, parts:
        case tree.Never(condition), (one,):
            return "never", Negation(some_finally(one)), condition.parts[0] if isinstance(condition, tree.And) else None
        case tree.Always(condition), (one,):
            return "always", all_always(one), condition.left if isinstance(condition, tree.Implies) else None
        case tree.Possible(), (one,):
            return "possible", some_finally(one), None
        case tree.AlwaysPossible(), (one,):
            return "always possible", all_always(some_finally(one)), None
        case tree.FromPossible(premise), (one, two):
            return "from possible", all_always(implies(one, some_finally(two))), premise
        case tree.LeadsTo(premise), (one, two):
            return "leads to", all_always(implies(one, all_finally(two))), premise
        case tree.Precedes(_, second), (one, two):
            early = Conjunction((two, Negation(one)))
            return "precedes", Negation(SomeUntil(Negation(one), early)), second
        case tree.Until(), (one, two):
            return "until", all_until(one, two), None
        case _:
            return None


def _parts(reader: Reader, form: tree.SimpleForm) -> tuple[Formula, ...]:
    """Return the formulas of the conditions of a form, in the order of the text, without those with mistakes."""
    nodes: tuple[tree.Cond, ...]
    match form:
        case tree.Never(one) | tree.Always(one) | tree.Possible(one) | tree.AlwaysPossible(one):
            nodes = (one,)
        case tree.FromPossible(one, two) | tree.LeadsTo(one, two) | tree.Precedes(one, two) | tree.Until(one, two):
            nodes = (one, two)
        case _:
            assert_never(form)
    found = [reader.bounded(reader.condition(node), node.span) for node in nodes]
    return tuple(each.formula for each in found if each)


def _premise_of(formula: tree.Formula) -> tree.Cond | None:
    """Return p of `G (p -> q)` or `AG (p -> q)` if p has no temporal operator; else None."""
    match formula:
        case tree.Temporal("G" | "AG", tree.Connected("implies", (premise, _))):
            return _as_condition(premise)
        case _:
            return None


def _as_condition(node: tree.Formula) -> tree.Cond | None:
    """Return a formula without temporal operators as a condition; None for any other."""
    match node:
        case tree.Temporal() | tree.TemporalBinary() | tree.Quantified():
            return None
        case tree.Connected(connective, parts):
            found = [part for part in map(_as_condition, parts) if part is not None]
            return _connected(connective, tuple(found), node.span) if len(found) == len(parts) else None
        case _:
            return node


def _connected(connective: tree.Connective, parts: tuple[tree.Cond, ...], span: Span) -> tree.Cond:
    match connective:
        case "not":
            return tree.Not(parts[0], span)
        case "and":
            return tree.And(parts, span)
        case "or":
            return tree.Or(parts, span)
        case "implies":
            return tree.Implies(parts[0], parts[1], span)
        case "iff":
            there, back = tree.Implies(parts[0], parts[1], span), tree.Implies(parts[1], parts[0], span)
            return tree.And((there, back), span)
        case _:
            assert_never(connective)
