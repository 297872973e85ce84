"""The questions of a claim as SMT-LIB 2, each between `push` and `pop`, with what each answer says of the claim."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.smt.ag_ef import AlwaysPossible
from exover.engines.smt.bounded_semantics import BoundedSemantics
from exover.engines.smt.justice_ranking import JusticeRanking
from exover.engines.smt.questions import Asked, ClaimQuestions, Course, Goal, StuckQuestion, meaning
from exover.engines.smt.solver import STEPS, Inconclusive, Prover, StepClock, forget
from exover.engines.smt.system import System
from exover.engines.smt.unrolling import Taken
from exover.loop.claim import Claim
from exover.loop.exact.term import Term, below, numeral
from exover.loop.formula_classes import Lingering, conjuncts
from exover.model.property import Formula, momentary, parts_of

DEPTH = 4
"""The length of the runs of reachability questions, in steps."""
LASSO = 6
"""The length of the lassos, in steps."""
MOST, TOGETHER = 20 * STEPS, 120 * STEPS
"""The limits of the search for covering ways, in steps of the solver: for one question, and for all together."""
BESIDE = 20
"""What building the terms for one call of the solver takes, in steps for each term of the relation of steps."""
Define = Callable[[str, Formula], Iterator[str]]
"""Writes the definition of a predicate on states."""


def quoted(name: str) -> str:
    """Return a symbol."""
    return f"|{name}|"


def literal(term: Term) -> str:
    """Return a constant."""
    return str(term.constant).lower() if term.sort == "Bool" else numeral(term.number, term.sort)


def inputs_of(system: System) -> tuple[Term, ...]:
    """Return the variables for the values that events bring, each once."""
    return tuple(dict.fromkeys(each.var for move in system.moves for each in move.inputs))


def searches(found: Iterable[ClaimQuestions | str]) -> int:
    """Return for how many of the questions of all claims ways are looked for."""
    parts = [part for each in found if not isinstance(each, str) for part in each.parts]
    return sum(isinstance(part, StuckQuestion) and not part.wanted for part in parts)


@dataclass
class Asker:
    """Writes the questions about one system; `define` writes predicates.

    `searches`: for how many questions ways are still to be looked for; `steps`: of the solver, for all of them.
    """

    system: System
    prover: Prover
    define: Define
    searches: int
    steps: int = TOGETHER

    def questions(self, claim: Claim, found: ClaimQuestions | str) -> Iterator[str]:
        """Yield what is asked of a claim."""
        name = f"{claim.check} {claim.subject}"
        yield f"\n; ---- {name} ----"
        if isinstance(found, str):
            yield f"; Not asked here: {found}."
            return
        if len(found.parts) > 1:
            yield f"; It holds iff {'each' if found.every else 'one'} of its {len(found.parts)} parts does."
        for number, asked in enumerate(found.parts, 1):
            alone = len(found.parts) == 1
            called = name if alone else f"{name} ({number})"
            binding = claim.fair and bool(self.system.properties.assumptions)
            part = _Part(called, asked, alone, found.every, number, binding)
            yield from self._part(part)

    def _part(self, part: "_Part") -> Iterator[str]:
        match part.asked:
            case Goal():
                yield from self._goal(part, part.asked)
            case StuckQuestion():
                yield from self._ways(part, part.asked)
            case Course():
                yield from self._course(part, part.asked)

    # ---- moments ----

    def _goal(self, part: "_Part", goal: Goal) -> Iterator[str]:
        name = quoted(part.name)
        yield from self.define(part.name, goal.formula)
        if goal.least < 0:
            yield from _asked(part.says(sat=True, unsat=True, what="is this true at the start"), 0, [f"({name} s0)"])
            return
        reached = " ".join(f"({name} s{moment})" for moment in range(goal.least, DEPTH + 1))
        what = f"does a run of at most {DEPTH} steps come there"
        yield from _asked(part.says(sat=True, what=what, ends=True), DEPTH, [f"(or {reached})"])
        outside = self._false_at_start(goal.formula)
        if not outside and goal.least == 0:
            return
        before = f" (not ({name} s))" if outside else ""
        yield from _one_step(part.says(unsat=True, what="does a step come there"), f"{before} ({name} t)")

    # ---- ways ----

    def _ways(self, part: "_Part", ways: StuckQuestion) -> Iterator[str]:
        """Ask for a state from which none of some ways leads on: events that were found to lead to the goal."""
        name = part.name
        yield from self.define(f"{name} since", ways.stuck.since)
        yield from self._never(part, f"{name} since", ways.stuck.since)
        found = self._found(ways)
        if found is None:
            yield "; Not asked: no ways were found that lead on from every state between steps."
            return
        yield from self.define(f"{name} allowed", ways.stuck.way.allowed)
        yield from self.define(f"{name} goal", ways.stuck.way.goal)
        for number, way in enumerate(found):
            yield f"; Way {number}: {', then '.join(str(taken.kind) for taken in way) or 'no event'}."
            yield f"(define-fun {quoted(f'{name} way {number}')} ((s State)) Bool {self._way(name, way, ways)})"
        stuck = " ".join(f"(not ({quoted(f'{name} way {number}')} s))" for number in range(len(found)))
        yield "(push 1)"
        what = "is there a state from which none of these ways leads on"
        yield f'(echo "{part.says(unsat=True, what=what, ends=True)}")'
        yield f"(declare-const s State)\n(assert (and (lemma s) ({quoted(f'{name} since')} s) {stuck}))"
        yield "(check-sat)\n(pop 1)"

    def _found(self, ways: StuckQuestion) -> list[Sequence[Taken]] | None:
        """Return ways that lead on from everywhere, if some are found; those of no other question matter."""
        if ways.wanted:
            return None
        forget()
        self.prover.begin_anew()
        deadline, share = self.prover.clock.deadline, min(MOST, self.steps // self.searches)
        clock = StepClock(deadline, share, self._beside)
        try:
            return AlwaysPossible(self.system, ways.stuck, clock, endless=False).ways()
        except Inconclusive:
            clock.left()
            return None
        finally:
            self.steps, self.searches = self.steps - (share - max(0, clock.steps)), self.searches - 1

    @cached_property
    def _beside(self) -> int:
        """What building the terms for one call of the solver takes, in steps."""
        return BESIDE * sum(1 for _ in below([self.system.relation.step]))

    def _way(self, name: str, way: Sequence[Taken], ways: StuckQuestion) -> str:
        """Return where these events lead to the goal, by allowed ones."""
        goal, allowed = quoted(f"{name} goal"), quoted(f"{name} allowed")
        found = f"({goal} s{len(way)})" if way else f"({goal} s)"
        for number, taken in reversed(list(enumerate(way))):
            here = f"s{number}" if number else "s"
            found = f"(and (allowed {here} e) (let ((s{number + 1} (after {here} e))) {found}))"
            found = f"(let ((e {self._event(taken)})) {found})"
            if number or not ways.stuck.way.strict:
                found = f"(or ({goal} {here}) (and ({allowed} {here}) {found}))"
        return found

    def _event(self, taken: Taken) -> str:
        """Return an event; what is of no importance is the least value that there is."""
        layout, values = self.system.layout, dict[Term, Term]()
        for each in self.system.steps.inputs(taken.kind):
            value = taken.values.get(each.var.name)
            kind, sort = each.parameter.type, each.var.sort
            values[each.var] = layout.resting(kind) if value is None else layout.terms.literal(value, sort)
        none = {sort: layout.terms.literal(0, sort) for sort in ("Bool", "Int", "Real")}
        filled = [literal(values.get(var, none[var.sort])) for var in inputs_of(self.system)]
        return " ".join(["(event", quoted(str(taken.kind)), *filled]) + ")"

    def _never(self, part: "_Part", name: str, since: Formula) -> Iterator[str]:
        """Ask whether a step comes to where the question begins, if runs do not begin there."""
        if self._false_at_start(since):
            what = part.says(unsat=True, what=f"does a step come to where `{name}` is true")
            yield from _one_step(what, f" (not ({quoted(name)} s)) ({quoted(name)} t)")

    def _false_at_start(self, formula: Formula) -> bool:
        terms = self.system.terms
        return terms.replaced(self.system.truth(formula), self.system.initial) is terms.false

    # ---- runs ----

    def _course(self, part: "_Part", course: Course) -> Iterator[str]:
        atoms = tuple(dict.fromkeys(_moments(course.formula)))
        for number, formula in enumerate(atoms):
            yield from self.define(f"{part.name} {number}", formula)
        fair = " and fair" if course.fair else ""
        lines: list[str] = []
        ways = []
        if not self.system.properties.assumptions:
            ways.append(_TextSemantics(part.name, atoms, None, lines).true(0, course.formula))
        for back in range(LASSO):
            shown = _TextSemantics(part.name, atoms, back, lines).true(0, course.formula)
            ways.append(f"(and (same s{back} s{LASSO}) {' '.join([shown, *self._fair(course.fair, back)])})")
        what = f"does a run of {LASSO} steps show it that repeats itself{fair}"
        yield from _asked(part.says(sat=True, what=what), LASSO, [f"(or {' '.join(ways)})"], lines)
        if course.exact and course.fair and course.lingering is not None:
            yield from self._lingering(part, course.lingering)

    def _fair(self, wanted: bool, back: int) -> Iterator[str]:
        """Yield by slot that it is idle or reported between two moments."""
        for slot, names in self.system.layout.slots.items() if wanted else ():
            reports = [move.kind for move in self.system.moves if move.kind.reported == slot]
            idle = [f"(not ({quoted(names.active)} s{moment}))" for moment in range(back, LASSO)]
            ends = [f"(= (kind e{m}) {quoted(str(kind))})" for m in range(back, LASSO) for kind in reports]
            yield f"(or {' '.join([*idle, *ends])})"

    def _lingering(self, part: "_Part", lingering: Lingering) -> Iterator[str]:
        """Ask whether some slot, that nothing activates as long as the run stays, is active then: a ranking."""
        name = f"{part.name} stays"
        lasting = JusticeRanking(self.system, self.prover, self.system.truth(lingering.stays))
        slots = lasting.only_idle()
        yield from self.define(name, lingering.stays)
        for number, each in enumerate(conjuncts(lingering.whole)):
            if self._false_at_start(each):
                yield from self.define(f"{name} {number}", each)
                yield from self._never(part, f"{name} {number}", each)
        if slots:
            yield f"; No fair run stays for ever where this is true if the next {len(slots) + 1} answers are all unsat."
        names = [self.system.layout.slots[key].active for key in slots]
        for (request, slot), active in zip(slots, names, strict=True):
            kinds = [str(m.kind) for m in self.system.moves if m.kind.reported == (request, slot)]
            reported = " ".join(f"(= (kind e) {quoted(kind)})" for kind in kinds)
            since = f"(or (not ({quoted(active)} s)) {reported})"
            what = f"{part.name}: can {request}[{slot}] become active, or stay so at a report, while the run stays"
            stays = f"({quoted(name)} s) ({quoted(name)} t)"
            yield from _one_step(what, f" {stays} {since} ({quoted(active)} t)")
        idle = " ".join(f"(not ({quoted(active)} s))" for active in names)
        yield "(push 1)"
        what = "can all of these slots be idle while the run stays"
        yield f'(echo "{part.says(unsat=True, what=what, all_=bool(slots))}")'
        yield f"(declare-const s State)\n(assert (and (lemma s) ({quoted(name)} s) {idle}))\n(check-sat)\n(pop 1)"


@dataclass(frozen=True, slots=True)
class _Part:
    """One question of a claim: what it is called, and whether it is the only one.

    `binding`: whether it is about fair runs, and a finite run may not be able to go on as one.
    """

    name: str
    asked: Asked
    alone: bool
    every: bool
    number: int
    binding: bool

    def says(self, what: str, sat: bool = False, unsat: bool = False, all_: bool = False, ends: bool = False) -> str:
        """Return the line before a question: what is asked, and what those answers say that decide something.

        `ends`: it is about finite runs.
        """
        which = f"part {self.number}"
        fair = ", if these runs can go on fairly" if ends and self.binding else ""
        said = []
        if sat:
            said.append(f"sat{fair}: {meaning(self.asked, 'sat', which, self.alone, self.every)}")
        if unsat:
            answer = "all unsat" if all_ else f"unsat{fair}"
            said.append(f"{answer}: {meaning(self.asked, 'unsat', which, self.alone, self.every)}")
        return f"{self.name}: {what}? {', '.join(said)}"


class _TextSemantics(BoundedSemantics[str]):
    """What is true of the runs of a question, as text; what may be needed again is defined in a line of its own."""

    def __init__(self, name: str, atoms: Sequence[Formula], back: int | None, lines: list[str]) -> None:
        super().__init__(LASSO, back)
        self.name, self.atoms, self.lines = name, atoms, lines

    def truth(self, value: bool) -> str:
        """Return `true` or `false`."""
        return "true" if value else "false"

    def both(self, parts: Sequence[str]) -> str:
        """Return the conjunction."""
        return f"(and {' '.join(parts)})"

    def either(self, parts: Sequence[str]) -> str:
        """Return the disjunction."""
        return f"(or {' '.join(parts)})"

    def at(self, moment: int, formula: Formula, positive: bool) -> str:
        """Return where a formula without temporal operators, or its negation, is true of a moment."""
        found = f"({quoted(f'{self.name} {self.atoms.index(formula)}')} s{moment})"
        return found if positive else f"(not {found})"

    def named(self, value: str) -> str:
        """Return the name of a definition."""
        name = f"p{len(self.lines)}"
        self.lines.append(f"(define-fun {name} () Bool {value})")
        return name


def _moments(formula: Formula) -> Iterator[Formula]:
    """Yield the parts of a formula of LTL that are about one moment."""
    if momentary(formula):
        yield formula
        return
    for part in parts_of(formula):
        yield from _moments(part)


def _asked(what: str, depth: int, conditions: Iterable[str], definitions: Iterable[str] = ()) -> Iterator[str]:
    """Yield a question about the runs of so many steps; a shorter one goes on with steps that change nothing."""
    yield "(push 1)"
    yield f'(echo "{what}")'
    yield from (f"(declare-const s{moment} State)" for moment in range(depth + 1))
    yield from (f"(declare-const e{moment} Event)" for moment in range(depth))
    yield "(assert (start s0))"
    yield from (f"(assert (step s{moment} e{moment} s{moment + 1}))" for moment in range(depth))
    yield from definitions
    yield from (f"(assert {condition})" for condition in conditions)
    yield "(check-sat)\n(pop 1)"


def _one_step(what: str, condition: str) -> Iterator[str]:
    """Yield a question about one step from any state between steps."""
    yield "(push 1)"
    yield f'(echo "{what}")'
    yield "(declare-const s State)\n(declare-const e Event)\n(declare-const t State)"
    yield f"(assert (and (lemma s){condition} (step s e t)))"
    yield "(check-sat)\n(pop 1)"
