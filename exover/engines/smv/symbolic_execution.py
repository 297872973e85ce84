"""Symbolic execution of programs to DEFINEs of SMV, one line for each value that changes."""

from collections import ChainMap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.smv.expression import (
    FALSE,
    TRUE,
    BooleanConstant,
    DefinedName,
    Expr,
    SmvSymbol,
    among,
    choice,
    disjunction,
    text,
)
from exover.engines.smv.names import SmvNames
from exover.engines.smv.predicates import SymbolConditions
from exover.loop.finite.execution import SymbolicExecution
from exover.loop.finite.program import SwitchCase, Walk
from exover.ocrd.tables import Node, Tables


@dataclass
class DefineExecution(SymbolicExecution[Expr]):
    """DEFINEs of one module, as they are made; `before`: the symbols of the variables' values at the beginning."""

    names: SmvNames
    tests: tuple[str, ...]
    """By node of the tables what it asks or does."""
    before: dict[int, SmvSymbol]
    changed: dict[int, SmvSymbol] = field(default_factory=dict)
    """By variable that has been given a value, the symbol of the one that it has at this point."""
    enabled: Expr = TRUE
    """Whether nothing that was required so far is missing."""
    lines: list[str] = field(default_factory=list)
    inputs: dict[str, int] = field(default_factory=dict)
    """What is chosen here, with the number of choices."""
    _part: str = ""
    _walks: int = 0
    _chosen: int = 0
    _made: dict[str, int] = field(default_factory=dict)

    def begin(self, part: str, why: str) -> None:
        """Begin a part: its DEFINEs have names that start so."""
        self._part, self._walks = part, 0
        self.lines += ["", f"  -- {why}"]

    def define(self, name: str, value: str, why: str = "") -> str:
        """Write a DEFINE and return its name."""
        self.lines.append(f"  {name} := {value};{f'  -- {why}' if why else ''}")
        return name

    def fork(self) -> "DefineExecution":
        """Return an execution from the same values that shares the DEFINEs: for events, of which one is chosen."""
        return replace(self, changed={})

    @cached_property
    def now(self) -> Mapping[int, SmvSymbol]:
        """The symbols of the variables' values at this point."""
        return ChainMap(self.changed, self.before)

    def named(self, expr: Expr, hint: str, why: str = "") -> Expr:
        """Return an expression that is short: a DEFINE, if the given one is not."""
        match expr:
            case BooleanConstant() | DefinedName():
                return expr
            case _:
                return DefinedName(self.define(self._fresh(hint), text(expr), why))

    @property
    def tables(self) -> Tables:
        """The tables that walks follow."""
        return self.names.loop.tables

    @property
    def none(self) -> Expr:
        """The condition that is never true."""
        return FALSE

    def set(self, var: int, cases: Iterable[tuple[Expr, SmvSymbol]]) -> None:
        """Give a variable the value of the first case that is true."""
        left = [(when, value) for when, value in cases if when != FALSE and value.text != self.now[var].text]
        if not left:
            return
        if left[0][0] == TRUE:
            self.changed[var] = left[0][1]
            return
        written = choice(((when, value.text) for when, value in left), self.now[var].text)
        name = self._fresh(self.names.flat(var))
        self.changed[var] = self.names.symbol(var, self.define(name, written))

    # ---- operations ----

    def _fresh(self, hint: str) -> str:
        start = f"{self._part}${hint}"
        self._made[start] = self._made.get(start, 0) + 1
        return f"{start}${self._made[start]}"

    @property
    def _conditions(self) -> SymbolConditions:
        """Conditions on the values of the variables at this point."""
        return SymbolConditions(self.names.loop, self.now)

    def assign(self, var: int, value: int, where: Expr) -> None:
        """Give a variable a value."""
        self.set(var, [(where, self.names.value(var, value))])

    def apply(self, var: int, mapping: tuple[int | None, ...], where: Expr) -> None:
        """Give a variable the image of the value that it has."""
        here = [(value, image) for value, image in enumerate(mapping) if image is not None and image != value]
        now = self._conditions
        self.set(var, [(where & now.is_value(var, v), self.names.value(var, image)) for v, image in here])

    def require(self, var: int, values: frozenset[int], where: Expr) -> None:
        """Stop where a variable has none of these values."""
        self.enabled &= ~where | self._conditions.among(var, values)

    def mark(self, label: tuple[str, ...], where: Expr) -> None:
        """Pass a mark: the text says nothing of it."""

    def choose(self, var: int, values: tuple[int, ...], where: Expr) -> None:
        """Give a variable one of these values, by an input."""
        if len(values) == 1:
            self.set(var, [(where, self.names.value(var, values[0]))])
            return
        name = f"choice${self._chosen}$of{len(values)}"
        self._chosen += 1
        self.inputs[name] = len(values)
        chosen = SmvSymbol(name, tuple(str(number) for number in range(len(values))))
        cases = [(where & among(chosen, (n,)), self.names.value(var, value)) for n, value in enumerate(values)]
        self.set(var, cases)

    def switch(self, var: int, branches: tuple[SwitchCase, ...], where: Expr) -> None:
        """Run the case of the value that a variable has."""
        here = [(case, where & self._conditions.among(var, values)) for case, values in branches if case]
        first = most = self._chosen
        for case, when in [(case, self.named(when, "if")) for case, when in here]:
            self._chosen = first  # one case is run at most, so all can choose by the same inputs
            self.run(case, when)
            most = max(most, self._chosen)
        self._chosen = most

    # ---- walks ----

    def walk(self, walk: Walk, where: Expr) -> None:
        """Follow a diagram on all its paths; its DEFINEs have a number of their own."""
        self._walks += 1
        super().walk(walk, where)

    def disjunction(self, conditions: list[Expr]) -> Expr:
        """Return that one of the conditions is true."""
        return disjunction(conditions)

    def joined(self, number: int, conditions: list[Expr]) -> Expr | None:
        """Return the condition under which a walk comes to a node, by a name; None if that is never true."""
        here = self.named(disjunction(conditions), f"w{self._walks}$n{number}", self.tests[number])
        return None if here == FALSE else here

    def branched(self, number: int, node: Node, fixed: dict[int, int], here: Expr) -> tuple[Expr, Expr]:
        """Return where the test of a node is true, and where it is not."""
        test = self.named(self._conditions.test(node.code, node.bound, fixed), f"w{self._walks}$t{number}")
        return here & test, here & ~test


def merged(
    ends: Sequence[Mapping[int, SmvSymbol]], before: Mapping[int, SmvSymbol], event: SmvSymbol
) -> dict[int, str]:
    """Return by variable its value after one of several programs, of which `event` says which was run.

    `ends`: by program the values that it changes.
    """
    alike: dict[int, dict[str, list[int]]] = {}
    for number, changed in enumerate(ends):
        for var, symbol in changed.items():
            if symbol.text != before[var].text:
                alike.setdefault(var, {}).setdefault(symbol.text, []).append(number)
    return {
        var: choice(((among(event, numbers), value) for value, numbers in alike.get(var, {}).items()), symbol.text)
        for var, symbol in before.items()
    }
