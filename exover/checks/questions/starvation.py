"""Does every wait come to an end, if reports come?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import NEVER_WAITS, TABLES, Check, Context, Question, requests
from exover.loop.claim import Claim
from exover.model.expression import Status
from exover.model.model import Model
from exover.model.property import Atom, Conjunction, Negation, Passed, Properties, SomeAlways, some_finally

IFF = "under fair reports, every wait of it ends"
HOLDS = "if every slot is reported again and again, every wait ends"
VIOLATED = "the request waits for ever, though every slot is reported again and again"


def decide(context: Context, question: Question) -> Finding:
    """Answer for a request: holds iff `IFF`.

    It is violated iff there is a run on which every slot is infinitely often idle or reported, and on which one and the
    same request stands in the waiting place for ever: never launched, superseded, rejected or given up.
    """
    if not context.may_wait(question.subject):
        return question.holds(NEVER_WAITS, TABLES)
    trace = context.analysis.temporal.starving(question.subject)
    if trace is None:
        return question.holds(HOLDS)
    return question.violated(VIOLATED, trace)


def claim(_: Model, __: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    stays = Conjunction((Atom(Status("waiting", subject)), Negation(Passed(("left", subject)))))
    return Claim("starvation", subject, Negation(some_finally(SomeAlways(stays))), fair=True)


CHECK = Check("starvation", "warning", IFF, requests, decide, claim, HOLDS, VIOLATED)
