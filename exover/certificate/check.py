"""Is what a certificate says of a table so? Every proof in it is checked anew (docs/certificates.md)."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

from exover.certificate.step import IDLE, Event, Step, domain, names
from exover.certificate.table import NONE, REAL, Refused, Table
from exover.certificate.term import conj, disj, neg, z3

SYMBOL = re.compile(r"(?<![\w.!|])(?:[a-z]+(?:\.\d+)+|start|abort|fault)(?![\w.!|])")
FACTS = ("launch", "wait", "reject", "kill", "named", "asked", "ended", "abort", "fault")
MEMORY = ("tried", "fallen")


def lifted(value: Any) -> Any:
    """Return a value as a term of Z3."""
    if isinstance(value, bool):
        return z3().BoolVal(value)
    if isinstance(value, int):
        return z3().IntVal(value)
    return z3().RealVal(str(value)) if isinstance(value, Fraction) else value


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
        self.said: dict[str, Any] = {}
        self._wakes: dict[tuple[str, int], set[str]] = {}
        self.whole_steps: dict[str, tuple[Step, Any]] = {}
        self._records()

    def _records(self) -> None:
        """Refuse a table whose vector is not what it counts, or whose rules are not looked at when they should be."""
        table, start = self.table, Step(self.table, self.initial)
        for entry, sources in table.sources.items():
            if sources[0][0] == "part":
                found = sum(factor * table.entries[part].initial for _, part, factor in sources)
            elif sources[0][0] in ("arg", "argrank", "order"):
                continue
            else:
                found = start.value(entry, None)
            if found != table.entries[entry].initial:
                raise Refused(f"entry {entry} of the vector does not start as what it counts")
        for number, rule in enumerate(table.rules):
            for node in self.below(rule.root):
                if node.code >= 0:
                    row = table.entries[node.code]
                    if all(word.word != number for word in table.lists[row.rules : row.rules_end]):
                        raise Refused(f"rule {number} is not looked at when entry {node.code} changes")
        for request, row in enumerate(table.requests):
            for feature in table.features[row.features : row.features_end]:
                for node in self.below(feature.predicate):
                    self._counted_anew(request, feature, node.code)

    def _counted_anew(self, request: int, feature: Any, entry: int) -> None:
        for source in self.table.sources.get(entry, ()) if entry >= 0 else ():
            for poster in [side for side in source[2:] if source[0] == "order" and side < 0]:
                row = self.table.variables[-1 - poster]
                anew = [word.word for word in self.table.lists[row.refresh : row.refresh_end]]
                if request not in anew or feature.waiting != NONE or feature.clearing != NONE:
                    raise Refused(f"what request {request} counts for is not counted anew when a poster changes")

    def below(self, root: int) -> list[Any]:
        """Return the nodes below a root."""
        found: dict[int, Any] = {}
        stack = [root]
        while stack:
            number = stack.pop()
            if number >= 0 and number not in found:
                found[number] = node = self.table.nodes[number]
                stack += [node.low] if node.code < 0 else [node.low, node.high]
        return list(found.values())

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
        found, stack, seen = set(), [expr], set()
        while stack:
            part = stack.pop()
            if z3().is_expr(part) and part.get_id() not in seen:
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
        for name in sorted(self.reads(expr)) if z3().is_expr(expr) else ():
            known = name in self.vars
            pairs.append((self.vars[name], state[name]) if known else (z3().Bool(name), facts.get(name, False)))
        return z3().substitute(expr, *((var, lifted(value)) for var, value in pairs)) if pairs else expr

    def true(self, expr: Any, state: dict[str, Any], facts: dict[str, Any]) -> bool:
        """Return whether a formula is true of a concrete moment."""
        return (isinstance(expr, bool) and expr) or bool(z3().is_true(z3().simplify(self.at(expr, state, facts))))

    def refute(self, what: str, *parts: Any) -> None:
        """Return iff no state is as all of the parts say; `Refused` if one is, `GaveUp` if that is not known."""
        if self.satisfiable(what, *parts):
            raise Refused(what)

    def satisfiable(self, what: str, *parts: Any) -> bool:
        """Return whether some state is as all of the parts say."""
        if any(part is False for part in parts):
            return False
        solver = z3().SimpleSolver()
        solver.set("timeout", int(1000 * self.seconds))
        solver.add([part for part in parts if part is not True])
        answer = solver.check()
        if answer == z3().unknown:
            raise GaveUp(f"it is not known whether {what}: {solver.reason_unknown()}")
        return bool(answer == z3().sat)

    # ---- what is invariant ----

    def inputs(self) -> Iterator[tuple[Event, list[Any]]]:
        """Yield every kind of event, with terms for its values, and their ranges."""
        table = self.table

        def fresh(rows: list[Any]) -> tuple[list[Any], list[Any]]:
            values = [(z3().Real if row.type == REAL else z3().Int)(f"input.{k}") for k, row in enumerate(rows)]
            return values, [part for row, value in zip(rows, values, strict=True) for part in domain(table, row, value)]

        for request, row in enumerate(table.requests):
            values, ranges = fresh(table.params[row.params : row.results])
            yield ("ask", request, 0, values), ranges
            results, ranges = fresh(table.params[row.results : row.params_end])
            for slot in table.slots(request):
                yield ("report", slot, 1, results), ranges
                yield from ((("report", slot, outcome, []), []) for outcome in (2, 3))
                yield ("abort", slot, 0, []), []
            yield ("give up", request, 0, []), []
        for number, row in enumerate(table.variables):
            if row.role == 0:
                values, ranges = fresh([row])
                yield ("observe", number, 0, values), ranges
        for number, row in enumerate(table.stocks):
            level = z3().Int("input.0")
            yield ("level", number, 0, [level]), [level >= 0, level <= row.capacity]

    def typed(self) -> list[Any]:
        """Return that everything is in its range, and nothing is amiss: part of what must be invariant."""
        table, var, found = self.table, self.vars, [neg(z3().Bool("fault"))]

        def kept(there: Any, name: str, rows: list[Any]) -> None:
            for k, row in enumerate(rows):
                found.extend(z3().Implies(there, part) for part in domain(table, row, var[f"{name}.{k}"]))

        for name, most in (("phase", 2), ("place", 2), ("last", 3)):
            found += [z3().And(var[n] >= 0, var[n] <= most) for n in var if n.startswith(f"{name}.")]
        for request, row in enumerate(table.requests):
            params = table.params[row.params : row.results]
            for slot in table.slots(request):
                kept(var[f"phase.{slot}"] != IDLE, f"arg.{slot}", params)
            kept(var[f"place.{request}"] != IDLE, f"held.{request}", params)
            kept(var[f"past.{request}"], f"past.{request}", table.params[row.params : row.params_end])
        for number, row in enumerate(table.variables):
            found += domain(table, row, var[f"reading.{number}"])
        return found + [
            z3().And(var[f"level.{k}"] >= 0, var[f"level.{k}"] <= s.capacity) for k, s in enumerate(table.stocks)
        ]

    def operations(self) -> Iterator[tuple[str, Any, Step]]:
        """Yield each event and each part of a pass: its name, when it can happen, and what it does to any state."""
        for event, ranges in self.inputs():
            now = Step(self.table, self.vars)
            yield f"event {event[0]} {event[1]}", conj(now.update(event), *ranges), now
        for part in Step(self.table, self.vars).components():
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
            self._looked_at(name, parts, enabled, now, changed)
        self.parts = parts

    def listen(self, parts: Iterable[Any]) -> None:
        """Follow the facts that these formulas read."""
        found: set[str] = set()
        self.said = {name: z3().Bool(name) for name in sorted(found.union(*map(self.reads, parts)) - self.vars.keys())}

    def changed(self, now: Step) -> set[str]:
        """Return the names of the state, and the facts, that a step has not left as they were."""
        state = {name for name, var in self.vars.items() if now.state[name] is not var}
        return state | {name for name, var in self.said.items() if now.facts.get(name, False) is not var}

    def _looked_at(self, name: str, parts: list[Any], enabled: Any, now: Step, changed: set[str]) -> None:
        """Check that a rule that would kill something was told of a change: the robot does not look at the others."""
        for number, rule in enumerate(self.table.rules):
            still = self.still(("recover", number))
            if still is not True and self.reads(still) & changed:
                tested = {node.code for node in self.below(rule.root) if node.code >= 0}
                before, mine = Step(self.table, self.vars), Step(self.table, now.state)
                same = [before.value(entry, None) == mine.value(entry, None) for entry in sorted(tested)]
                kills = neg(self.at(still, now.state, {}))
                self.refute(f"{name} is not told to rule {number}", *parts, enabled, still, *same, kills)

    def still(self, component: tuple[str, int]) -> Any:
        """Return when a part of a pass changes nothing."""
        now = Step(self.table, self.vars)
        now.run(component)
        return conj(*(now.state[name] == var for name, var in self.vars.items() if now.state[name] is not var))

    def wakes(self, component: tuple[str, int]) -> set[str]:
        """Return the names of the state on which it depends whether a part of a pass changes something."""
        if component not in self._wakes:
            still = self.still(component)
            self._wakes[component] = self.reads(still) if z3().is_expr(still) else set()
        return self._wakes[component]

    @cached_property
    def between(self) -> list[Any]:
        """Return what is true after every step: what is invariant, what is assumed, and that no part does anything."""
        stable = [self.still(component) for component in Step(self.table, self.vars).components()]
        return [*self.parts, *self.assumptions, neg(self.vars["start"]), *stable]

    # ---- whole steps ----

    def whole(self, event: Event, ranges: list[Any], first: bool = False) -> tuple[Step, Any]:
        """Return what the whole step of an event does to every state between steps, and when it can happen.

        Parts of passes are run as long as they may do something. With `first`, to the initial state alone.
        """
        if first or repr(event) not in self.whole_steps:
            now = Step(self.table, self.initial if first else self.vars)
            enabled = conj(now.update(event), *ranges)
            between = [] if first else self.between
            looked: dict[tuple[str, int], dict[str, Any]] = {}
            for _ in range(self.table.limits[0].passes):
                moved = False
                for component in now.components():
                    known = looked.get(component, now.state if first else self.vars)
                    looked[component] = dict(now.state)
                    if not first and all(now.state[name] is known[name] for name in self.wakes(component)):
                        continue
                    then = now.fork()
                    then.run(component)
                    does = disj(
                        *(then.state[n] != now.state[n] for n in self.vars if then.state[n] is not now.state[n])
                    )
                    if does is not False and self.satisfiable("a step goes on", *between, enabled, does):
                        now, moved = then, True
                if not moved:
                    break
            else:
                raise Refused(
                    f"it is not seen that the step of {event[:3]} ends within the passes that the table allows"
                )
            if first:
                return now, enabled
            self.whole_steps[repr(event)] = now, enabled
        return self.whole_steps[repr(event)]
