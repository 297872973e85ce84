"""The closed loop as SMV text: what NuSMV 2.6 and nuXmv read.

A step of the language, with all its settling, is one step of the text: a chain of DEFINEs, first what the event does,
then as many passes of the checker as some event needs.
"""

from collections.abc import Iterator, Sequence
from dataclasses import field, replace
from functools import cached_property
from itertools import pairwise
from typing import assert_never

from exover.dataclass import dataclass
from exover.engines.bdd.steps import Stepper
from exover.engines.smv.expression import FALSE, TRUE, DefinedName, SmvSymbol, among, choice, text
from exover.engines.smv.names import SIDES, SmvNames, claim_name, modules, word
from exover.engines.smv.predicates import SymbolConditions
from exover.engines.smv.specs import Specification, Writer, invariant, is_of
from exover.engines.smv.symbolic_execution import DefineExecution, merged
from exover.loop.claim import Claim
from exover.loop.finite.builder import ClosedLoop
from exover.loop.finite.predicates import StatePredicates
from exover.loop.finite.step_predicates import moments
from exover.loop.finite.variable_order import arrange
from exover.loop.finite.variables import MEMORY
from exover.model.event import Args, Report
from exover.model.index import ModelIndex
from exover.model.model import NOWHERE
from exover.model.property import Conjunction, Formula, Happened, Passed, Properties, Property
from exover.model.wording import condition_text, event_text, named_text, value_text
from exover.ocrd.compile import Compiled
from exover.ocrd.memory import IDLE

APPROXIMATE = (
    "-- Reals that change are compared with each other: there may be runs here that no values have. What is false",
    "-- has to be shown by a run that some have; what would be true of a run that none has is not asked.",
)


def looped(compiled: Compiled, properties: Properties, claims: Sequence[Claim]) -> ClosedLoop:
    """Return the closed loop that tells apart all that the claims and the assumptions speak of."""
    told = [Property("told", None, "ctl", claim.formula, None, NOWHERE) for claim in claims if claim.formula]
    return ClosedLoop(compiled.model, compiled.tables, compiled.entries, replace(properties, properties=tuple(told)))


