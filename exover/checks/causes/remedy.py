"""Advice for a rule that a step breaks and no remedy restores: the kill that would have restored it."""

from exover.model.model import Kill, Model, Rule
from exover.model.reads import rule_reads, users
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.wording import remedy_text


def advice(reference: Reference, state: State, name: str) -> str:
    """Return, in words, the remedies that would restore the rule in a state in which it is broken."""
    remedies = _rules(reference.model, name)[0].remedies
    known = {request for remedy in remedies if isinstance(remedy, Kill) for request in remedy.requests}
    requests = _killable(reference.model, name)
    for more in (*({request} for request in requests), set(requests)):
        killed = tuple(request for request in requests if request in known | more)
        if not _broken(reference, state.idle(state.running(killed)), name):
            return f"write `by {' or '.join(map(remedy_text, (*remedies, Kill(killed))))}`"
    return "no kill would: let its condition name `active(…)` of what can be ended, or take the rule out"


def _rules(model: Model, name: str) -> list[Rule]:
    return [rule for rule in model.rules if rule.name == name]


def _killable(model: Model, name: str) -> list[str]:
    """Return the requests that a kill of the rule may name: it reads their activity, or a resource that they use."""
    reads = {read for rule in _rules(model, name) for read in rule_reads(rule)}
    active = {read.name for read in reads if read.kind == "active"}
    using = {name for read in reads if read.kind == "used" for name in users(model, read.name)}
    return [request.name for request in model.requests if request.name in active | using]


def _broken(reference: Reference, state: State, name: str) -> bool:
    instances = (each for rule in _rules(reference.model, name) for each in reference.instances(state, rule))
    return any(reference.true(state, each) for each in instances)
