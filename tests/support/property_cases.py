"""Small specs with random properties, their moments, and what the checks say of them."""

from dataclasses import dataclass, replace
from functools import cache
from random import Random

from exover.checks.finding import Finding
from exover.checks.questions import property as property_check
from exover.checks.questions import vacuity
from exover.checks.questions.question import Check, Context, Question
from exover.engines.bdd.analysis import Analysis
from exover.model.model import NOWHERE, Model
from exover.model.property import (
    Atom,
    Conjunction,
    Form,
    Formula,
    Happened,
    Negation,
    Properties,
    Property,
    SomeUntil,
    Until,
    all_always,
    all_finally,
    all_until,
    always,
    atoms,
    finally_,
    formulas,
    implies,
    some_finally,
)
from exover.model.semantics import Reference
from exover.ocrd.compile import Compiled
from tests.support import explicit_ctl
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.moments import Moments, moments_of
from tests.support.small import compiled, small_spec_of
from tests.support.words import Word, word_of

MOST_STATES, MOST_STEPS = 300, 1500
MANY = (
    *(3, 6, 8, 16, 17, 26, 29, 36, 38, 39, 41, 51, 56, 60, 62, 67, 73, 103, 106, 107, 109, 111, 119, 123, 130, 246),
    *(253, 258, 261, 269, 275, 276),
)
SEEDS = (6, 17, 26, 29, 38, 51, 56, 73, 119, 246, 253, 261, 275)
"""Those that are looked at: every construct of specs and properties of the many is in two of them."""
WAITING = (0, 3, 14, 16, 17, 26, 27, 28, 29)
"""Seeds of specs small enough to go through them moment by moment; in WAITING some request can wait."""


@dataclass(frozen=True)
class Case:
    """A spec with properties, its moments one by one, and what the checks say."""

    spec: str
    made: Compiled
    properties: Properties
    moments: Moments
    found: dict[tuple[str, str], Finding]
    linear: dict[str, Formula | None]
    """By property the formula of LTL that says the same of one run."""

    @property
    def contradictory(self) -> bool:
        """Whether the assumptions leave some moment without a step, or no fair run at all."""
        return bool(self.moments.dead) or 0 not in explicit_ctl.fair(self.moments)

    @property
    def asked(self) -> list[Atom | Happened]:
        """What the formulas ask of moments."""
        return [atom for formula in formulas(self.properties) for atom in atoms(formula)]

    def word(self, finding: Finding) -> Word:
        """Return the run of a finding as the moments that it has."""
        assert finding.trace is not None
        return word_of(self.made.model, finding.trace, list(formulas(self.properties)))


def paired(of: Formulas) -> list[tuple[Property, Formula | None]]:
    """Return a property of each form of the language, with the formula of LTL that says the same of one run."""
    p, q = of.condition(1), of.condition(1)
    first = Until(Negation(p), Conjunction((q, Negation(p))))
    forms: list[tuple[Form, Formula, Formula | None]] = [
        ("never", Negation(some_finally(p)), always(Negation(p))),
        ("always", all_always(p), always(p)),
        ("possible", some_finally(p), None),
        ("always possible", all_always(some_finally(p)), None),
        ("from possible", all_always(implies(p, some_finally(q))), None),
        ("leads to", all_always(implies(p, all_finally(q))), always(implies(p, finally_(q)))),
        ("precedes", Negation(SomeUntil(Negation(p), Conjunction((q, Negation(p))))), Negation(first)),
        ("until", all_until(p, q), Until(p, q)),
        ("ctl", all_finally(p), finally_(p)),
    ]
    chosen = of.random.sample(forms, 4)
    return [(Property(form, None, form, formula, q, NOWHERE), linear) for form, formula, linear in chosen]


def asked(seed: int, model: Model) -> tuple[Properties, list[tuple[Property, Formula]]]:
    """Return the properties of this seed, and those among them that have a linear formula, with it."""
    of = Formulas(Random(seed), model)
    properties = of.properties(2, of.random.randint(1, 3))
    pairs = paired(of)
    return replace(properties, properties=(*properties.properties, *(each for each, _ in pairs))), pairs


@cache
def case_of(seed: int) -> Case:
    """Return the case of this seed."""
    spec = small_spec_of(seed)
    made = compiled(model_of(spec))
    properties, pairs = asked(seed, made.model)
    moments = moments_of(made.model, properties, MOST_STATES, MOST_STEPS)
    found = decided(made, properties, (property_check.CHECK, vacuity.CHECK))
    return Case(spec, made, properties, moments, found, {each.name: linear for each, linear in pairs})


def decided(made: Compiled, properties: Properties, checks: tuple[Check, ...]) -> dict[tuple[str, str], Finding]:
    """Return what these checks say, by check and subject."""
    context = Context(made, Analysis(made, Reference(made.model), lambda what: None, properties))
    return {
        (check.name, subject): check.decide(context, Question(check.name, check.severity, subject, location))
        for check in checks
        for subject, location in check.subjects(made.model, properties)
    }
