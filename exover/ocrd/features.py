"""Features: the conditions on arguments by which counters count slots and waiting places, and their predicates."""

from collections.abc import Mapping, Sequence

from exover.model.conditions import comparisons
from exover.model.expression import Cond, Reading
from exover.model.model import Consumption, Model, Share
from exover.ocrd.entries import Entries
from exover.ocrd.roots import Roots
from exover.ocrd.vector import HasPast, InPlace, PlaceValue, Slots, SlotValue

Feature = tuple[Cond | None, int | None, str | None]
"""What a counter counts: a condition on arguments, a slot (None: all), the parameter that is added (None: 1).

A parameter is added of one slot, or, where there is none, of the waiting place alone.
"""


def plant_features(model: Model, roots: Roots) -> dict[str, list[Feature]]:
    """Plant the predicates that entries and amounts need; return for each request the features of its entries."""
    tested = Entries(roots.questions.numbers)
    tested.needed_by(roots.forest, range(len(roots.forest.nodes)))
    counted: dict[str, dict[Feature, None]] = {request.name: {} for request in model.requests}
    for quantity in tested.quantities():
        match quantity:
            case Slots(request, slot, where, _):
                counted[request][where, slot, None] = None
            case InPlace(request, where, _):
                counted[request][where, None, None] = None
            case SlotValue(request, slot, param):
                counted[request][None, slot, param] = None
            case PlaceValue(request, param):
                counted[request][None, None, param] = None
            case HasPast(request, where):
                roots.predicate(request, where)
            case _:
                pass
    for each in model.requests:
        clauses: tuple[Share | Consumption, ...] = (*each.consumptions, *each.productions)
        conds = [where for where, _, _ in counted[each.name]] + [clause.when for clause in clauses]
        for where in conds:
            roots.predicate(each.name, where)
    return {name: list(features) for name, features in counted.items()}


def readers(counted: Mapping[str, Sequence[Feature]]) -> dict[str, list[str]]:
    """Return for each real poster the requests whose counters depend on it."""
    found: dict[str, dict[str, None]] = {}
    for name, features in counted.items():
        for _, compare in (pair for where, _, _ in features if where for pair in comparisons(where, name)):
            for side in (compare.left, compare.right):
                if isinstance(side, Reading):
                    found.setdefault(side.name, {})[name] = None
    return {poster: list(names) for poster, names in found.items()}
