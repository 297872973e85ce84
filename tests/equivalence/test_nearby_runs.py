"""What short runs near a rule or guard show is what sets of states say."""

from collections import Counter

from exover.checks.questions.question import Context
from exover.engines.bdd.analysis import Analysis
from exover.loop.finite.tested_bounds import TooLarge
from exover.model.semantics import Reference
from tests.support.constructs import seldom
from tests.support.engines import model_of
from tests.support.small import compiled, small_spec_of

MANY = range(24)
SEEDS = (*range(10), 15, 16, 17, 21)
"""Of small specs that have every construct of the many."""


def contexts() -> list[Context]:
    """Return the random specs that diagrams can follow."""
    found = []
    for seed in SEEDS:
        made = compiled(model_of(small_spec_of(seed)))
        analysis = Analysis(made, Reference(made.model), lambda what: None)
        try:
            assert analysis.space
        except TooLarge:
            continue
        found.append(Context(made, analysis))
    return found


def test_few_have_every_construct() -> None:
    few, many = ([(model_of(small_spec_of(seed)),) for seed in seeds] for seeds in (SEEDS, MANY))
    assert not seldom(few, many, 1)


def test_what_short_runs_show_can_happen() -> None:
    """A mark that is shown is passed by some run of the loop, and a rule that makes a difference is not redundant."""
    seen: Counter[tuple[str, bool]] = Counter()
    for context in contexts():
        for name in dict.fromkeys(rule.name for rule in context.model.rules):
            mark, shown = ("rule", name), context.nearby.shown(name)
            passed = context.analysis.passes(mark)
            assert passed or mark not in shown.marks, name
            seen["rule", mark in shown.marks] += passed
            seen["never", passed] += 1
            if shown.contrast is not None:
                assert context.comparison.changes(context.model.rules_named(name)), name
                seen["contrast", True] += 1
        for label, _ in context.model.demands.values():
            passed = context.analysis.passes(label)
            assert passed or not context.shows(label), label
            seen["demand", context.shows(label)] += passed
            seen["never", passed] += 1
    assert seen["rule", True] > seen["rule", False]
    assert seen["demand", True] > seen["demand", False]
    assert seen["contrast", True] > 10
    assert seen["never", False] > 50, "there is little that short runs could wrongly show"
