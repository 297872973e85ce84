"""The engine `z3` for claims about runs."""

from contextlib import suppress
from dataclasses import field, replace
from functools import cached_property
from time import monotonic
from typing import assert_never

from exover.dataclass import dataclass
from exover.engines.smt.ag_ef import AlwaysPossible
from exover.engines.smt.assumptions import AssumptionCheck
from exover.engines.smt.concretize import ModelConcretizer, SpuriousModel
from exover.engines.smt.houdini import Houdini
from exover.engines.smt.justice_ranking import METHOD, JusticeRanking
from exover.engines.smt.lasso import LASSOS, FoundRun, Lassos
from exover.engines.smt.reachability import Reachability, UnreachableMoment
from exover.engines.smt.solver import Clock, Inconclusive, Prover
from exover.engines.smt.steps import SymbolicSteps
from exover.engines.smt.system import System
from exover.engines.smt.unrolling import Taken, Unrolled
from exover.loop.claim import CONTRADICTION, NO_FORMULA, Claim, Opinion, Verdict
from exover.loop.exact.actions import TableActions
from exover.loop.exact.layout import Layout
from exover.loop.exact.table_encoding import TableEncoding
from exover.loop.exact.term import Terms
from exover.loop.formula_classes import (
    AtStart,
    ExistsUntil,
    Joined,
    Opposite,
    Path,
    QuestionClass,
    Stuck,
    Unclassed,
    conjuncts,
    lingering_of,
    question_of,
    undoubled,
)
from exover.model.property import (
    TRUE,
    Conjunction,
    Disjunction,
    Formula,
    Negation,
    Next,
    Properties,
    SomeNext,
    Until,
    momentary,
    parts_of,
)
from exover.model.trace import Trace
from exover.ocrd.compile import Compiled

SECONDS = 60.0
"""The default time limit for one claim, in seconds."""
OPPOSITE: dict[Verdict, Verdict] = {"holds": "violated", "violated": "holds", "unknown": "unknown"}


@dataclass
class Smt:
    """Answers claims about one closed loop with Z3; `seconds` for each."""

    compiled: Compiled
    properties: Properties
    seconds: float = SECONDS
    name: str = "z3"
    clock: Clock = field(default_factory=Clock)
    _coherent: dict[bool, Trace | None] = field(default_factory=dict)

    @cached_property
    def steps(self) -> SymbolicSteps:
        """The steps of the loop."""
        layout = Layout(self.compiled.model, Terms())
        return SymbolicSteps(TableActions(TableEncoding(layout, self.compiled.tables)), Prover(self.clock))

    @cached_property
    def _runs(self) -> ModelConcretizer:
        return ModelConcretizer(self.steps, self.compiled.tables)

    def judge(self, claim: Claim) -> Opinion:
        """Return whether the claim is true of every run that the assumptions leave."""
        if claim.formula is None:
            return Opinion("unknown", "", NO_FORMULA)
        end = monotonic() + self.seconds
        try:
            self.clock.deadline = end if self.steps.looked else monotonic() + self.seconds / 2
            return self._judged(claim, claim.formula)
        except SpuriousModel as reason:
            return Opinion("unknown", "", str(reason))
        except Inconclusive as reason:
            if self.steps.looked:
                return Opinion("unknown", "", str(reason))
        return self._again(claim, claim.formula, end)

    def _again(self, claim: Claim, formula: Formula, end: float) -> Opinion:
        """Return what is found of a claim with the invariants of Houdini as lemmas, looked for once for all claims."""
        self.clock.deadline = (monotonic() + end) / 2
        with suppress(Inconclusive):
            self.steps.invariants = Houdini(self.steps, Prover(self.clock)).found()
        self.clock.deadline, self.steps.looked = end, True
        try:
            return self._judged(claim, formula)
        except (Inconclusive, SpuriousModel) as reason:
            return Opinion("unknown", "", str(reason))

    def _judged(self, claim: Claim, formula: Formula) -> Opinion:
        question = _Question(self, claim)
        opinion = question.opposite(question.endless(Negation(formula))) if claim.linear else question.decided(formula)
        if not claim.coherent or opinion.verdict != "holds":
            return opinion
        stranded = self._stranded(claim.fair)
        return opinion if stranded is None else Opinion("violated", "bounded search", CONTRADICTION, stranded)

    def _stranded(self, fair: bool) -> Trace | None:
        """Return a run to where the assumptions leave no step; None if none does and they leave a fair run."""
        if fair not in self._coherent:
            system = System(self.steps, self.properties, TRUE, fair=fair)
            coherence = AssumptionCheck(system, self.clock, self._runs)
            events = coherence.stranded()
            if events is None and fair and not coherence.fair:
                lassos = Lassos(Unrolled(system, self.clock), fair=True, endless=True)
                if lassos.find(TRUE, LASSOS) is None:
                    raise Inconclusive("bound reached: it is not known whether the assumptions leave a fair run")
            self._coherent[fair] = None if events is None else self._runs.trace(events)
        return self._coherent[fair]


