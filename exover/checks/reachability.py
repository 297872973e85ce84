"""Can a request be launched at all?"""

from exover.checks.finding import Finding
from exover.checks.question import Check, Context, Question, requests
from exover.model.event import Ask, Launched
from exover.model.trace import Trace, run


def decide(context: Context, question: Question) -> Finding:
    """Answer for a request: holds iff some reachable step launches it."""
    analysis, launch = context.analysis, ("launch", question.subject)
    trace = _at_once(context, question.subject)
    if trace is None and launch in analysis.reached.marks:
        trace = analysis.run_to_launch(question.subject)
    if trace is None:
        return question.violated("no run launches the request")
    return question.holds(f"launched at step {len(trace.moments)} of a run", "witness", trace)


def _at_once(context: Context, name: str) -> Trace | None:
    """Return the run of one ask if it launches the request, and no assumption has to be asked whether it may."""
    if context.properties.assumptions:
        return None
    loop = context.analysis.loop
    for cell in loop.arguments[loop.request_number[name]].cells:
        trace = run(context.reference, (Ask(name, cell.args),))
        if any(isinstance(action, Launched) and action.request == name for action in trace.moments[0].actions):
            return trace
    return None


CHECK = Check("reachability", "error", requests, decide)
