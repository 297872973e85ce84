"""What the decision diagrams say of a claim's formula, whatever the check itself finds."""

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


def judged(made: Compiled, properties: Properties, claim: Claim) -> bool:
    """Return whether the formula of a claim is true at the start."""
    assert claim.formula is not None
    form: Form = "ltl" if claim.linear else "ctl"
    said = Property("said", None, form, claim.formula, None, NOWHERE)
    temporal = analysed(made, replace(properties, properties=(said,), fair=claim.fair)).temporal
    if claim.coherent and (temporal.stranded() is not None or temporal.is_unfair()):
        return False
    return temporal.answer(said).holds
