"""Can a request always be launched again?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import Check, Context, Question, requests
from exover.engines.bdd.analysis import is_abort
from exover.loop.claim import Claim, always_possible
from exover.model.model import Model
from exover.model.property import TRUE, Negation, Passed, Properties

IFF = "from every reachable state some path without abort leads to a launch of it"
HOLDS = "from every state some run launches the request"
VIOLATED = "from here on nothing can bring it about that the request is launched"


def decide(context: Context, question: Question) -> Finding:
    """Answer for a request: holds iff `IFF`."""
    analysis = context.analysis
    space, launch = analysis.space, ("launch", question.subject)
    trace = analysis.always_possible(space.all, space.none, launch, lambda event: not is_abort(event))
    if trace is None:
        return question.holds(HOLDS)
    return question.violated(VIOLATED, trace)


def claim(_: Model, __: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    return Claim("lockout", subject, always_possible(TRUE, Passed(("launch", subject)), Negation(Passed(("abort",)))))


CHECK = Check("lockout", "warning", IFF, requests, decide, claim, HOLDS, VIOLATED)
