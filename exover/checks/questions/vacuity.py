"""Can the premise of a property be true at all?"""

from exover.checks.finding import Finding
from exover.checks.questions.property import named
from exover.checks.questions.question import Check, Context, Question, Subjects
from exover.loop.claim import Claim
from exover.model.model import Model
from exover.model.property import Properties, some_finally

IFF = "its premise can be true in some reachable step"
HOLDS = "its premise is true in some moment of a run"
VIOLATED = "its premise is never true: the property says nothing"


def decide(context: Context, question: Question) -> Finding:
    """Answer for a property with a premise: holds iff `IFF`."""
    premise = named(context.properties, question.subject).premise
    if premise is None or context.analysis.temporal.possible(premise):
        return question.holds(HOLDS)
    return question.violated(VIOLATED)


def subjects(_: Model, properties: Properties) -> Subjects:
    """Yield the properties that have a premise."""
    yield from ((each.name, each.location) for each in properties.properties if each.premise is not None)


def claim(_: Model, properties: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    premise = named(properties, subject).premise
    assert premise is not None
    return Claim("vacuity", subject, some_finally(premise), fair=properties.fair)


CHECK = Check("vacuity", "warning", IFF, subjects, decide, claim, HOLDS, VIOLATED)
