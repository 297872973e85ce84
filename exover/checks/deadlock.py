"""Can a request that waits always come to an end of its wait?"""

from exover.checks.finding import Finding
from exover.checks.question import Check, Context, Question, requests
from exover.verify.bdd.analysis import asks, is_abort


def decide(context: Context, question: Question) -> Finding:
    """Answer for a request: holds iff from every reachable state where it waits, some path ends the wait.

    A path has no abort and no further ask of the request; the wait ends when the place is empty, or by a launch.
    """
    analysis, name = context.analysis, question.subject
    if not analysis.loop.may_wait[analysis.loop.request_number[name]]:
        return question.holds("no decision of the tables lets the request wait", "tables")
    waiting = analysis.meaning.waiting(name) & analysis.reached.states
    if waiting == analysis.space.none:
        return question.holds("the request never waits")
    free = analysis.reached.states & ~waiting
    able = analysis.possible(free, ("launch", name), lambda event: not is_abort(event) and not asks(event, name))
    stuck = waiting & ~able
    if stuck == analysis.space.none:
        return question.holds("from every state in which it waits some run ends the wait")
    message = "the request waits, and no report, observation or other request can end that"
    return question.violated(message, analysis.run_to(stuck))


CHECK = Check("deadlock", "error", requests, decide)