@dataclass
class _Question:
    """One claim while it is looked into."""

    smt: Smt
    claim: Claim

    def __post_init__(self) -> None:
        self.fair, self.properties = self.claim.fair, self.smt.properties
        self.clock, self.runs = self.smt.clock, self.smt._runs

    def system(self, formula: Formula, fair: bool = False) -> System:
        """Return the transition system that a formula is about."""
        steps = self.claim.check == "property" and _counts_steps(formula)
        return System(self.smt.steps, self.properties, formula, steps, fair or self._binding)

    @property
    def _binding(self) -> bool:
        """Whether a run may not be able to go on fairly."""
        return self.fair and bool(self.properties.assumptions)

    # ---- formulas of CTL ----

    def decided(self, formula: Formula) -> Opinion:
        """Return whether a formula of CTL is true at the start: `holds` if so."""
        return self._decided(question_of(formula))

    def _decided(self, question: QuestionClass) -> Opinion:
        """Return whether a question is answered with yes."""
        match question:
            case Opposite(part):
                return self.opposite(self._decided(part))
            case Joined(parts, every):
                return self._all(parts, "violated" if every else "holds")
            case AtStart(moment):
                system = self.system(moment)
                truth = system.terms.replaced(system.truth(moment), system.initial) is system.terms.true
                return Opinion("holds" if truth else "violated", "initial state", trace=self.runs.trace(()))
            case Stuck():
                return self._stuck(question)
            case ExistsUntil():
                return self.shown(question.path, exact=True)
            case Path(path, exact):
                return self.shown(path, exact)
            case Unclassed():
                raise Inconclusive(
                    "no single run could show it, and it is not one of the questions that are asked otherwise"
                )
            case _:
                assert_never(question)

    def _all(self, parts: tuple[QuestionClass, ...], decisive: Verdict) -> Opinion:
        """Return the first opinion that decides for all, else one that does not."""
        opinions: list[Opinion] = []
        gave_up: list[Inconclusive] = []
        for part in parts:
            try:
                opinions.append(self._decided(part))
            except Inconclusive as reason:
                gave_up.append(reason)
            if opinions and opinions[-1].verdict == decisive:
                return opinions[-1]
        if gave_up:
            raise gave_up[0]
        return opinions[-1] if opinions else Opinion(OPPOSITE[decisive], "initial state")

    def opposite(self, opinion: Opinion) -> Opinion:
        """Return the opinion on the negation."""
        return Opinion(OPPOSITE[opinion.verdict], opinion.method, opinion.message, opinion.trace)

    # ---- from everywhere ----

    def _stuck(self, stuck: Stuck) -> Opinion:
        system = self.system(stuck.formula)
        found = AlwaysPossible(system, stuck, self.clock, self._ends_badly(system)).search()
        if isinstance(found, UnreachableMoment):
            return Opinion("violated", found.method)
        return Opinion("holds", "bounded search", trace=self._trace(system, found.steps))

    def _ends_badly(self, system: System) -> bool:
        """Return whether a run that has come somewhere may not be able to go on as it must."""
        return self._binding and not AssumptionCheck(system, self.clock, self.runs).fair

    def _trace(self, system: System, steps: list[Taken], loop_start: int | None = None) -> Trace:
        events = self.runs.events(system, steps)
        self.runs.followed(system, steps, events)
        return self.runs.trace(events) if loop_start is None else self.runs.lasso(events, loop_start)

    # ---- one run ----

    def shown(self, path: Formula, exact: bool) -> Opinion:
        """Return whether some run satisfies a formula of LTL: `holds` with the run if so.

        `exact`: if none does, that is the answer.
        """
        path = undoubled(path)
        least, target = 0, path
        if isinstance(target, Next) and isinstance(target.part, Until):
            least, target = 1, target.part
        match target:
            case Until(left, right) if momentary(left) and momentary(right):
                return self._reached(path, left, right, least)
        return self._lasso(path, exact)

    def endless(self, path: Formula) -> Opinion:
        """Return whether some run satisfies a formula of LTL; the run is a lasso if a short one is found."""
        opinion = self.shown(path, exact=True)
        if opinion.trace is None or opinion.trace.loop_start is not None:
            return opinion
        system = self.system(path, self.fair)
        with suppress(Inconclusive, SpuriousModel):
            found = Lassos(Unrolled(system, self.clock), self.fair, endless=True).find(path, LASSOS)
            if found is not None:
                return replace(opinion, trace=self._trace(system, found.steps, found.loop_start))
        return opinion

    def _reached(self, path: Formula, left: Formula, right: Formula, least: int) -> Opinion:
        system = self.system(path)
        way, goal = system.truth(left), system.truth(right)
        if left != TRUE:
            system = system.into(system.terms.either((way, goal)))
            at_start = system.terms.replaced(way, system.initial) is system.terms.true
            if not least and not at_start and system.terms.replaced(goal, system.initial) is system.terms.false:
                return Opinion("violated", "initial state")
        if left != TRUE and least:
            return self._lasso(path, exact=True)
        found = Reachability(system, self.clock).reach(goal, least)
        if isinstance(found, UnreachableMoment):
            return Opinion("violated", found.method)
        if self._ends_badly(system):
            return self._lasso(path, exact=False)
        return Opinion("holds", "bounded search", trace=self._trace(system, found.steps))

    def _lasso(self, path: Formula, exact: bool) -> Opinion:
        system = self.system(path, self.fair)
        if exact and self._refuted(path, Reachability(system, self.clock)):
            return Opinion("violated", METHOD)
        lassos = Lassos(Unrolled(system, self.clock), self.fair, self._ends_badly(system))
        shown: FoundRun | None = lassos.find(path, LASSOS)
        if shown is None:
            raise Inconclusive(f"bound reached: no run of {LASSOS[-1]} steps shows it, and it was not refuted")
        return Opinion("holds", "bounded search", trace=self._trace(system, shown.steps, shown.loop_start))

    def _refuted(self, path: Formula, reachability: Reachability) -> bool:
        """Return whether it is seen at once, by induction or a ranking of its parts, that no run satisfies a formula.

        Some run satisfies `f or g` iff some run satisfies `f` or some run does `g`; and `not (f U g)` is
        `(not g U neither) or G not g`.
        """
        system = reachability.system
        if momentary(path):
            return system.terms.replaced(system.truth(path), system.initial) is system.terms.false
        match path:
            case Negation(Negation(part)):
                return self._refuted(part, reachability)
            case Disjunction(parts):
                return all(self._refuted(part, reachability) for part in parts)
            case Negation(Conjunction(parts)):
                return all(self._refuted(Negation(part), reachability) for part in parts)
            case Conjunction(parts) if any(self._refuted(part, reachability) for part in parts):
                return True
            case Negation(Disjunction(parts)) if any(self._refuted(Negation(part), reachability) for part in parts):
                return True
            case Until(_, goal) if momentary(goal) and reachability.nowhere(system.truth(goal)):
                return True
            case Negation(Until(left, right)) if left != TRUE and momentary(left) and momentary(right):
                neither = Conjunction((Negation(left), Negation(right)))
                given_up, avoided = Until(Negation(right), neither), Negation(Until(TRUE, right))
                return self._refuted(given_up, reachability) and self._refuted(avoided, reachability)
        return self._lingers_nowhere(path, reachability)

    def _lingers_nowhere(self, path: Formula, reachability: Reachability) -> bool:
        """Return whether it is known that no run comes to stay where the formula wants it to."""
        lingering, system = lingering_of(path), reachability.system
        if lingering is None:
            return False
        stays = system.truth(lingering.stays)
        if any(reachability.nowhere(system.truth(part)) for part in conjuncts(lingering.whole)):
            return True
        return self.fair and JusticeRanking(system, reachability.prover, stays).excluded()


def _counts_steps(formula: Formula) -> bool:
    return isinstance(formula, SomeNext | Next) or any(map(_counts_steps, parts_of(formula)))
