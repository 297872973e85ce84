"""Which requests may come to wait, judged by the form of guards, resources and rules: an over-approximation."""

from typing import assert_never

from exover.model.model import Kill, KillSlot, Model, Reject, Remedy, Request, Rule, Wait
from exover.model.reads import in_question


def may_wait(model: Model) -> frozenset[str]:
    """Return the requests that may come into their waiting places."""
    asked = in_question(model)
    return frozenset(each.name for each in model.requests if _may_wait(model, each, asked[each.name]))


def _may_wait(model: Model, request: Request, rules: tuple[Rule, ...]) -> bool:
    stocks = (remedy for each in request.consumptions for remedy in model.resource[each.resource].remedies)
    return (
        any(guard.kind != "check" for guard in request.guards)
        or Wait() in stocks
        or any(may_wait_for(request, rule) for rule in rules)
    )


def may_wait_for(request: Request, rule: Rule) -> bool:
    """Return whether a request may come to wait for a rule: a remedy is `wait`, or the request may be clearing."""
    return Wait() in rule.remedies or may_clear_for(request, rule)


def may_clear_for(request: Request, rule: Rule) -> bool:
    """Return whether a request may come to be clearing for a rule: a remedy kills slots other than the newcomer's, be
    they of the same request.
    """
    beside_its_own = request.instances > 1 or request.interrupts_self
    return any(name != request.name or beside_its_own for name in killed(rule))


def killed(rule: Rule) -> frozenset[str]:
    """Return the requests that the remedies of the rule kill."""
    return frozenset(name for remedy in rule.remedies for name in killed_requests(remedy, rule))


def killed_requests(remedy: Remedy, rule: Rule) -> tuple[str, ...]:
    """Return the requests that a remedy kills; none if it is no kill."""
    match remedy:
        case Kill(requests):
            return requests
        case KillSlot():
            return (rule.slot_of,) if rule.slot_of else ()
        case Reject() | Wait():
            return ()
        case _:
            assert_never(remedy)
