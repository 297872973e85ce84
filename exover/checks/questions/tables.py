"""Do the very bytes that are emitted decide as the rules say?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import Check, Context, Question, Subjects
from exover.equivalence.record_equivalence import kinds_of_events
from exover.loop.claim import Claim
from exover.model.model import Model
from exover.model.property import Properties

IFF = (
    "the emitted tables, decoded from their bytes, take exactly the decisions of the rules for every state and argument"
)
METHOD = "all states"
HOLDS = "the decoded tables do what the rules say, in every state and for all arguments"
VIOLATED = "the decoded tables do otherwise than the rules say"


def decide(context: Context, question: Question) -> Finding:
    """Answer for a kind of event: holds iff `IFF`.

    Compared are, for an ask, the decision; for a report and an observation, their updates; and for each of them the
    counts of slots, the rules to restore, the required launches and the latches to set afterwards.
    """
    kind, name = question.subject.split(" ", 1)
    for what in context.tables.different(kind, name):
        return question.violated(f"{VIOLATED}; {what}", method=METHOD)
    return question.holds(HOLDS, METHOD)


def subjects(model: Model, _: Properties) -> Subjects:
    """Yield the kinds of events."""
    yield from ((f"{kind} {name}", location) for kind, name, location in kinds_of_events(model))


def claim(_: Model, __: Properties, subject: str) -> Claim:
    """Return a claim without a formula: the check is about the bytes, not about runs."""
    return Claim("tables", subject, None)


CHECK = Check("tables", "error", IFF, subjects, decide, claim, HOLDS, VIOLATED)