@dataclass
class Text:
    """The text of a loop with claims about it; `nodes`: by node of the tables what it asks or does.

    `fair`: of fair runs alone, with those claims for which that matters; else with all others. `enough`: passes that
    settle every step of every run, if that is known. `unasked`: claims that are named and not asked.
    """

    loop: ClosedLoop
    claims: Sequence[Claim]
    fair: bool
    nodes: Sequence[str] = ()
    enough: int | None = None
    unasked: Sequence[Claim] = ()
    names: SmvNames = field(init=False)

    def __post_init__(self) -> None:
        self.names = SmvNames(self.loop)
        # What has one value is written as that: NuSMV makes a constant of it and then refuses that it is assigned.
        lasting = [n for n, v in enumerate(self.loop.variables) if v.key[0] not in MEMORY]
        self.state = [var for var in lasting if len(self.names.literals[var]) > 1]
        self._fixed = {var: self.names.value(var, 0) for var in lasting if len(self.names.literals[var]) == 1}
        self.modules = modules(request.name for request in self.loop.model.requests)
        self.modules += [m for m in modules(v.name for v in self.loop.model.variables) if m not in self.modules]
        self.event = SmvSymbol("environment.event", tuple(self.names.events) or ("nothing",))
        self._now = {var: self.names.symbol(var, self.names.state(var)) for var in self.state} | self._fixed
        self._meaning = StatePredicates(SymbolConditions(self.loop, self._now))

    # ---- what there is ----

    @property
    def restricted(self) -> bool:
        """Whether there are runs that may not go on: something is assumed, or nothing can happen."""
        return bool(self.loop.properties.assumptions) or not self.loop.events

    def moment(self, formula: Formula) -> str:
        """Return a formula of one moment as an expression."""
        return text(moments(self._meaning, formula), inside=True)

    @cached_property
    def specifications(self) -> list[Specification]:
        """The specifications: those of the claims, and whether the assumptions leave runs."""
        return list(self._specifications())

    def _specifications(self) -> Iterator[Specification]:
        if self.loop.properties.assumptions and not self.fair:
            live = "environment.live"
            yield Specification("assumptions.leave_steps", "CTLSPEC", f"AG ({live} -> EX {live})")
        if self.loop.properties.assumptions and self.fair:
            yield Specification("assumptions.leave_no_fair_run", "LTLSPEC", "FALSE", opposite=True)
        for claim in self.claims:
            if claim.formula is not None and is_of(claim, self.loop.properties, self.fair):
                yield self._specification(claim, claim.formula)

    def _specification(self, claim: Claim, formula: Formula) -> Specification:
        name, found = claim_name(claim), None if claim.linear or self.fair else invariant(formula)
        if found is not None:
            part, start = found
            excepted = ("" if start else "environment.start | ") + ("!environment.live | " if self.restricted else "")
            return Specification(name, "INVARSPEC", excepted + self.moment(part), claim)
        live = "environment.live" if self.restricted and not self.fair and not claim.linear else ""
        body = Writer(self.moment, live).write(formula)
        if claim.linear and self.restricted and not self.fair:
            body = f"G environment.live -> {body}"
        return Specification(name, "LTLSPEC" if claim.linear else "CTLSPEC", body, claim)

    @cached_property
    def order(self) -> list[str]:
        """The variables in an order that suits decision diagrams: what a step did, the event, then the states."""
        arranged = [var for var in arrange(self.loop) if var in set(self.state)]
        did = [var for var in arranged if self.loop.variables[var].key[0] == "happened"]
        found = ["environment.start"]
        found += ["environment.live"] if self.restricted else []
        found += [self.names.state(var) for var in did]
        found += ["environment.reported"] if self.fair and self._again else []
        return [*found, "environment.event", *(self.names.state(var) for var in arranged if var not in set(did))]

    # ---- the text ----

    def render(self) -> str:
        """Return the text."""
        parts = [self._head(), self._environment()]
        parts += [self._module(name) for name in self.modules]
        parts += [self._update(), self._checker(), self._main()]
        return "\n".join(line.rstrip() for part in parts for line in (*part, "")).rstrip() + "\n"

    def _head(self) -> list[str]:
        model = self.loop.model
        runs = "the claims for which it matters that reports are fair" if self.fair else "the claims about all runs"
        return [
            f"-- {model.name}: the functional modules in a loop with the checker, which is the decoded tables;",
            f"-- {runs}. Each step is an event and all that the checker does about it.",
            "-- NuSMV answers soonest with: set cone_of_influence; check_property -P NAME",
            *(APPROXIMATE if self.loop.approximate else ()),
            *(f"-- not asked: {claim_name(claim)}" for claim in self.unasked),
        ]

    def _declared(self, var: int) -> Iterator[str]:
        yield f"  {self.names.inside(var)} : {self.names.declared(var)};{self._legend(var)}"

    def _legend(self, var: int) -> str:
        """Return what the values of a variable stand for, where that is not plain."""
        loop = self.loop
        match loop.variables[var].key:
            case ("class", int(slot)):
                request = loop.tables.request_of(slot)
                return self._arguments(request, [kind.args for kind in loop.arguments[request].classes])
            case ("cell", int(request)):
                return self._arguments(request, [cell.args for cell in loop.arguments[request].cells])
            case ("past", int(request)):
                fields = (*loop.arguments[request].params, *loop.arguments[request].results)
                kinds = [named_text(fields, kind) for kind in loop.arguments[request].pasts.representatives]
                return _like(["none", *(kind or "there" for kind in kinds)])
            case ("reading", int(number)):
                return _like([value_text(value) for value in loop.samples[number]])
            case ("happened", int(number)):
                return f"  -- {_label(loop.observed[number])}"
            case _:
                return ""

    def _arguments(self, request: int, kinds: Sequence[Args]) -> str:
        return _like([named_text(self.loop.arguments[request].params, args) for args in kinds])

    def _assigned(self, var: int) -> Iterator[str]:
        name, initial = self.names.inside(var), self.loop.variables[var].initial
        after = f"after.{self.names.flat(var)}"
        if self.restricted:
            goes_on = "environment.goes_on" if self.names.owner(var) else "goes_on"
            after = f"case {goes_on} : {after}; TRUE : {name}; esac"
        yield f"  init({name}) := {self.names.literals[var][initial]};"
        yield f"  next({name}) := {after};"

    def _owned(self, owner: str | None) -> list[int]:
        return [var for var in self.state if self.names.owner(var) == owner]

    def _module(self, name: str) -> list[str]:
        own = self._owned(name)
        lines = [f"MODULE module${name}(environment, after)"]
        if own:
            lines += ["VAR", *(line for var in own for line in self._declared(var))]
            lines += ["ASSIGN", *(line for var in own for line in self._assigned(var))]
        return lines

    def _environment(self) -> list[str]:
        own = self._owned(None)
        lines = [f"MODULE environment({', '.join(['after', *map(word, self.modules)])})", "IVAR", "  event : {"]
        lines += [
            f"    {name}{',' if number < len(self.event.literals) - 1 else ''}"
            + (f"  -- {event_text(self.loop.model, self.loop.events[number].event)}" if self.loop.events else "")
            for number, name in enumerate(self.event.literals)
        ]
        lines += ["  };", "VAR", "  start : boolean;"]
        lines += [line for var in own for line in self._declared(var)]
        if self.restricted:
            lines.append("  live : boolean;")
        if self.fair and self._again:
            lines.append(f"  reported : 0..{len(self._again)};")
        lines += ["ASSIGN", "  init(start) := TRUE;", "  next(start) := FALSE;"]
        lines += [line for var in own for line in self._assigned(var)]
        if self.restricted:
            lines += ["  init(live) := TRUE;", "  next(live) := goes_on;"]
        if self.fair and self._again:
            cases = [
                (among(SmvSymbol("event", self.event.literals), self._reports(slot)), str(n))
                for n, slot in enumerate(self._again, 1)
            ]
            lines += ["  init(reported) := 0;", f"  next(reported) := {choice(cases, '0')};"]
        if self.restricted:
            after = {var: self.names.symbol(var, f"after.{self.names.flat(var)}") for var in self.state} | self._fixed
            formula = Conjunction(tuple(each.formula for each in self.loop.properties.assumptions))
            allowed = (
                moments(StatePredicates(SymbolConditions(self.loop, after)), formula) if self.loop.events else FALSE
            )
            lines += ["DEFINE", f"  goes_on := {text(DefinedName('live') & allowed)};"]
        return lines

    @cached_property
    def _slots(self) -> tuple[tuple[str, int], ...]:
        return ModelIndex(self.loop.model).slots

    @cached_property
    def _again(self) -> list[tuple[str, int]]:
        """The slots in which something may run again after the very step that reports them."""
        required = {launch.request for launch in self.loop.tables.launches}
        requests = {
            request.name
            for number, request in enumerate(self.loop.model.requests)
            if self.loop.may_wait[number] or number in required
        }
        return [slot for slot in self._slots if slot[0] in requests]

    def _reports(self, slot: tuple[str, int]) -> list[int]:
        events = [each.event for each in self.loop.events]
        return [n for n, e in enumerate(events) if isinstance(e, Report) and (e.request, e.slot) == slot]

    def _update(self) -> list[str]:
        before = dict(self._now)
        before |= {n: self.names.value(n, 0) for n, v in enumerate(self.loop.variables) if v.key[0] in MEMORY}
        anew = self.loop.anew
        before |= {cleared.var: self.names.value(cleared.var, cleared.value) for cleared in anew}
        base = DefineExecution(self.names, tuple(self.nodes) or ("",) * len(self.loop.tables.nodes), before)
        ends, enabled = [], []
        for name, each in zip(self.names.events, self.loop.events, strict=True):
            execution = base.fork()
            execution.begin(name, event_text(self.loop.model, each.event))
            execution.run(each.program[len(anew) :], TRUE)
            ends.append(execution.changed)
            enabled.append(execution.enabled)
        lines = [f"MODULE update({', '.join(['environment', *map(word, self.modules)])})"]
        lines += _choices(base)
        lines += ["DEFINE", *base.lines, ""]
        after = merged(ends, before, self.event)
        lines += [f"  {self.names.flat(var)} := {value};" for var, value in after.items() if var not in self._fixed]
        alike: dict[str, list[int]] = {}
        for number, when in enumerate(enabled):
            alike.setdefault(text(when), []).append(number)
        cases = [(among(self.event, numbers), value) for value, numbers in alike.items() if value != "TRUE"]
        lines.append(f"  enabled := {choice(cases, 'TRUE')};")
        return lines

    @cached_property
    def passes(self) -> int:
        """How many passes some event needs: what is known, else what diagrams of all states show, at most.

        What leaves the state as it is may still refuse a required launch: that is one pass more.
        """
        if self.enough is not None:
            return self.enough + 1
        stepper = Stepper(self.loop)
        most = 0
        for number in range(len(self.loop.events)):
            ran = stepper.step(number).ran
            most = max(most, bool(ran) + sum(one >= other for one, other in pairwise(ran)))
        return most

    def _checker(self) -> list[str]:
        if not self.passes:
            return []
        before = {n: self.names.symbol(n, f"before.{self.names.flat(n)}") for n in range(len(self.loop.variables))}
        before |= self._fixed
        execution = DefineExecution(self.names, tuple(self.nodes) or ("",) * len(self.loop.tables.nodes), before)
        for number, component in enumerate(self.loop.body):
            execution.begin(f"c{number}", self._component(number))
            execution.run(component.program, TRUE)
        lines = ["MODULE checker(before)", *_choices(execution), "DEFINE", *execution.lines, ""]
        left = {var: symbol for var, symbol in execution.now.items() if var not in self._fixed}
        return lines + [f"  {self.names.flat(var)} := {symbol.text};" for var, symbol in left.items()]

    def _component(self, number: int) -> str:
        """Return what a component of a pass is about."""
        loop = self.loop
        rules, launches = loop.tables.rules, loop.tables.launches
        if number < len(rules):
            return f"rule {loop.reasons[rules[number].reason].rule}"
        if number < len(rules) + len(launches):
            return f"launch {loop.reasons[launches[number - len(rules)].reason].rule}"
        waiting = [request.name for k, request in enumerate(loop.model.requests) if loop.may_wait[k]]
        return f"settle {waiting[number - len(rules) - len(launches)]}"

    def _main(self) -> list[str]:
        last = f"pass${self.passes}" if self.passes else "update"
        instances = [word(name) for name in self.modules]
        lines = ["MODULE main", *self._constants(), "VAR"]
        lines.append(f"  environment : environment({', '.join([last, *instances])});")
        lines += [f"  {word(name)} : module${name}(environment, {last});" for name in self.modules]
        lines.append(f"  update : update({', '.join(['environment', *instances])});")
        lines += [f"  pass${n} : checker({f'pass${n - 1}' if n > 1 else 'update'});" for n in range(1, self.passes + 1)]
        lines.append("TRANS update.enabled;")
        if self.fair:
            lines += [f"JUSTICE {when};" for when in self._justice()]
        for each in self.specifications:
            lines += ["", f"{each.kind} NAME {each.name} :=", f"  {each.body};"]
        return lines

    def _constants(self) -> list[str]:
        """Return the declaration of values that only DEFINEs have: how reals of one step compare."""
        declared = {literal for var in self.state for literal in self.names.literals[var]}
        only = [side for side in SIDES if side not in declared]
        compared = any(variable.key[0] == "chosen" for variable in self.loop.variables)
        return [f"CONSTANTS {', '.join(only)};"] if compared and only else []

    def _justice(self) -> Iterator[str]:
        if self.restricted:
            yield "environment.live"
        loop, conditions = self.loop, SymbolConditions(self.loop, self._now)
        for request, slot in self._slots:
            at = loop.tables.requests[loop.request_number[request]].slots + slot
            reported = (
                f" | environment.reported = {self._again.index((request, slot)) + 1}"
                if (request, slot) in self._again
                else ""
            )
            yield text(conditions.is_value(loop.index["phase", at], IDLE)) + reported


def _choices(execution: DefineExecution) -> list[str]:
    return (
        ["IVAR", *(f"  {name} : 0..{count - 1};" for name, count in execution.inputs.items())]
        if execution.inputs
        else []
    )


def _like(kinds: Sequence[str]) -> str:
    """Return a comment that tells, in their order, what values stand for: themselves and all that are decided alike."""
    return f"  -- alike: {' | '.join(kinds)}" if len(kinds) > 1 else ""


def _label(observed: Happened | Passed) -> str:
    match observed:
        case Happened(occurrence, request, where):
            return f"{occurrence}({request}{f' with {condition_text(where)}' if where else ''})"
        case Passed(label):
            return " ".join(label)
        case _:
            assert_never(observed)
