"""Is a required launch under way whenever it is required?"""

from exover.checks.finding import Finding
from exover.checks.question import Check, Context, Question, launches
from exover.model.expression import Or, Status
from exover.ocrd.vector import same_arguments


def decide(context: Context, question: Question) -> Finding:
    """Answer for a launch rule: holds iff after every reachable step in which its condition holds, its request is
    active or waiting with those arguments.
    """
    analysis = context.analysis
    (launch,) = (launch for launch in context.model.launches if launch.name == question.subject)
    same = same_arguments(context.model.request[launch.request], launch)
    held = Or((Status("active", launch.request, same), Status("waiting", launch.request, same)))
    due = analysis.meaning.truth(launch.condition) & ~analysis.meaning.truth(held)
    trace = analysis.run_into(due)
    if trace is None:
        return question.holds("whenever the condition holds, the request is active or waits")
    return question.violated("a step ends with the condition true and the request neither active nor waiting", trace)


CHECK = Check("obligation", "error", launches, decide)
