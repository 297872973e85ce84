"""The numbers of the reasons that answers give."""

from exover.model.decision import BUSY, Reason
from exover.model.model import Model


def reasons(model: Model) -> tuple[Reason, ...]:
    """Return every reason that a decision or a violation can have, without duplicates: `busy` first, then guards, rules
    and consumptions in the order of the text, then launch rules.

    The tables hold indices into it. A `consumes` clause has the name of its resource and its own text.
    """
    placed = [(guard.place, Reason(guard.name, guard.because)) for r in model.requests for guard in r.guards]
    placed += [(rule.place, Reason(rule.name, rule.because)) for rule in model.rules]
    for request in model.requests:
        for clause in request.consumptions:
            placed.append((clause.place, Reason(clause.resource, model.text(clause))))
    ordered = [reason for _, reason in sorted(placed, key=lambda item: item[0])]
    launches = [Reason(launch.name, launch.because) for launch in model.launches]
    return tuple(dict.fromkeys([BUSY, *ordered, *launches]))
