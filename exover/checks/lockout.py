"""Can a request always be launched again?"""

from exover.checks.finding import Finding
from exover.checks.question import Check, Context, Question, requests
from exover.verify.bdd.analysis import is_abort


def decide(context: Context, question: Question) -> Finding:
    """Answer for a request: holds iff from every reachable state some path without abort launches it."""
    analysis = context.analysis
    launch = ("launch", question.subject)
    able = analysis.possible(analysis.space.none, launch, lambda event: not is_abort(event))
    locked = analysis.reached.states & ~able
    if locked == analysis.space.none:
        return question.holds("from every state some run launches the request")
    message = "from here on nothing can bring it about that the request is launched"
    return question.violated(message, analysis.run_to(locked))


CHECK = Check("lockout", "warning", requests, decide)
