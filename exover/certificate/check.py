"""The checks of formulas on a table: what is invariant, what whole steps keep, what follows from both."""

import json
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

from exover.certificate.step import FACTS, Event, TableStep, counted, inputs, layout, within, worded
from exover.certificate.table import NONE, REAL, Refused, Table
from exover.certificate.term import conj, disj, lifted, neg, plain, z3

TOKEN = re.compile(r"[()]|[^\s()]+")
WORDS = re.compile(r"[()=<>+*/-]|[<>]=|and|or|not|ite|let|true|false|n?\d+(\.\d+)?")
"""What a formula may be made of, beside names of the state; `n0`, `n1`, ... are bound by `let`."""
State = dict[str, Any]


class SolverGaveUp(Exception):
    """The solver could not decide an implication in time; the text says which."""


@dataclass
class Checker:
    """Checks the proofs about one table; `parts`: the formulas that `induction`, and then `keep`, have proved.

    `watched`: entries [fact, request, formula over the arguments `value.K`]; formulas read entry N as `watched.N`.
    """

    table: Table
    seconds: float = 60.0
    assumptions: list[Any] = field(default_factory=list)
    parts: list[Any] = field(default_factory=list)
    watched: Sequence[Any] = ()

    def __post_init__(self) -> None:
        table = self.table
        table.counted, table.watched = counted(table), self.watched
        self.initial = {name: first for name, first, _, _ in layout(table)}
        kinds = {bool: z3().Bool, int: z3().Int, Fraction: z3().Real}
        self.vars = {name: kinds[type(value)](name) for name, value in self.initial.items()}
        self.lasting = {name for name in self.vars if name.split(".")[0] not in FACTS}
        parts = {"rule": table.rules, "required launch": table.launches, "settling of request": table.requests}
        self.components = [(part, number) for part, rows in parts.items() for number in range(len(rows))]
        self._reads: dict[int, tuple[Any, dict[str, Any]]] = {}
        self._still: dict[tuple[str, int], tuple[Any, set[str]]] = {}
        self._steps: dict[str, list[tuple[list[Any], State, TableStep, Any]]] = {}
        self._solver: tuple[list[Any], Any] = [], None
        table.watched = [(fact, request, self._where(request, text)) for fact, request, text in self.watched]
        self._vector()

    def _vector(self) -> None:
        """Refuse a table with an entry that does not start as what it counts, or misses changes of posters it reads."""
        table, start, now = self.table, TableStep(self.table, self.initial), TableStep(self.table, self.vars)
        if not all(within(row, row.fallback) for row in table.variables if row.has_fallback):
            raise Refused("a variable reads what is out of its range instead of a broken reading")
        kept = [row.raw for row in table.variables]
        for row in (*table.requests, *table.variables):
            for order, its in ((each, table.variables[-1 - k]) for each in row.orders for k in each[:2] if k < 0):
                if its.raw < 0 or kept.count(its.raw) > 1 or (row in table.variables and order not in its.orders):
                    raise Refused("a variable is not compared by what it reads, or not whenever that changes")
        for entry, sources in table.counted.items():
            if sources[0][0] == "part":
                first = sum(factor * table.entries[part].initial for _, part, factor in sources)
            else:
                first = table.entries[entry].initial if self._loaded(entry) else start.value(entry, {})
            if first != table.entries[entry].initial:
                raise Refused(f"entry {entry} of the vector does not start as what it counts")
        for r, row in enumerate(table.requests):
            for each in (*row.features, *row.pasts):
                args = now.held(f"past.{r}", row.params + row.results)
                for name in self.reads(now.agrees(each.predicate, r, args)):
                    kind, number, *_ = name.split(".")
                    known = kind == "reading" and (r,) in table.variables[int(number)].refresh and each in row.features
                    if not name.startswith(f"past.{r}.") and not (known and each.waiting == each.clearing == NONE):
                        raise Refused(f"what request {r} counts for is not counted anew when {name} changes")

    def _loaded(self, entry: int) -> bool:
        """Return whether an entry depends on arguments of a newcomer, so that it is loaded before it is tested."""
        sources = self.table.counted.get(entry, ())
        return any(isinstance(side, tuple) or (kind == "part" and self._loaded(side)) for kind, side, *_ in sources)

    # ---- formulas ----

    def formula(self, text: str, more: dict[str, Any] | None = None) -> Any:
        """Return the formula of a text of SMT-LIB 2 over the state and the names in `more`; `Refused` if it is none."""
        names = {word for word in TOKEN.findall(str(text)) if not WORDS.fullmatch(word)}
        known = self.vars | (more or {})
        if not names <= known.keys():
            raise Refused(f"a formula reads {min(names - known.keys())}, which the table does not have")
        try:
            (found,) = z3().parse_smt2_string(f"(assert {text})", decls={name: known[name] for name in names})
        except (z3().Z3Exception, ValueError) as error:
            raise Refused(f"this is no formula of SMT-LIB: {text!s:.60}") from error
        return plain(found)

    def _where(self, request: int, text: str) -> Callable[[list[Any]], Any]:
        """Return the function that applies a formula over `value.K` to the arguments of a request."""
        kinds = [getattr(row, "type", None) == REAL for row in self.table.requests[request].params]
        names = {f"value.{k}": (z3().Real if real else z3().Int)(f"value.{k}") for k, real in enumerate(kinds)}
        where = self.formula(text, names)
        if not self.reads(where).keys() <= names.keys():
            raise Refused("what is watched is not about arguments alone")
        return lambda args: plain(z3().simplify(lifted(self.at(where, dict(zip(names, args, strict=True))))))

    def reads(self, expr: Any) -> dict[str, Any]:
        """Return the names that a formula reads, each with its variable."""
        if not z3().is_expr(expr):
            return {}
        if expr.get_id() not in self._reads:
            found, seen, stack = {}, set(), [expr]
            while stack:
                part = stack.pop()
                if part.get_id() not in seen:
                    seen.add(part.get_id())
                    if z3().is_const(part) and part.decl().kind() == z3().Z3_OP_UNINTERPRETED:
                        found[part.decl().name()] = part
                    stack += part.children()
            self._reads[expr.get_id()] = expr, found
        return self._reads[expr.get_id()][1]

    def at(self, expr: Any, state: State, names: Iterable[str] | None = None) -> Any:
        """Return a formula with the names that it reads, or with `names` alone, replaced by their values in a state."""
        known = self.reads(expr) if names is None else {name: self.vars[name] for name in names}
        changed = [(var, lifted(state[name])) for name, var in known.items() if state.get(name, var) is not var]
        return z3().substitute(expr, *changed) if changed and z3().is_expr(expr) else expr

    def true(self, expr: Any, state: dict[str, Any]) -> bool:
        """Return whether a formula is true of a concrete moment."""
        return plain(z3().simplify(lifted(self.at(expr, state)))) is True

    def refute(self, what: str, given: list[Any], *parts: Any) -> None:
        """Raise `Refused` if some state satisfies what is given and all of the parts, `SolverGaveUp` if unknown."""
        if self.satisfiable(what, given, *parts):
            raise Refused(what)

    def satisfiable(self, what: str, given: list[Any], *parts: Any) -> bool:
        """Return whether some state satisfies what is given and all of the parts; raises `SolverGaveUp`."""
        whole = conj(*parts)
        if whole is False or (whole is True and not given):
            return bool(whole)
        solver = self.solver(given)
        solver.push()
        solver.add(whole)
        answer, reason = solver.check(), solver.reason_unknown()
        solver.pop()
        if answer == z3().unknown:
            raise SolverGaveUp(f"it is not known whether {what}: {reason}")
        return bool(answer == z3().sat)

    def solver(self, given: list[Any]) -> Any:
        """Return a solver with what is given as assertions; it is kept for the next question about the same list."""
        if id(given) != id(self._solver[0]):
            solver = z3().SimpleSolver()
            # At Ctrl-C, Z3 would end its search, and keep to itself why.
            solver.set("timeout", int(1000 * self.seconds), "ctrl_c", False)
            solver.add([part for part in given if part is not True])
            self._solver = given, solver
        return self._solver[1]

    # ---- what is invariant ----

    def opened(self, event: Event) -> tuple[Event, Any]:
        """Return an event with variables in place of ranges, and the condition that each variable is in its range."""
        values, ranges = list(event[3]), [True]
        for k, row in enumerate(event[3]):
            if hasattr(row, "low"):
                values[k] = (z3().Real if getattr(row, "type", None) == REAL else z3().Int)(f"input.{k}")
                ranges.append(within(row, values[k]))
        return (*event[:3], values), conj(*ranges)

    def event(self, said: Any) -> Event:
        """Return an event of a certificate, its reals as fractions; raises `Refused` if the table has no such event."""
        for event in inputs(self.table):
            if list(event[:3]) == said[:3] and len(said) == 4:
                pairs = list(zip(event[3], said[3], strict=True))
                values = [Fraction(v) if getattr(row, "type", None) == REAL else int(v) for row, v in pairs]
                if all(within(row, value) for (row, _), value in zip(pairs, values, strict=True)):
                    return (*event[:3], values)
        raise Refused(f"the table has no event {json.dumps(said)}")

    def typed(self) -> list[Any]:
        """Return the formulas that must be invariant of any table: no `fault`, and what is held is in its range."""
        found = [neg(self.vars["fault"])]
        for name, _, row, owner in layout(self.table):
            if row is not None:
                absent = bool(owner) and self.vars[owner] == (False if owner.startswith("past") else 0)
                found.append(disj(absent, within(row, self.vars[name])))
        return found

    def operations(self) -> Iterator[tuple[str, Any, TableStep]]:
        """Yield each event and part of a pass: its name, the condition that it happens, and the step from any state."""
        for event, ranges in map(self.opened, inputs(self.table)):
            now = TableStep(self.table, self.vars)
            yield worded(event), conj(now.update(event), ranges), now
        for part in self.components:
            now = TableStep(self.table, self.vars)
            now.run(part)
            yield f"{part[0]} {part[1]}", True, now

    def induction(self, texts: list[str]) -> None:
        """Check that the formulas are an inductive invariant: true at first, kept by events and parts of passes."""
        parts = [*self.typed(), *map(self.formula, texts)]
        for part in parts:
            if not self.true(part, self.initial):
                raise Refused(f"not true at first: {lifted(part).sexpr()}")
        for name, enabled, now in self.operations():
            changed = self.changed(now)
            after = self.at(conj(*(part for part in parts if self.reads(part).keys() & changed)), now.state, changed)
            self.refute(f"{name} makes false what should be invariant", parts, enabled, neg(after))
            self._told(name, parts, enabled, now, changed)
        self.parts = parts

    def changed(self, now: TableStep) -> set[str]:
        """Return the names of the state that a step may have changed."""
        return {name for name, var in self.vars.items() if now.state[name] is not var}

    def _told(self, name: str, parts: list[Any], enabled: Any, now: TableStep, changed: set[str]) -> None:
        """Check: if no entry that a rule is told of changed, a still rule stays still, and is broken iff it was."""
        before, after = TableStep(self.table, self.vars), TableStep(self.table, now.state)
        for number, rule in enumerate(self.table.rules):
            still, wakes = self.still(("rule", number))
            if wakes & changed:
                told = [entry for entry, row in enumerate(self.table.entries) if (number,) in row.rules]
                same = [before.value(n, {}) == after.value(n, {}) for n in told if not self._loaded(n)]
                kept = conj(self.at(still, now.state), before.broken(rule) == after.broken(rule))
                self.refute(f"{name} is not told to rule {number}", parts, enabled, still, *same, neg(kept))

    def still(self, component: tuple[str, int]) -> tuple[Any, set[str]]:
        """Return the condition that a part of a pass changes nothing, and the names read by it and by `broken`."""
        if component not in self._still:
            now, (part, number) = TableStep(self.table, self.vars), component
            broken = now.broken(self.table.rules[number]) if part == "rule" else True
            now.run(component)
            still = self._idle(now, self.vars)
            self._still[component] = still, {*self.reads(still), *self.reads(broken)}
        return self._still[component]

    def _idle(self, now: TableStep, before: State) -> Any:
        """Return the condition that a part of a pass, which ran from the state `before`, changed nothing but facts."""
        changed = (name for name in sorted(now.touched & self.lasting) if now.state[name] is not before[name])
        return conj(*(now.state[name] == before[name] for name in changed))

    @cached_property
    def between(self) -> list[Any]:
        """Return what is true after every step: what is invariant, what is assumed, and that no part does anything."""
        return [*self.parts, *self.assumptions, neg(self.vars["start"]), *(self.still(c)[0] for c in self.components)]

    # ---- whole steps ----

    def keep(self, texts: list[str]) -> None:
        """Check that formulas are true after every first step, and after each step if they were so before it."""
        kept = conj(*map(self.formula, texts))
        self.parts = [*self.parts, kept]
        for event in inputs(self.table) if texts else ():
            for given, _, now, enabled in self.steps(event):
                self.refute(f"{worded(event)} makes `kept` false", given, enabled, neg(self.at(kept, now.state)))

    def steps(self, event: Event) -> list[tuple[list[Any], State, TableStep, Any]]:
        """Return the whole steps of an event, one from the start, and one from all moments between steps.

        Each: what is given, the state before, the step, and the condition that it happens and is assumed.
        """
        key = repr(event)
        if key not in self._steps:
            kinds: Any = (([], self.initial), (self.between, self.vars))
            self._steps[key] = [(given, before, *self.whole(event, before, given)) for given, before in kinds]
        return self._steps[key]

    def whole(self, event: Event, state: State, given: list[Any]) -> tuple[TableStep, Any]:
        """Return the whole step of an event from a state, and the condition that it happens and is assumed."""
        event, ranges = self.opened(event)
        now = TableStep(self.table, state)
        enabled = conj(now.update(event), ranges)
        looked = dict.fromkeys(self.components, state) if given else {}
        for _ in range(self.table.limits[0].passes):
            before = now
            for component in self.components:
                known = looked.get(component)
                if known and all(now.state[name] is known[name] for name in self.still(component)[1]):
                    continue
                looked[component] = now.state
                then = TableStep(self.table, now.state, now.answers)
                then.run(component)
                if self.satisfiable("a step goes on", given, enabled, neg(self._idle(then, now.state))):
                    now = then
            if now is before:
                return now, conj(enabled, *(self.at(each, now.state) for each in self.assumptions))
        raise Refused("it is not seen that a step ends within the passes that the table allows")
