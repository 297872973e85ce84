"""Every condition of a model, and the comparisons in conditions."""

from collections.abc import Iterator

from exover.model.expression import And, Compare, Cond, Const, Or, Param, Past, Status, atoms
from exover.model.model import Consumption, Launch, Model, Request, Share


def conditions(model: Model) -> Iterator[tuple[str | None, Cond]]:
    """Yield every condition of a model with the request whose parameters it reads, None if it reads none."""
    for request in model.requests:
        for guard in request.guards:
            yield request.name, guard.condition
        clauses: tuple[Share | Consumption, ...] = (*request.shares, *request.consumptions, *request.productions)
        yield from ((request.name, clause.when) for clause in clauses if clause.when)
    for rule in model.rules:
        yield rule.slot_of, rule.condition
    for latch in model.latches:
        yield None, latch.condition
    for launch in model.launches:
        yield None, launch.condition
        yield launch.request, _same_arguments(model.request[launch.request], launch)


def comparisons(cond: Cond, subject: str | None) -> Iterator[tuple[str | None, Compare]]:
    """Yield the comparisons of a condition, inside `where` too, each with the request whose parameters it reads."""
    for atom in atoms(cond):
        match atom:
            case Compare():
                yield subject, atom
            case Status(_, request, where) | Past(request, where) if where:
                yield from comparisons(where, request)
            case _:
                pass


def fulfilled(model: Model, launch: Launch) -> Cond:
    """Return the condition that the request of a launch rule is active or waiting with the rule's arguments."""
    same = _same_arguments(model.request[launch.request], launch)
    return Or((Status("active", launch.request, same), Status("waiting", launch.request, same)))


def _same_arguments(request: Request, launch: Launch) -> Cond:
    """Return the condition that the arguments of `request` equal those of the launch rule."""
    pairs = zip(request.params, launch.args, strict=True)
    return And(tuple(Compare("==", Param(parameter.name), Const(value)) for parameter, value in pairs))
