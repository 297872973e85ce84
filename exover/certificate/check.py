"""Is what a certificate says of a table so? Every proof in it is checked anew (docs/certificates.md)."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

from exover.certificate.step import Event, Step, domain, layout, names
from exover.certificate.table import NONE, REAL, Refused, Table
from exover.certificate.term import conj, disj, lifted, neg, z3

SYMBOL = re.compile(r"(?<![\w.!|])(?:[a-z]+(?:\.\d+)+|start|abort|fault)(?![\w.!|])")
FACTS = ("launch", "wait", "reject", "kill", "named", "asked", "ended", "abort", "fault")


class GaveUp(Exception):
    """The solver could not decide an implication in time; the text says which."""


@dataclass
class Checker:
    """Checks the proofs about one table; `parts`: what is invariant, once `induction` has returned."""

    table: Table
    seconds: float = 60.0
    assumptions: list[Any] = field(default_factory=list)
    parts: list[Any] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.initial = names(self.table)
        kinds = {bool: z3().Bool, int: z3().Int, Fraction: z3().Real}
        self.vars = {name: kinds[type(value)](name) for name, value in self.initial.items()}
        self.components = Step(self.table, self.vars).components()
        self.said: dict[str, Any] = {}
        self._still: dict[tuple[str, int], tuple[Any, set[str]]] = {}
        self._steps: dict[tuple[str, bool], tuple[Step, Any]] = {}
        self._vector()

    def _vector(self) -> None:
        """Refuse a table whose vector is not what it counts, or not counted or looked at anew when that changes."""
        table, start = self.table, Step(self.table, self.initial)
        for entry, sources in table.sources.items():
            if any(type(side) is tuple for side in sources[0]):
                continue  # an argument: it is loaded before it is tested
            if sources[0][0] == "part":
                first = sum(factor * table.entries[part].initial for _, part, factor in sources)
            else:
                first = start.value(entry, None)
            if first != table.entries[entry].initial:
                raise Refused(f"entry {entry} of the vector does not start as what it counts")
        for number, rule in enumerate(table.rules):
            for entry in table.tested(rule.root):
                row = table.entries[entry]
                if (number,) not in table.lists[row.rules : row.rules_end]:
                    raise Refused(f"rule {number} is not looked at when entry {entry} changes")
        for r, row in enumerate(table.requests):
            for feature in table.features[row.features : row.features_end]:
                sources = [s for entry in table.tested(feature.predicate) for s in table.sources.get(entry, ())]
                posters = [side for kind, *sides in sources for side in sides if kind == "order" and type(side) is str]
                for poster in (table.variables[int(side.split(".")[1])] for side in posters):
                    anew = table.lists[poster.refresh : poster.refresh_end]
                    if (r,) not in anew or feature.waiting != NONE or feature.clearing != NONE:
                        raise Refused(f"what request {r} counts for is not counted anew when a poster changes")

    # ---- formulas ----

    def formula(self, text: Any) -> Any:
        """Return the formula of a text of SMT-LIB 2 over the state and the facts."""
        if not isinstance(text, str):
            raise Refused("a formula is no text")
        known = {name: self.vars.get(name) for name in set(SYMBOL.findall(text))}
        for name in [name for name, var in known.items() if var is None]:
            if name.split(".")[0] not in FACTS:
                raise Refused(f"a formula reads {name}, which the table does not have")
            known[name] = z3().Bool(name)
        try:
            found = z3().parse_smt2_string(f"(assert {text})", decls=known)
        except z3().Z3Exception as error:
            raise Refused(f"a formula is none: {error}") from error
        if len(found) != 1 or not self.reads(found[0]) <= known.keys() or "declare" in text or "define" in text:
            raise Refused("a formula declares what is not of the table")
        return found[0]

    def reads(self, expr: Any) -> set[str]:
        """Return the names of the state and the facts that a formula reads."""
        found, seen = set(), set()
        stack = [expr] if z3().is_expr(expr) else []
        while stack:
            part = stack.pop()
            if part.get_id() not in seen:
                seen.add(part.get_id())
                if z3().is_quantifier(part):
                    raise Refused("a formula has quantifiers")
                if z3().is_const(part) and part.decl().kind() == z3().Z3_OP_UNINTERPRETED:
                    found.add(part.decl().name())
                stack += part.children()
        return found

    def at(self, expr: Any, state: dict[str, Any], facts: dict[str, Any]) -> Any:
        """Return a formula at another moment: there the state and the facts are these, other facts are not."""
        pairs = []
        for name in sorted(self.reads(expr)):
            known = name in self.vars
            pairs.append((self.vars[name], state[name]) if known else (z3().Bool(name), facts.get(name, False)))
        return z3().substitute(expr, *((var, lifted(value)) for var, value in pairs)) if pairs else expr

    def true(self, expr: Any, state: dict[str, Any], facts: dict[str, Any]) -> bool:
        """Return whether a formula is true of a concrete moment."""
        return bool(z3().is_true(z3().simplify(lifted(self.at(expr, state, facts)))))

    def refute(self, what: str, *parts: Any) -> None:
        """Return iff no state is as all of the parts say; `Refused` if one is, `GaveUp` if that is not known."""
        if self.satisfiable(what, *parts):
            raise Refused(what)

    def satisfiable(self, what: str, *parts: Any) -> bool:
        """Return whether some state is as all of the parts say."""
        if any(part is False for part in parts):
            return False
        solver = self.solver(parts)
        answer = solver.check()
        if answer == z3().unknown:
            raise GaveUp(f"it is not known whether {what}: {solver.reason_unknown()}")
        return bool(answer == z3().sat)

    def solver(self, parts: Iterable[Any]) -> Any:
        """Return a solver that asks for a state as all of the parts say."""
        solver = z3().SimpleSolver()
        solver.set("timeout", int(1000 * self.seconds))
        solver.add([part for part in parts if part is not True])
        return solver

    # ---- what is invariant ----

    def inputs(self) -> Iterator[tuple[Event, list[Any]]]:
        """Yield every kind of event, with terms for its values, and their ranges."""
        table = self.table

        def of(kind: str, number: int, outcome: int, rows: list[Any]) -> tuple[Event, list[Any]]:
            real = [getattr(row, "type", None) == REAL for row in rows]
            values = [(z3().Real if each else z3().Int)(f"input.{k}") for k, each in enumerate(real)]
            ranges = [part for row, value in zip(rows, values, strict=True) for part in domain(table, row, value)]
            return (kind, number, outcome, values), ranges

        for request, row in enumerate(table.requests):
            yield of("ask", request, 0, table.params[row.params : row.results])
            for slot in table.slots(request):
                yield of("report", slot, 1, table.params[row.results : row.params_end])
                yield from (of("report", slot, 2, []), of("report", slot, 3, []), of("abort", slot, 0, []))
            yield of("give up", request, 0, [])
        yield from (of("observe", number, 0, [row]) for number, row in enumerate(table.variables) if row.role == 0)
        yield from (of("level", number, 0, [row.capacity]) for number, row in enumerate(table.stocks))

    def typed(self) -> list[Any]:
        """Return that everything is in its range, and nothing is amiss: part of what must be invariant."""
        found = [neg(z3().Bool("fault"))]
        for name, _, row, owner in layout(self.table):
            absent: Any = False
            if owner:
                absent = neg(self.vars[owner]) if z3().is_bool(self.vars[owner]) else self.vars[owner] == 0
            found += [disj(absent, part) for part in domain(self.table, row, self.vars[name])]
        return found

    def operations(self) -> Iterator[tuple[str, Any, Step]]:
        """Yield each event and each part of a pass: its name, when it can happen, and what it does to any state."""
        for event, ranges in self.inputs():
            now = Step(self.table, self.vars)
            yield f"event {event[0]} {event[1]}", conj(now.update(event), *ranges), now
        for part in self.components:
            now = Step(self.table, self.vars, self.said)
            now.run(part)
            yield f"{part[0]} {part[1]}", True, now

    def induction(self, texts: list[str]) -> None:
        """Check that the formulas are true at first, and that no event and no part of a pass makes one false."""
        parts = [*self.typed(), *map(self.formula, texts)]
        support = [self.reads(part) for part in parts]
        self.listen(parts)
        for part in parts:
            if not self.true(part, self.initial, {}):
                raise Refused(f"not true at first: {part}")
        for name, enabled, now in self.operations():
            changed = self.changed(now)
            touched = [p for p, reads in zip(parts, support, strict=True) if reads & changed]
            after = conj(*(self.at(part, now.state, now.facts) for part in touched))
            self.refute(f"{name} makes false what should be invariant", *parts, enabled, neg(after))
            self._told(name, [*parts, enabled], now, changed)
        self.parts = parts

    def listen(self, parts: Iterable[Any]) -> None:
        """Follow the facts that these formulas read."""
        found = set[str]().union(*map(self.reads, parts))
        self.said = {name: z3().Bool(name) for name in sorted(found - self.vars.keys())}

    def changed(self, now: Step) -> set[str]:
        """Return the names of the state, and the facts, that a step has not left as they were."""
        state = {name for name, var in self.vars.items() if now.state[name] is not var}
        return state | {name for name, var in self.said.items() if now.facts.get(name, False) is not var}

    def _told(self, name: str, given: list[Any], now: Step, changed: set[str]) -> None:
        """Check that a rule that would kill something was told of a change: the robot does not look at the others."""
        for number, rule in enumerate(self.table.rules):
            still, wakes = self.still(("recover", number))
            if wakes & changed:
                before, after = Step(self.table, self.vars), Step(self.table, now.state)
                tested = self.table.tested(rule.root)
                same = [before.value(entry, None) == after.value(entry, None) for entry in tested]
                kills = neg(self.at(still, now.state, {}))
                self.refute(f"{name} is not told to rule {number}", *given, still, *same, kills)

    def still(self, component: tuple[str, int]) -> tuple[Any, set[str]]:
        """Return when a part of a pass changes nothing, and on which names of the state that depends."""
        if component not in self._still:
            now = Step(self.table, self.vars)
            now.run(component)
            still = conj(*(now.state[name] == var for name, var in self.vars.items() if now.state[name] is not var))
            self._still[component] = still, self.reads(still)
        return self._still[component]

    @cached_property
    def between(self) -> list[Any]:
        """Return what is true after every step: what is invariant, what is assumed, and that no part does anything."""
        still = (self.still(component)[0] for component in self.components)
        return [*self.parts, *self.assumptions, neg(self.vars["start"]), *still]

    # ---- whole steps ----

    def whole(self, event: Event, ranges: list[Any], first: bool = False) -> tuple[Step, Any]:
        """Return what the whole step of an event does to every state between steps, and when it can happen.

        Parts of passes are run as long as they may do something. With `first`, to the initial state alone.
        """
        key = (repr(event), first)
        if key not in self._steps:
            now = Step(self.table, self.initial if first else self.vars)
            enabled = conj(now.update(event), *ranges)
            given = [enabled] if first else [*self.between, enabled]
            looked = {} if first else dict.fromkeys(self.components, self.vars)
            self._steps[key] = self._settled(now, given, looked), enabled
        return self._steps[key]

    def _settled(self, now: Step, given: list[Any], looked: dict[tuple[str, int], dict[str, Any]]) -> Step:
        """Return a step once no part does anything any more; `looked`: the state in which it last did nothing more."""
        for _ in range(self.table.limits[0].passes):
            before = now
            for component in self.components:
                known = looked.get(component)
                if known and all(now.state[name] is known[name] for name in self.still(component)[1]):
                    continue
                looked[component] = now.state
                then = Step(self.table, now.state, now.facts)
                then.run(component)
                does = [then.state[n] != now.state[n] for n in self.vars if then.state[n] is not now.state[n]]
                if self.satisfiable("a step goes on", *given, disj(*does)):
                    now = then
            if now is before:
                return now
        raise Refused("it is not seen that a step ends within the passes that the table allows")
