"""The scope of a condition: how its names are resolved and what it may read."""

from dataclasses import field, replace
from typing import Literal, get_args

from exover.dataclass import dataclass
from exover.diagnostics import quote
from exover.model.expression import Cond, ModelTerm, Own, Param, Reading
from exover.model.types import Int, Real, Type
from exover.resolve.mistakes import Mistakes
from exover.resolve.names import QuantityName, Signature, SymbolTable, find_module
from exover.resolve.types import few_values
from exover.resolve.values import Constant, Symbol, at
from exover.source import Span
from exover.syntax import tree

ReadKind = Literal[
    "active",
    "running",
    "stopping",
    "waiting",
    "past",
    "last",
    "used",
    "level",
    "poster",
    "state",
    "latch",
    "pair",
]
"""What a condition can read; `pair`: a real poster compared with another real."""

EVERYTHING: frozenset[ReadKind] = frozenset(get_args(ReadKind))


@dataclass(frozen=True, slots=True)
class Standing:
    """A kind of place for conditions: what may be read there, and the code and help of the mistake otherwise."""

    name: str
    allowed: frozenset[ReadKind]
    code: str = ""
    hint: str = ""


_RULE_READS: frozenset[ReadKind] = frozenset({"active", "past", "used", "level", "poster", "state", "latch"})
_RULE_HINT = "write `active(…)`: its remedies would change what running, stopping, waiting and last answer"

DEFINE = Standing("a define", EVERYTHING)
PROPERTY = Standing("a property", EVERYTHING - {"pair"})
GUARD = Standing("a guard", EVERYTHING)
LAUNCH = Standing("`launch … when`", EVERYTHING - {"pair"})
FORBID = Standing("`forbid`", _RULE_READS, "E401", _RULE_HINT)
FAIL = Standing("`fail when`", _RULE_READS | {"pair"}, "E401", _RULE_HINT)
LATCH = Standing(
    "a latch", frozenset({"poster", "level", "latch"}), "E402", "it reads posters, levels and the latches before it"
)
AMOUNT = Standing("this `when`", frozenset(), "E403", "it reads parameters of its request only")


@dataclass(frozen=True, slots=True)
class Meaning:
    """A resolved condition: what it reads, the number of its atoms and its depth, with defines expanded."""

    cond: Cond
    reads: frozenset[tuple[ReadKind, str]]
    size: int
    depth: int


@dataclass(slots=True)
class ConditionTally:
    """The reads, atoms and depth so far of the condition that is being resolved."""

    reads: set[tuple[ReadKind, str]] = field(default_factory=set)
    size: int = 0
    depth: int = 0


@dataclass(frozen=True, slots=True)
class Typed:
    """A term of known type; the type of a sum is the range of its values."""

    type: Type
    term: ModelTerm
    origin: Literal["param", "reading", "constant", "sum"]
    span: Span


@dataclass(frozen=True, slots=True)
class Defined:
    """A use of a define; `meaning` is None if that has a mistake."""

    name: str
    meaning: Meaning | None
    span: Span


@dataclass(frozen=True, slots=True)
class Subject:
    """The request named before `with`, and the parameters that can be read of it (for `past` with the results)."""

    request: Signature
    params: dict[str, Type | None]


