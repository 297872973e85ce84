"""Promises of a formula of LTL are told apart as certificates number them, and the formula is the same."""

from random import Random

from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.backward_reachability import BackwardReachability
from exover.engines.bdd.fair_steps import LoopSteps
from exover.engines.bdd.fixpoints import Fixpoints
from exover.engines.bdd.ltl import Product
from exover.model.expression import Status
from exover.model.model import NOWHERE
from exover.model.property import (
    TRUE,
    Atom,
    Conjunction,
    Disjunction,
    Negation,
    Next,
    Properties,
    Property,
    Until,
    always,
    finally_,
)
from exover.model.semantics import Reference
from exover.proofs.statement import distinct, temporal
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.small import compiled, small_spec_of


def test_promises_are_told_apart() -> None:
    waits = Atom(Status("waiting", "m.a"))
    once = finally_(waits)
    said = Conjunction((once, Next(once), Next(once), Negation(always(Disjunction((once, waits))))))
    found = distinct(said)
    operators = [*temporal(found)]
    assert len(operators) == len(set(operators)) == 7
    assert [type(each) for each in operators] == [type(each) for each in temporal(said)]
    assert distinct(once) == once
    assert operators[0] == Until(TRUE, waits)


def test_ltl_with_promises_told_apart_is_the_same() -> None:
    """A formula is true, or not, whether its equal parts share their promises or not."""
    outcomes = set()
    for seed in (*range(10), 11):
        model = model_of(small_spec_of(seed))
        one = Formulas(Random(seed), model).ltl(1)
        said = Disjunction((Next(one), Conjunction((finally_(one), Next(finally_(one))))))
        asked = Properties((Property("p", None, "ctl", said, None, NOWHERE),), (), True)
        of = Analysis(compiled(model), Reference(model), lambda what: None, asked)
        answers = []
        for formula in (said, distinct(said)):
            product = Product(
                LoopSteps(BackwardReachability(of.stepper, of.stepper.universe, None)), of.meaning, formula
            )
            fixpoints = Fixpoints(product, product.constraints())
            answers.append(of.space.initial & ~product.true(formula) & fixpoints.fair == of.space.none)
        assert answers[0] is answers[1]
        outcomes.add(answers[0])
    assert outcomes == {True, False}
