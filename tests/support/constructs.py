"""What a spec is made of, so that few specs can be seen to have everything that many have."""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import fields, is_dataclass

from exover.model.model import Model
from exover.model.property import Properties

PLACES = {"place", "name", "because", "location", "vocabulary"}
"""Fields that say where something stands and what it is called."""


def constructs(*models: Model | Properties) -> set[str]:
    """Return the classes and kinds of the parts of models or properties, and which of their fields are not empty."""
    return set(_of(models))


def _of(part: object) -> Iterator[str]:
    if isinstance(part, tuple):
        for each in part:
            yield from _of(each)
    elif is_dataclass(part):
        name = type(part).__name__
        yield f"{name} {getattr(part, 'kind', '')}".rstrip()
        for field in fields(part):
            content = getattr(part, field.name)
            if field.name not in PLACES and content not in (None, False, ()):
                yield f"{name}.{field.name}"
                yield from _of(content)


Spec = tuple[Model] | tuple[Model, Properties]


def seldom(few: Iterable[Spec], many: Iterable[Spec], times: int) -> set[str]:
    """Return the constructs of many specs that are in fewer than `times` of few, and of which there would be more."""
    known, wanted = (Counter(each for spec in specs for each in constructs(*spec)) for specs in (few, many))
    return {each for each, count in wanted.items() if known[each] < min(times, count)}
