"""Two versions of a spec, OLD and NEW, and which requests, variables and consumables correspond to each other."""

from collections.abc import Iterator, Mapping
from dataclasses import field
from functools import cached_property

from exover.dataclass import dataclass
from exover.model.model import Model, Parameter, Request, Variable
from exover.model.types import Bool, Enum, Int, Real, Type, contains


@dataclass(frozen=True)
class Versions:
    """Two models; `renamed` maps the names of requests in OLD to other names in NEW."""

    old: Model
    new: Model
    renamed: Mapping[str, str] = field(default_factory=dict)

    @property
    def models(self) -> tuple[Model, Model]:
        """OLD and NEW."""
        return self.old, self.new

    def called(self, request: str) -> str:
        """Return the name in NEW of a request of OLD, whether NEW has it or not."""
        return self.renamed.get(request, request)

    @cached_property
    def requests(self) -> tuple[tuple[Request, Request], ...]:
        """The requests that both have, in the order of NEW."""
        mine = {self.called(request.name): request for request in self.old.requests}
        return tuple((mine[request.name], request) for request in self.new.requests if request.name in mine)

    @cached_property
    def was_called(self) -> Mapping[str, str]:
        """The name in OLD for each name in NEW, of the requests that both have."""
        return {new.name: old.name for old, new in self.requests}

    @cached_property
    def variables(self) -> tuple[tuple[Variable, Variable], ...]:
        """The posters and states of one name in both, in the order of NEW."""
        known = self.old.variable
        return tuple((known[each.name], each) for each in self.new.variables if each.name in known)

    def alone(self, side: int) -> tuple[str, ...]:
        """Return the requests, posters and consumables that only OLD (side 0) or only NEW (1) has, in this order."""
        mine, other = (self.old, self.new)[:: 1 if side == 0 else -1]
        both = {pair[side].name for pair in self.requests}
        posters = [each.name for each in mine.variables if each.kind == "poster" and each.name not in other.variable]
        stocks = [name for name, each in mine.resource.items() if each.consumable and not _is_stock(other, name)]
        return (*(request.name for request in mine.requests if request.name not in both), *posters, *stocks)

    # ---- what cannot be compared ----

    def clashes(self) -> Iterator[str]:
        """Yield the reasons why the two cannot be compared, none if they can be."""
        if not self.requests:
            yield "they have no request in common; --rename OLD=NEW says which request is which"
        for old, new in self.requests:
            for what, mine, its in (("parameter", old.params, new.params), ("result", old.results, new.results)):
                yield from (f"{new.name} has {text}" for text in _parameters_clash(what, mine, its))
        for one, other in self.variables:
            if one.kind != other.kind:
                yield f"{one.name} is a {one.kind} in OLD and a {other.kind} in NEW"
            elif meet(one.type, other.type) is None:
                yield f"{one.name} is {type_text(one.type)} in OLD and {type_text(other.type)} in NEW"

    def narrowed(self) -> Iterator[str]:
        """Yield a text for each type or list of statuses that differs: what is compared are the common values."""
        for old, new in self.requests:
            for one, other in (*_by_name(old.params, new.params), *_by_name(old.results, new.results)):
                yield from _narrowed(f"{new.name}.{other.name}", one.type, other.type)
            if {*old.statuses} != {*new.statuses}:
                both = tuple(status for status in new.statuses if status in old.statuses)
                texts = [f"({', '.join(each)})" if each else "none" for each in (old.statuses, new.statuses, both)]
                yield f"statuses of {new.name}: {texts[0]} in OLD, {texts[1]} in NEW, compared on {texts[2]}"
        for mine, its in self.variables:
            yield from _narrowed(mine.name, mine.type, its.type)
        for name, stock in self.old.resource.items():
            if stock.consumable and _is_stock(self.new, name):
                yield from _narrowed(name, Int(0, stock.capacity), Int(0, self.new.resource[name].capacity))


def _is_stock(model: Model, name: str) -> bool:
    return name in model.resource and model.resource[name].consumable


def _by_name(old: tuple[Parameter, ...], new: tuple[Parameter, ...]) -> list[tuple[Parameter, Parameter]]:
    mine = {parameter.name: parameter for parameter in old}
    return [(mine[each.name], each) for each in new if each.name in mine]


def _parameters_clash(what: str, old: tuple[Parameter, ...], new: tuple[Parameter, ...]) -> Iterator[str]:
    names = {each.name for each in old}, {each.name for each in new}
    yield from (f"the {what} {each.name} in OLD alone" for each in old if each.name not in names[1])
    yield from (f"the {what} {each.name} in NEW alone" for each in new if each.name not in names[0])
    for one, other in _by_name(old, new):
        if meet(one.type, other.type) is None:
            yield f"the {what} {one.name}, {type_text(one.type)} in OLD and {type_text(other.type)} in NEW"


def _narrowed(name: str, old: Type, new: Type) -> Iterator[str]:
    common = meet(old, new)
    if common is not None and not old == new == common:
        yield f"{name}: {type_text(old)} in OLD, {type_text(new)} in NEW, compared on {type_text(common)}"


def meet(old: Type, new: Type) -> Type | None:
    """Return the type of the values that two types share; None if they share none."""
    match old, new:
        case Bool(), Bool():
            return old
        case Int(), Int():
            low, high = max(old.low, new.low), min(old.high, new.high)
            return Int(low, high) if low <= high else None
        case Real(), Real():
            least, most = max(old.low, new.low), min(old.high, new.high)
            return Real(least, most) if least <= most else None
        case Enum(), Enum():
            values = tuple(value for value in new.values if contains(old, value))
            return Enum(values) if values else None
        case _:
            return None


def type_text(kind: Type) -> str:
    """Return a type as the language writes it."""
    match kind:
        case Bool():
            return "bool"
        case Int(low, high):
            return f"int in {low} .. {high}"
        case Real(low, high):
            return "real" if kind == Real() else f"real in {low:g} .. {high:g}"
        case Enum(values):
            return f"{{{', '.join(values)}}}"
