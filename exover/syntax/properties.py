"""The syntax tree of a properties file (docs/language.md section 8); read it through tree.py."""

from dataclasses import field
from typing import Literal, TypeAlias, get_args

from exover.dataclass import dataclass
from exover.source import Span
from exover.syntax.conditions import Compare, Cond, InRange, InSet, Last, Level, Name, Predicate, Term, Used
from exover.syntax.items import Define

Logic: TypeAlias = Literal["ctl", "ltl"]
Connective: TypeAlias = Literal["not", "and", "or", "implies", "iff"]
UnaryOperator: TypeAlias = Literal["X", "F", "G", "EX", "EF", "EG", "AX", "AF", "AG"]
BinaryOperator: TypeAlias = Literal["U", "R", "W"]
Quantifier: TypeAlias = Literal["A", "E"]
UNARY: tuple[UnaryOperator, ...] = get_args(UnaryOperator)
BINARY: tuple[BinaryOperator, ...] = get_args(BinaryOperator)
QUANTIFIERS: tuple[Quantifier, ...] = get_args(Quantifier)

# Raw formulas


@dataclass(frozen=True, slots=True)
class Connected:
    """Formulas joined by one connective: one for `not`, two for `implies` and `iff`, at least two for the others."""

    connective: Connective
    parts: "tuple[Formula, ...]"
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Temporal:
    """``operator part``; ``place`` is that of the operator."""

    operator: UnaryOperator
    part: "Formula"
    place: Span = field(compare=False)
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class TemporalBinary:
    """``left operator right``; it is right-associative. ``place`` is that of the operator."""

    left: "Formula"
    operator: BinaryOperator
    right: "Formula"
    place: Span = field(compare=False)
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Quantified:
    """``quantifier [ part ]``; ``place`` is that of the quantifier."""

    quantifier: Quantifier
    part: "Formula"
    place: Span = field(compare=False)
    span: Span = field(compare=False)


Simple: TypeAlias = Predicate | Last | Used | Level | Compare | InRange | InSet | Term
"""The parts of a condition."""
Formula: TypeAlias = Connected | Temporal | TemporalBinary | Quantified | Simple

# Forms of properties


@dataclass(frozen=True, slots=True)
class Never:
    """``never condition``."""

    condition: Cond
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Always:
    """``always condition``."""

    condition: Cond
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Possible:
    """``possible condition``."""

    condition: Cond
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class AlwaysPossible:
    """``always possible condition``."""

    condition: Cond
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class FromPossible:
    """``from premise possible goal``."""

    premise: Cond
    goal: Cond
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class LeadsTo:
    """``always (premise leads to goal)``."""

    premise: Cond
    goal: Cond
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Precedes:
    """``first precedes second``."""

    first: Cond
    second: Cond
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Until:
    """``kept until goal``."""

    kept: Cond
    goal: Cond
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Raw:
    """``ctl formula`` or ``ltl formula``."""

    logic: Logic
    formula: Formula
    span: Span = field(compare=False)


SimpleForm: TypeAlias = Never | Always | Possible | AlwaysPossible | FromPossible | LeadsTo | Precedes | Until
Form: TypeAlias = SimpleForm | Raw

# The file


@dataclass(frozen=True, slots=True)
class Property:
    """``property name "text": form;``."""

    name: Name
    text: str | None
    form: Form
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class AssumeFair:
    """``assume fair reports;``."""

    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Assume:
    """``assume always condition;``, or ``assume never`` if ``never``."""

    never: bool
    condition: Cond
    span: Span = field(compare=False)


PropertyItem: TypeAlias = Define | Property | AssumeFair | Assume


@dataclass(frozen=True, slots=True)
class Properties:
    """``for spec;`` and the items of the file, in the order of the text."""

    spec: Name
    items: tuple[PropertyItem, ...]
    span: Span = field(compare=False)
