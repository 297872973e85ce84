"""Which requests may come to wait, as far as the rules tell by their form."""

from exover.model.model import Kill, KillSlot, Model, Request, Rule, Wait
from exover.model.reads import in_question


def may_wait(model: Model) -> frozenset[str]:
    """Return the requests that can come to their waiting places."""
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
    """Return whether a request may come to wait for a rule: it is told to, or others are ended for it, such as another
    slot of its own.
    """
    beside_its_own = request.instances > 1 or request.interrupts_self
    return Wait() in rule.remedies or any(name != request.name or beside_its_own for name in killed(rule))


def killed(rule: Rule) -> frozenset[str]:
    """Return the requests that a remedy of the rule ends."""
    found: set[str] = set()
    for remedy in rule.remedies:
        match remedy:
            case Kill(requests):
                found |= set(requests)
            case KillSlot() if rule.slot_of:
                found.add(rule.slot_of)
            case _:
                pass
    return frozenset(found)