@dataclass(frozen=True, slots=True)
class NameScope:
    """The names that can be used in one place.

    `owner`: the request whose clause it is, None elsewhere; `subject`: the request of the `with` around it, if any.
    """

    names: SymbolTable
    meanings: dict[str, Meaning | None]
    mistakes: Mistakes
    standing: Standing
    owner: Signature | None = None
    subject: Subject | None = None
    latches: frozenset[str] = frozenset()
    """In the condition of a latch, the latches declared before it."""
    tally: ConditionTally = field(default_factory=ConditionTally)

    def inside(self, request: Signature, past: bool) -> "NameScope":
        """Return the scope inside a `with` of this request; `past`: results can be read too."""
        params = request.params | request.results if past else request.params
        return replace(self, subject=Subject(request, params))

    def read(self, kind: ReadKind, name: str, span: Span) -> bool:
        """Record that this is read, and return whether it may be read here; if not, note a mistake."""
        self.tally.reads.add((kind, name))
        return self._may_read(kind, name, span, "")

    def read_all(self, meaning: Meaning, define: str, span: Span) -> bool:
        """Record all that a define reads, and return whether it may be read here; if not, note a mistake."""
        self.tally.reads.update(meaning.reads)
        # Sorted, because the message names the first one that may not be read.
        return all(self._may_read(kind, name, span, define) for kind, name in sorted(meaning.reads))

    def _may_read(self, kind: ReadKind, name: str, span: Span, define: str) -> bool:
        through = f", as {quote(define)} does" if define else ""
        if kind == "pair" and "poster" not in self.standing.allowed:
            return True  # the posters that it compares are refused
        if kind == "pair" and "pair" not in self.standing.allowed:
            message = f"{self.standing.name} compares a real poster with a constant only{through}"
            self.mistakes.add("E313", message, span, hint="guards and `fail when` compare it with other reals")
        elif kind not in self.standing.allowed:
            what = name if kind in ("poster", "state", "latch") else f"{kind}({name})"
            message = f"{self.standing.name} cannot read {quote(what)}{through}"
            self.mistakes.add(self.standing.code, message, span, hint=self.standing.hint)
        elif kind == "latch" and self.standing is LATCH and name not in self.latches:
            message = f"a latch reads {quote(name)} before it is declared{through}"
            self.mistakes.add("E402", message, span, hint=self.standing.hint)
        else:
            return True
        return False

    def lookup(self, use: tree.NameUse) -> Typed | Constant | Defined | None:
        """Return what a name in a condition resolves to, or None with a mistake noted.

        A name that is declared as nothing else is a Symbol: the other side of a comparison decides its enum.
        """
        if use.module is not None:
            return self._member(use.module, use.name, use.span)
        name = use.name.text
        if self.subject:
            return self._inside_with(self.subject, name, use.span)
        if self.owner and name in self.owner.params:
            return self._param(self.owner.params[name], Param(name), use.span)
        module = self.names.modules[self.owner.module].quantities if self.owner else {}
        quantity = module.get(name) or self.names.quantities.get(name)
        if quantity:
            return self._quantity(quantity, use.span)
        if self.is_define(name):
            return Defined(name, self.meanings.get(name), use.span)
        return self._constant(name, use.span)

    def _inside_with(self, subject: Subject, name: str, span: Span) -> Typed | Constant | None:
        if name in subject.params:
            kind = subject.params[name]
            return Typed(kind, Param(name), "param", span) if kind else None
        if name in self.names.constants.consts or name in self.names.constants.enum_values:
            return self._constant(name, span)
        module = self.names.modules[self.owner.module].quantities if self.owner else {}
        quantity = module.get(name) or self.names.quantities.get(name)
        if quantity:
            self._no_reading(subject, quantity, name, span)
            return None
        if self.is_define(name):
            message = f"define {quote(name)} cannot be used inside `with`"
            self.mistakes.add("E219", message, span, hint="only parameters and constants can be read there")
            return None
        return Symbol(name, span)

    def is_define(self, name: str) -> bool:
        """Return whether a define of this file, or in a properties file one of the spec, has this name."""
        return name in self.names.defines or name in self.meanings

    def _no_reading(self, subject: Subject, quantity: QuantityName, name: str, span: Span) -> None:
        message = f"{quantity.kind} {quote(name)} cannot be read inside `with`"
        hint = "join it with `and` behind the bracket"
        if any(_comparable(kind, quantity.type) for kind in subject.request.params.values()):
            clause = f"in a clause of {quote(subject.request.name)}: `fail when CONDITION;`"
            hint += f"; with a parameter it is compared {clause}"
        self.mistakes.add("E216", message, span, hint=hint)

    def _constant(self, name: str, span: Span) -> Constant | None:
        constants = self.names.constants.consts
        if name not in constants:
            return Symbol(name, span)
        constant = constants[name]
        return None if constant is None else at(constant, span)

    def _member(self, module: tree.Name, name: tree.Name, span: Span) -> Typed | None:
        """Return the poster or state `m.s`, or None with a mistake noted."""
        value = name.text in self.names.constants.enum_values
        hint = f"an enum value is written alone: {quote(name.text)}" if value else ""
        found = find_module(self.names, module, self.mistakes, hint)
        if found is None:
            return None
        full = f"{module.text}.{name.text}"
        quantity = found.quantities.get(name.text)
        if quantity is None and name.text in found.requests:
            hint = f"did you mean {quote(f'active({full})')}?"
            self.mistakes.add("E219", f"{quote(full)} is a request, a poster or state is needed here", span, hint=hint)
        elif quantity is None:
            candidates = [known.name for known in found.quantities.values()]
            self.mistakes.unknown("E207", f"unknown poster or state {quote(full)}", full, span, lambda: candidates)
        elif self.subject:
            self._no_reading(self.subject, quantity, full, span)
        else:
            return self._quantity(quantity, span)
        return None

    def _quantity(self, quantity: QuantityName, span: Span) -> Typed | None:
        if not self.read(quantity.kind, quantity.name, span) or quantity.type is None:
            return None
        return Typed(quantity.type, Reading(quantity.name), "reading", span)

    def _param(self, kind: Type | None, term: ModelTerm, span: Span) -> Typed | None:
        return Typed(kind, term, "param", span) if kind else None

    def own(self, node: tree.SelfName) -> Typed | None:
        """Return the term of `self.p`, or None with a mistake noted; outside `with` it is the same as `p`."""
        name = node.name.text
        if self.owner is None:
            message = f"`self.{name}` stands outside the clauses of a request"
            self.mistakes.add("E215", message, node.span, hint="there is no request that `self` could mean")
            return None
        if name not in self.owner.params:
            request, params = self.owner.name, [f"self.{param}" for param in self.owner.params]
            message = f"{quote(request)} has no parameter {quote(name)}"
            self.mistakes.unknown("E208", message, f"self.{name}", node.span, lambda: params, scope=request)
            return None
        kind = self.owner.params[name]
        if self.subject is None:
            return self._param(kind, Param(name), node.span)
        if kind and not few_values(kind):
            message = f"{quote(f'self.{name}')} inside `with` has too many values"
            hint = "it needs a bool, an enum or an int of at most 256 values"
            self.mistakes.add("E305", message, node.span, hint=hint)
            return None
        return self._param(kind, Own(name), node.span)

    def parameter_hint(self, name: str) -> str:
        """Return the advice to write `self.name` inside `with` if the owner has such a parameter, else ""."""
        return (
            f"did you mean {quote(f'self.{name}')}?"
            if self.subject and self.owner and name in self.owner.params
            else ""
        )

    def unknown(self, symbol: Symbol) -> None:
        """Note that a name cannot be resolved here."""
        name, span = symbol.name, symbol.span
        if self.subject:
            request = self.subject.request
            hint = self.parameter_hint(name)
            if name in request.results:
                hint = f"{quote(name)} is a result, which only `past` can read"
            message = f"{quote(request.name)} has no parameter {quote(name)}"
            params = self.subject.params
            self.mistakes.unknown("E208", message, name, span, lambda: params, hint, request.name)
            return
        code, message, hint = "E201", f"unknown name {quote(name)}", self._other_kind(name)
        if not hint and not self.owner and any(name in request.params for request in self.names.requests.values()):
            code = "E412" if self.standing is DEFINE else "E217"
            message = f"{quote(name)} is a parameter, which {self.standing.name} cannot read"
            hint = "parameters are read in clauses of their request, or inside `with`"
        self.mistakes.unknown(code, message, name, span, self._visible, hint)

    def _other_kind(self, name: str) -> str:
        """Return the advice on a name that is declared as something else, "" if it is not."""
        full = [known.quantities[name].name for known in self.names.modules.values() if name in known.quantities]
        if full:
            return f"did you mean {quote(full[0])}?"
        if name in self.names.groups:
            return f"did you mean {quote(f'active({name})')}?"
        if name in self.names.resources:
            word = "level" if self.names.resources[name].consumable else "used"
            return f"did you mean {quote(f'{word}({name})')}?"
        return ""

    def _visible(self) -> list[str]:
        """Return the names that may be used here, without enum values."""
        owner = self.owner
        own = [*owner.params, *self.names.modules[owner.module].quantities] if owner else []
        full = [known.name for module in self.names.modules.values() for known in module.quantities.values()]
        return [
            "true",
            "false",
            *own,
            *self.names.quantities,
            *self.names.constants.consts,
            *self.names.defines,
            *self.meanings,
            *full,
        ]


def _comparable(left: Type | None, right: Type | None) -> bool:
    """Return whether two quantities of these types may be compared with each other in a `fail when`."""
    return left is not None and (left == right or (isinstance(left, Int | Real) and type(left) is type(right)))
