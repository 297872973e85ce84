"""Is a required launch under way whenever it is required?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import Check, Context, Question, launches, unreached
from exover.loop.claim import Claim, after_every_step
from exover.model.conditions import fulfilled
from exover.model.model import Launch, Model
from exover.model.property import Atom, Properties, implies

IFF = "after every reachable step in which its condition holds, its request is active or waiting with those arguments"
HOLDS = "whenever the condition holds, the request is active or waits"
VIOLATED = "a step ends with the condition true and the request neither active nor waiting"


def decide(context: Context, question: Question) -> Finding:
    """Answer for a launch rule: holds iff `IFF`."""
    analysis = context.analysis
    launch = _named(context.model, question.subject)
    due = analysis.meaning.truth(launch.condition) & ~analysis.meaning.truth(fulfilled(context.model, launch))
    return unreached(context, question, due, HOLDS, VIOLATED)


def claim(model: Model, _: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    launch = _named(model, subject)
    held = implies(Atom(launch.condition), Atom(fulfilled(model, launch)))
    return Claim("obligation", subject, after_every_step(held))


def _named(model: Model, name: str) -> Launch:
    (launch,) = (launch for launch in model.launches if launch.name == name)
    return launch


CHECK = Check("obligation", "error", IFF, launches, decide, claim, HOLDS, VIOLATED)
