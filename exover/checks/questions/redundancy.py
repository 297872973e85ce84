"""Does a rule change anything that the others do not?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import WITNESS, Check, Context, Question, rules
from exover.loop.claim import Claim
from exover.model.model import Model
from exover.model.property import Properties
from exover.model.trace import run

IFF = "removing the rule changes some reachable decision"
HOLDS = "without the rule some run is decided otherwise"
VIOLATED = "the rule can be taken out: no decision of any run changes but for the rule it names"


def decide(context: Context, question: Question) -> Finding:
    """Answer for a rule: holds iff in some reachable step something else is done without it.

    The rules that an answer names do not count: a request that is rejected for another rule is rejected as well.
    """
    named = context.model.rules_named(question.subject)
    events = None if context.properties.assumptions else context.nearby.shown(question.subject).contrast
    if events is not None:
        message = f"without the rule step {len(events)} of a run is decided otherwise"
        return question.holds(message, WITNESS, run(context.reference, events))
    if context.comparison.changes(named):
        return question.holds(HOLDS)
    return question.violated(VIOLATED)


def claim(_: Model, __: Properties, subject: str) -> Claim:
    """Return a claim without a formula: two loops are compared, and a formula is about one."""
    return Claim("redundancy", subject, None)


CHECK = Check("redundancy", "note", IFF, rules, decide, claim, HOLDS, VIOLATED)
