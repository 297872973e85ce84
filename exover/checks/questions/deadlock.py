"""Can a request that waits always come to an end of its wait?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import NEVER_WAITS, TABLES, Check, Context, Question, requests
from exover.engines.bdd.analysis import asks, is_abort
from exover.loop.claim import Claim, always_possible
from exover.model.expression import Status
from exover.model.model import Model
from exover.model.property import Atom, Conjunction, Disjunction, Happened, Negation, Passed, Properties

IFF = (
    "from every reachable state where it waits, some path without any abort and without a further ask of it ends "
    "the wait"
)
HOLDS = "from every state in which it waits some run ends the wait"
VIOLATED = "the request waits, and no report, observation or other request launches it or leaves its place empty"


def decide(context: Context, question: Question) -> Finding:
    """Answer for a request: holds iff `IFF`.

    A path has no abort and no further ask of the request; the wait ends when the place is empty, or by a launch.
    """
    analysis, name = context.analysis, question.subject
    if not context.may_wait(name):
        return question.holds(NEVER_WAITS, TABLES)
    if analysis.ends_waiting(name):
        return question.holds("observations and reports can always end its wait", "wait-for analysis")
    waiting = analysis.meaning.waiting(name)
    trace = analysis.always_possible(
        waiting, ~waiting, ("launch", name), lambda event: not is_abort(event) and not asks(event, name)
    )
    if trace is None:
        return question.holds(HOLDS)
    return question.violated(VIOLATED, trace)


def claim(_: Model, __: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    waiting = Atom(Status("waiting", subject))
    ended = Disjunction((Negation(waiting), Passed(("launch", subject))))
    others = Conjunction((Negation(Passed(("abort",))), Negation(Happened("asked", subject))))
    return Claim("deadlock", subject, always_possible(waiting, ended, others))


CHECK = Check("deadlock", "error", IFF, requests, decide, claim, HOLDS, VIOLATED)
