"""Can a request be launched at all?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import WITNESS, Check, Context, Question, requests
from exover.loop.claim import Claim
from exover.model.event import Ask, Launched
from exover.model.model import Model
from exover.model.property import Passed, Properties, some_finally
from exover.model.trace import Answers, Trace, run

IFF = "some reachable step launches the request"
HOLDS = "some run launches the request"
VIOLATED = "no run launches the request"


def decide(context: Context, question: Question) -> Finding:
    """Answer for a request: holds iff `IFF`."""
    name = question.subject
    trace = _at_once(context, name)
    if trace is None:
        trace = context.analysis.run_past(("launch", name), lambda actions: _launches(actions, name))
    if trace is None:
        return question.violated(VIOLATED)
    return question.holds(f"launched at step {len(trace.moments)} of a run", WITNESS, trace)


def _launches(actions: Answers, name: str) -> bool:
    return any(isinstance(action, Launched) and action.request == name for action in actions)


def _at_once(context: Context, name: str) -> Trace | None:
    """Return a run of one ask that launches the request; None if there is none, or if there are assumptions."""
    if context.properties.assumptions:
        return None
    loop = context.analysis.loop
    for cell in loop.arguments[loop.request_number[name]].cells:
        trace = run(context.reference, (Ask(name, cell.args),))
        if _launches(trace.moments[0].actions, name):
            return trace
    return None


def claim(_: Model, __: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    return Claim("reachability", subject, some_finally(Passed(("launch", subject))))


CHECK = Check("reachability", "error", IFF, requests, decide, claim, HOLDS, VIOLATED)
