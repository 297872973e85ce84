"""The reasons that answers give, numbered."""

from exover.model.decision import BUSY, Reason
from exover.model.model import Model


def reasons(model: Model) -> tuple[Reason, ...]:
    """Return every reason a decision or a violation can have, `busy` first, then in the order of the text, each once.

    The tables hold indices of this list. A clause that consumes has its resource's name and its own text.
    """
    placed = [(guard.place, Reason(guard.name, guard.because)) for r in model.requests for guard in r.guards]
    placed += [(rule.place, Reason(rule.name, rule.because)) for rule in model.rules]
    for request in model.requests:
        for clause in request.consumptions:
            placed.append((clause.place, Reason(clause.resource, model.text(clause))))
    ordered = [reason for _, reason in sorted(placed, key=lambda item: item[0])]
    launches = [Reason(launch.name, launch.because) for launch in model.launches]
    return tuple(dict.fromkeys([BUSY, *ordered, *launches]))
