"""Is what the properties file says true of the checked system?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import WITNESS, Check, Context, Question, Subjects
from exover.loop.claim import CONTRADICTION, UNFAIR, Claim
from exover.model.model import Model
from exover.model.property import TRUE, Form, Properties, Property
from exover.model.trace import Trace

IFF = "the property of the properties file"
HOLDS = "it is true of every run that the assumptions leave"
VIOLATED = "it is not true of the runs that the assumptions leave"
VACUOUS = "it holds, but only because its premise is never true"
ASSUMPTIONS = "assumptions"

BROKEN: dict[Form, str] = {
    "never": "a run comes to a moment that it forbids",
    "always": "a run comes to a moment in which it is false",
    "possible": "no run comes to a moment in which it is true",
    "always possible": "a run comes to where it can never be true again",
    "from possible": "a run comes to where the premise is true, and from there no run comes to the conclusion",
    "leads to": "a run comes to where the premise is true, and from there on the conclusion never is",
    "precedes": "a run comes to the second before the first",
    "until": "a run gives up the first before the second, or never comes to the second",
    "ctl": "the formula is false at the start",
    "ltl": "the formula is false of a run",
}


def is_contradiction(message: str) -> bool:
    """Return whether a message says where the assumptions contradict each other."""
    return message.startswith((CONTRADICTION, UNFAIR))


def decide(context: Context, question: Question) -> Finding:
    """Answer for a property: holds iff its formula is true at the start, of the runs that the assumptions leave.

    It is violated as well if the assumptions contradict each other: if some reachable state has no step left, or if no
    run from the start is fair.
    """
    temporal = context.analysis.temporal
    stranded = temporal.stranded()
    if stranded is not None:
        return question.violated(CONTRADICTION, stranded)
    if temporal.is_unfair():
        return question.violated(UNFAIR, Trace(()))
    if _of_assumptions(context.properties, question.subject):
        return question.holds("every state has a step that the assumptions allow")
    prop = named(context.properties, question.subject)
    answer = temporal.answer(prop)
    if not answer.holds:
        return question.violated(BROKEN[prop.form], answer.trace)
    if prop.premise is not None and not temporal.possible(prop.premise):
        return question.holds(VACUOUS)
    if answer.trace is not None:
        return question.holds(f"shown by a run of {len(answer.trace.moments)} steps", WITNESS, answer.trace)
    return question.holds(HOLDS)


def named(properties: Properties, name: str) -> Property:
    """Return the property of this name."""
    (found,) = (each for each in properties.properties if each.name == name)
    return found


def subjects(_: Model, properties: Properties) -> Subjects:
    """Yield the properties; if there are none, the assumptions, which may contradict each other."""
    yield from ((each.name, each.location) for each in properties.properties)
    if not properties.properties:
        yield from coherence(_, properties)


def coherence(_: Model, properties: Properties) -> Subjects:
    """Yield the assumptions as one subject, if there are any; its question is whether they contradict each other.

    Fair reports alone contradict nothing, since every active slot can be reported.
    """
    places = [*(each.location for each in properties.assumptions), *([properties.fair_at] if properties.fair else [])]
    if places:
        yield ASSUMPTIONS, places[0]


def _of_assumptions(properties: Properties, subject: str) -> bool:
    """Return whether a subject stands for the assumptions; a property of that name takes precedence."""
    return subject == ASSUMPTIONS and all(each.name != ASSUMPTIONS for each in properties.properties)


def claim(_: Model, properties: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    coherent = bool(properties.assumptions)
    if _of_assumptions(properties, subject):
        return Claim("property", subject, TRUE, fair=properties.fair, coherent=coherent)
    prop = named(properties, subject)
    return Claim("property", subject, prop.formula, prop.form == "ltl", properties.fair, coherent)


CHECK = Check("property", "error", IFF, subjects, decide, claim, HOLDS, VIOLATED)
