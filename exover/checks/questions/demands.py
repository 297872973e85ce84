"""Guards and remedies by name, with the marks of the steps that they decide."""

from collections.abc import Iterator
from typing import assert_never

from exover.model.model import Kill, KillSlot, Location, Model, Reject, Remedy, Wait
from exover.model.property import Label

Demands = dict[str, tuple[Label, Location]]
"""Maps the name of a guard or remedy to the mark of the steps that it decides, and its location."""


def demands(model: Model) -> Demands:
    """Return the guards and the remedies of rules, in the order of the text, then the remedies of consumables.

    The remedies of the rule `drive` are called `drive.reject`, `drive.wait` and, for each request that it kills,
    `drive.kill nd.goto`; rules of the same name share their remedies.
    """
    found: list[tuple[int, str, Label, Location]] = []
    for request in model.requests:
        for guard in request.guards:
            found.append((guard.place, guard.name, (guard.objection, guard.name), guard.location))
    for rule in model.rules:
        for subject, label in _named(rule.name, rule.remedies, rule.slot_of):
            found.append((rule.place, subject, label, rule.location))
    found.sort(key=lambda item: item[0])
    by_name: Demands = {}
    for _, subject, label, location in found:
        by_name.setdefault(subject, (label, location))
    for resource in model.resources:
        if resource.consumable:
            for subject, label in _named(resource.name, resource.remedies, None):
                by_name[subject] = (label, resource.location)
    return by_name


def certain_before(model: Model, label: Label) -> str | None:
    """Return the `reject` or `wait` that stands before a remedy wherever its name is written, else None.

    Both always apply, so that no remedy behind them is taken.
    """
    written = [_named(each.name, each.remedies, each.slot_of) for each in model.rules_named(label[1])]
    written += [_named(each.name, each.remedies, None) for each in model.resources if each.name == label[1]]
    found = set[str | None]()
    for labels in ([each for _, each in remedies] for remedies in written):
        if label in labels:
            before = (each[0] for each in labels[: labels.index(label)] if each[0] != "kill")
            found.add(next(before, None))
    return found.pop() if len(found) == 1 else None


def _named(rule: str, remedies: tuple[Remedy, ...], slot_of: str | None) -> Iterator[tuple[str, Label]]:
    for remedy in remedies:
        match remedy:
            case Reject():
                yield f"{rule}.reject", ("reject", rule)
            case Wait():
                yield f"{rule}.wait", ("wait", rule)
            case Kill(requests):
                yield from ((f"{rule}.kill {request}", ("kill", rule, request)) for request in requests)
            case KillSlot():
                assert slot_of is not None
                yield f"{rule}.kill {slot_of}", ("kill", rule, slot_of)
            case _:
                assert_never(remedy)
