"""Is a guard, or a remedy of a rule, ever the one that decides?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import WITNESS, Check, Context, Question, Subjects
from exover.loop.claim import Claim
from exover.model.model import Model
from exover.model.property import Passed, Properties, some_finally

IFF = "a guard or remedy is never the one that decides (a `wait` that a `fail` always beats, a `kill` never applied)"
HOLDS = "some step of a run is decided by it"
NEVER, UNCALLED = "no decision of any run is made by it", "nothing calls for it, or another demand always goes before"
VIOLATED = f"{NEVER}: {UNCALLED}"


def decide(context: Context, question: Question) -> Finding:
    """Answer for a guard or remedy: holds iff it decides in some reachable step.

    A guard, a `wait` and a `reject` decide where their demand is the one that is taken, for a newcomer or a waiting
    request. A `kill r` decides where a slot of r is killed, or a waiting r is given up, for its rule.
    """
    label, _ = context.model.demands[question.subject]
    if context.shows(label):
        return question.holds(HOLDS, WITNESS)
    if context.analysis.passes(label):
        return question.holds(HOLDS)
    return question.violated(VIOLATED)


def subjects(model: Model, _: Properties) -> Subjects:
    """Yield the guards and remedies."""
    for subject, (_label, location) in model.demands.items():
        yield subject, location


def claim(model: Model, _: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    return Claim("idle-guard", subject, some_finally(Passed(model.demands[subject][0])))


CHECK = Check("idle-guard", "note", IFF, subjects, decide, claim, HOLDS, VIOLATED)
