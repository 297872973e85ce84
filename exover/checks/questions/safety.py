"""Does a rule hold after every step, or is every way to restore it under way?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import Check, Context, Question, rules, unbroken
from exover.engines.bdd.manager import Set
from exover.loop.claim import Claim, after_every_step
from exover.model.model import Model, Rule
from exover.model.property import Broken, Conjunction, Formula, Negation, Properties

IFF = "after every reachable step: the rule's F is false, or false once the stopping slots have ended"
HOLDS = "after every step the rule holds, or is about to once what is stopping has ended"
VIOLATED = "a step ends with the rule broken"
STRICT = ("mutex", "over", "limit", "interrupts", "resource")
"""Kinds of rules that never hold at all, stopping slots included (docs/language.md section 6)."""


def decide(context: Context, question: Question) -> Finding:
    """Answer for a rule: holds iff `IFF`.

    Of a mutex, a limit and a renewable resource F must be false outright.
    """
    return unbroken(context, question, lambda rule: _unsafe(context, rule), HOLDS, VIOLATED)


def _unsafe(context: Context, rule: Rule) -> Set:
    meaning = context.analysis.meaning
    broken = meaning.rule(rule, once_stopped=False)
    return broken if rule.kind in STRICT else broken & meaning.rule(rule, once_stopped=True)


def claim(model: Model, _: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    safe = Conjunction(tuple(Negation(_unsafe_moment(rule)) for rule in model.rules_named(subject)))
    return Claim("safety", subject, after_every_step(safe))


def _unsafe_moment(rule: Rule) -> Formula:
    broken = Broken(rule, once_stopped=False)
    return broken if rule.kind in STRICT else Conjunction((broken, Broken(rule, once_stopped=True)))


CHECK = Check("safety", "error", IFF, rules, decide, claim, HOLDS, VIOLATED)
