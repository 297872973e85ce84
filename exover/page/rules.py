"""The items that an answer can name, with their texts in the spec: rules, guards, resources and launch rules."""

from collections.abc import Iterator, Mapping

from exover.dataclass import dataclass
from exover.model.model import Location, Model


@dataclass(frozen=True, slots=True)
class RuleText:
    """A rule: name, kind, request (of a guard, launch rule or rule on a slot), text in the spec, reason, location."""

    name: str
    kind: str
    request: str | None
    written: str | None
    because: str | None
    location: Location


def rules(model: Model, written: Mapping[Location, str]) -> tuple[RuleText, ...]:
    """Return the rules of a model in the order of the text, launch rules last; of those of one name, as the pairs of a
    mutex, the first. `written`: the texts by location."""
    found = sorted(_placed(model, written), key=lambda item: item[0])
    launches = [
        RuleText(each.name, "launch", each.request, written.get(each.location), each.because, each.location)
        for each in model.launches
    ]
    named = {rule.name: rule for rule in reversed([*(rule for _, rule in found), *launches])}
    return tuple(reversed(named.values()))


def _placed(model: Model, written: Mapping[Location, str]) -> Iterator[tuple[int, RuleText]]:
    """Yield guards, consumables and rules, each with its place in the text; a consumable has that of each use."""
    for request in model.requests:
        for guard in request.guards:
            text = written.get(guard.location)
            yield guard.place, RuleText(guard.name, guard.kind, request.name, text, guard.because, guard.location)
        for clause in request.consumptions:
            stock = model.resource[clause.resource]
            text = written.get(stock.location)
            yield clause.place, RuleText(stock.name, "consumable", None, text, stock.because, stock.location)
    for rule in model.rules:
        text = written.get(rule.location)
        yield rule.place, RuleText(rule.name, rule.kind, rule.slot_of, text, rule.because, rule.location)
