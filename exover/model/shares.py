"""The most that one slot of a request can hold of a resource."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from math import inf, nextafter, prod

from exover.model.evaluate import Scope, applies
from exover.model.expression import Compare, Cond, Const, Param, atoms, operands
from exover.model.model import Model, Parameter, Request
from exover.model.state import resting
from exover.model.types import Bool, Enum, Int, Real, Value

MOST = 1000
"""The number of combinations of arguments that are tried at most."""


def most_held(model: Model, request: Request, resource: str) -> int:
    """Return the most that a slot of the request holds of a resource with any arguments; an upper bound of it if there
    are more than `MOST` combinations to try, or conditions compare parameters with other than constants.
    """
    shares = [each for each in request.shares if each.resource == resource]
    conditions = [each.when for each in shares if each.when is not None]
    whole = sum(each.amount for each in shares)
    if len(shares) < 2 or not conditions or not all(map(_is_plain, conditions)):
        return whole
    values = [tuple(_told_apart(each, conditions)) for each in request.params]
    if prod(map(len, values)) > MOST:
        return whole
    state, found = resting(model), 0
    for args in product(*values):
        scope = Scope(dict(zip((each.name for each in request.params), args, strict=True)))
        found = max(found, sum(each.amount for each in shares if applies(model, state, each.when, scope)))
    return found


def _is_plain(condition: Cond) -> bool:
    """Return whether a condition compares single parameters with constants, and has no other atoms."""
    return all(
        isinstance(each, Compare) and {type(each.left), type(each.right)} in ({Param, Const}, {Const})
        for each in atoms(condition)
    )


def _told_apart(parameter: Parameter, conditions: Sequence[Cond]) -> Iterator[Value]:
    """Return an iterator of values of a parameter, one at least for all that the conditions do not tell apart."""
    constants = dict.fromkeys(_constants(parameter.name, conditions))
    match parameter.type:
        case Bool():
            return iter((False, True) if constants else (False,))
        case Enum(values):
            return iter(values if constants else values[:1])
        case Int(low, high):
            near = (int(each) + by for each in constants for by in (-1, 0, 1))
            return iter(dict.fromkeys(each for each in (low, *near, high) if low <= each <= high))
        case Real(low, high):
            close = (e for each in constants for e in (nextafter(each, -inf), float(each), nextafter(each, inf)))
            return iter(dict.fromkeys(each for each in (low, *close, high) if low <= each <= high))


def _constants(name: str, conditions: Iterable[Cond]) -> Iterator[int | float]:
    """Yield the constants with which a parameter is compared, for a bool or an enum something for each of them."""
    for atom in (each for condition in conditions for each in atoms(condition)):
        if isinstance(atom, Compare) and Param(name) in operands(atom):
            constant = atom.right if isinstance(atom.right, Const) else atom.left
            assert isinstance(constant, Const), "a plain condition"
            yield constant.value if isinstance(constant.value, int | float) else 0
