"""Does a rule, guard, resource or launch ever speak?"""

from collections.abc import Mapping
from typing import Literal

from exover.checks.finding import Finding, FindingKey
from exover.checks.questions.question import WITNESS, Check, Context, Question, Subjects, launches
from exover.loop.claim import Claim, Verdict
from exover.model.model import Model
from exover.model.property import Atom, Broken, Disjunction, Passed, Properties, SomeNext, some_finally

IFF = (
    "some reachable step has an action that names it, for a launch rule as `rule` or as `launch_rule`, or, for a "
    "launch rule, its condition holds in some reachable moment (else it is dead, always shadowed by another, or "
    "only keeps what waits waiting)"
)
HOLDS = "some run has an action that names it, or makes its condition true"
VIOLATED = "no answer names it"
NEVER, UNCALLED = "it never acts", "it is never called for, or other rules always decide in its place"
SILENT = f"{VIOLATED}, but it decides without a word: it keeps what waits waiting"
ADVICE, CAREFUL = "correct it or take it out", "correct it, or take it out if `idle-guard` finds it idle"
Standing = Literal["idle", "silent", "open"]


def decide(context: Context, question: Question) -> Finding:
    """Answer for a rule, guard, resource or launch: holds iff `IFF`.

    A launch rule is also used if its condition holds in some reachable moment.
    """
    analysis, name = context.analysis, question.subject
    if context.shows(("rule", name)):
        return question.holds(HOLDS, WITNESS)
    broken = analysis.broken(context.model.rules_named(name))
    due = analysis.space.none
    for launch in context.model.launches:
        if launch.name == name:
            due |= analysis.meaning.truth(launch.condition)
    if analysis.passes(("rule", name)) or analysis.reaches_into(broken) or analysis.reaches(due):
        return question.holds(HOLDS)
    return question.violated(VIOLATED)


def subjects(model: Model, properties: Properties) -> Subjects:
    """Yield everything that an action can name, in the order of the text; consumables and launch rules last."""
    found = [(guard.place, guard.name, guard.location) for r in model.requests for guard in r.guards]
    found += [(rule.place, rule.name, rule.location) for rule in model.rules]
    yield from {name: location for _, name, location in sorted(found, key=lambda item: item[0])}.items()
    yield from ((resource.name, resource.location) for resource in model.resources if resource.consumable)
    yield from launches(model, properties)


def claim(model: Model, _: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    broken = Disjunction(tuple(Broken(rule, once_stopped=True) for rule in model.rules_named(subject)))
    due = tuple(Atom(launch.condition) for launch in model.launches if launch.name == subject)
    named = Disjunction((Passed(("rule", subject)), *due))
    return Claim("rule-use", subject, Disjunction((some_finally(named), SomeNext(some_finally(broken)))))


def standing(model: Model, verdicts: Mapping[FindingKey, Verdict], name: str) -> Standing:
    """Return whether something that no answer names is idle or decides silently; `open` if `idle-guard` does not tell.

    It decides silently iff all that it does is to keep waiting requests waiting. `verdicts`: of all findings.
    """
    subjects = (subject for subject, (label, _) in model.demands.items() if label[1] == name)
    said = {verdicts.get(("idle-guard", subject)) for subject in subjects}
    return "silent" if "holds" in said else "idle" if said <= {"violated"} else "open"


CHECK = Check("rule-use", "warning", IFF, subjects, decide, claim, HOLDS, VIOLATED)
