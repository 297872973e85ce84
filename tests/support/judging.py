"""What the decision diagrams say of the formulas of claims, whatever the checks themselves find."""

from collections.abc import Sequence
from dataclasses import replace

from exover.engines.bdd.analysis import Analysis
from exover.loop.claim import Claim
from exover.model.model import NOWHERE
from exover.model.property import Form, Properties, Property
from exover.model.semantics import Reference
from exover.ocrd.compile import Compiled


def analysed(made: Compiled, properties: Properties) -> Analysis:
    """Return the analysis of a compiled spec."""
    return Analysis(made, Reference(made.model), lambda what: None, properties)


def judged(made: Compiled, properties: Properties, claims: Sequence[Claim]) -> list[bool]:
    """Return of each claim whether its formula is true at the start; those about the same runs are of one loop."""
    said = [_said(claim) for claim in claims]
    found: dict[int, bool] = {}
    for fair in (False, True):
        alike = [number for number, claim in enumerate(claims) if claim.fair == fair]
        asked = replace(properties, properties=tuple(said[number] for number in alike), fair=fair)
        temporal = analysed(made, asked).temporal
        for number in alike:
            incoherent = claims[number].coherent and (temporal.stranded() is not None or temporal.is_unfair())
            found[number] = not incoherent and temporal.answer(said[number]).holds
    return [found[number] for number in range(len(claims))]


def _said(claim: Claim) -> Property:
    assert claim.formula is not None
    form: Form = "ltl" if claim.linear else "ctl"
    return Property("said", None, form, claim.formula, None, NOWHERE)
