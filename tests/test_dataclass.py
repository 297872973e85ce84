"""`exover.dataclass` beside the standard library: each class is made by both, and does the same."""

import copy
import dataclasses
import inspect
import pickle
from collections.abc import Callable
from functools import cached_property, partial
from typing import Any, ClassVar

import pytest

import exover.dataclass


def same(make: Callable[[Any], type]) -> tuple[type, type]:
    """Return the class that is made by the standard library, and by ours."""
    return make(dataclasses.dataclass), make(exover.dataclass.dataclass)


def plain(dataclass: Any) -> type:
    @dataclass
    class Made:
        """It has a default, and a list of its own."""

        a: int
        b: str = "b"
        c: list[int] = dataclasses.field(default_factory=list)

    return Made


def frozen(dataclass: Any) -> type:
    @dataclass(frozen=True)
    class Made:
        """It keeps what it has found."""

        a: int
        b: Any = None

        @cached_property
        def double(self) -> int:
            """Return twice as much."""
            return 2 * self.a

    return Made


def slots(dataclass: Any) -> type:
    @dataclass(frozen=True, slots=True)
    class Made:
        """Some fields are not compared, some not shown, some are no fields."""

        a: int
        b: str = dataclasses.field(compare=False)
        c: tuple[int, ...] = dataclasses.field(default=(), repr=False)
        d: int = dataclasses.field(default=4, kw_only=True)
        e: int = dataclasses.field(default=5, hash=False)
        known: ClassVar[int] = 3

    return Made


def one(dataclass: Any) -> type:
    @dataclass(frozen=True, slots=True)
    class Made:
        """It has one field."""

        a: Any

    return Made


def none(dataclass: Any) -> type:
    @dataclass(frozen=True, slots=True)
    class Made:
        """It has none."""

    return Made


def derived(dataclass: Any) -> type:
    @dataclass(frozen=True, slots=True)
    class Base:
        """It has slots of its own."""

        a: int

    @dataclass(frozen=True, slots=True)
    class Made(Base):
        """It has more."""

        b: int = 2

        def __post_init__(self) -> None:
            object.__setattr__(self, "b", self.b + 1)

    return Made


def late(dataclass: Any) -> type:
    @dataclass(slots=True)
    class Made:
        """Some fields are no parameters."""

        a: int
        b: int = dataclasses.field(init=False)
        c: list[int] = dataclasses.field(default_factory=list, init=False, repr=False)
        d: int = dataclasses.field(default=7, init=False)

        def __post_init__(self) -> None:
            self.b = self.a + 1

    return Made


def itself(dataclass: Any) -> type:
    @dataclass(frozen=True)
    class Made:
        """It has methods of its own."""

        a: int

        def __eq__(self, other: object) -> bool:
            return True

        def __hash__(self) -> int:
            return 7

        def __repr__(self) -> str:
            return "mine"

    return Made


def equal(dataclass: Any) -> type:
    @dataclass(frozen=True)
    class Made:  # noqa: PLW1641 - the dataclass has it
        """What it is equal to is its own, its hash is not."""

        a: int

        def __eq__(self, other: object) -> bool:
            return isinstance(other, type(self)) and self.a == other.a

    return Made


def by_identity(dataclass: Any) -> type:
    @dataclass(eq=False, slots=True)
    class Made:
        """It is equal to itself."""

        a: int

    return Made


SHAPES = (plain, frozen, slots, one, none, derived, late, itself, equal, by_identity)
ARGUMENTS: tuple[tuple[tuple[Any, ...], dict[str, Any]], ...] = (
    ((), {}),
    ((1,), {}),
    ((float("nan"),), {}),
    (([],), {}),
    ((1, "x"), {}),
    ((1, "y"), {}),
    ((1, "x", (3,)), {}),
    ((1, "x", (3,)), {"d": 9}),
    ((1, "x", (3,)), {"e": 9}),
    ((1, "x", (3,), 9), {}),
    ((1, "x", (3,), 9, 9), {}),
    ((), {"a": 1}),
    ((1,), {"a": 1}),
    ((1,), {"wrong": 1}),
)


def done(does: Callable[[], Any]) -> object:
    """Return what comes of it, or the error."""
    try:
        return does()
    except (TypeError, AttributeError) as error:
        return type(error), str(error)


def parameters(made: type) -> list[Any]:
    """Return what there is to know of the parameters of a class, but for how it makes lists."""
    signature = inspect.signature(made)
    of_lists = [each.name for each in dataclasses.fields(made) if each.default_factory is not dataclasses.MISSING]
    known = [(name, each.kind, each.annotation) for name, each in signature.parameters.items()]
    defaults = {name: each.default for name, each in signature.parameters.items() if name not in of_lists}
    return [*known, defaults, signature.return_annotation]


@pytest.mark.parametrize("make", SHAPES)
def test_the_classes_are_alike(make: Callable[[Any], type]) -> None:
    theirs, ours = same(make)
    for name in ("__match_args__", "__slots__", "__qualname__", "__doc__", "known"):
        assert getattr(ours, name, None) == getattr(theirs, name, None)
    assert [each.name for each in dataclasses.fields(ours)] == [each.name for each in dataclasses.fields(theirs)]
    assert (ours.__hash__ is None) == (theirs.__hash__ is None)
    assert parameters(ours) == parameters(theirs)


@pytest.mark.parametrize("make", SHAPES)
@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_objects_are_alike(make: Callable[[Any], type], arguments: tuple[tuple[Any, ...], dict[str, Any]]) -> None:
    theirs, ours = (done(lambda made=made: made(*arguments[0], **arguments[1])) for made in same(make))
    if isinstance(theirs, tuple):
        assert ours == theirs  # the same error
        return
    assert repr(ours) == repr(theirs)
    if make is not by_identity:
        assert done(lambda: hash(ours)) == done(lambda: hash(theirs))
    for first, second in ((ours, theirs), (theirs, ours)):
        assert type(first).__eq__(first, second) in (NotImplemented, make is itself)
    for name in ("a", "other"):
        for change in (partial(setattr, ours, name, 2), partial(delattr, ours, name)):
            again = partial(change.func, theirs, *change.args[1:])
            if name in type(theirs).__match_args__:
                assert done(change) == done(again)
            else:  # the standard library stumbles over its own slots
                assert (done(change) is None) == (done(again) is None)


def some(made: type) -> list[object]:
    """Return objects of a class."""
    found = [done(partial(made, *positional, **named)) for positional, named in ARGUMENTS]
    return [each for each in found if type(each) is made]


@pytest.mark.parametrize("make", SHAPES)
def test_equality_is_alike(make: Callable[[Any], type]) -> None:
    theirs, ours = map(some, same(make))
    assert len(ours) == len(theirs) > 0
    assert [[a == b for a in ours] for b in ours] == [[a == b for a in theirs] for b in theirs]


@pytest.mark.parametrize("make", SHAPES)
def test_copies_are_alike(make: Callable[[Any], type]) -> None:
    for made in same(make):
        known = made(*((1, "x") if make is slots else () if make is none else (1,)))
        for copied in (copy.copy(known), copy.deepcopy(known), dataclasses.replace(known)):
            assert copied is not known
            assert repr(copied) == (repr(known) if make is not derived else repr(copied))


@exover.dataclass.dataclass(frozen=True, slots=True)
class Pickled:
    """It is sent to another process."""

    a: int
    b: tuple["Pickled", ...] = ()


def test_frozen_objects_with_slots_are_pickled() -> None:
    known = Pickled(1, (Pickled(2), Pickled(3)))
    assert pickle.loads(pickle.dumps(known)) == known


def test_classes_are_derived_from_each_other() -> None:
    theirs, ours = dataclasses.dataclass, exover.dataclass.dataclass
    for one_makes, other_makes in ((theirs, ours), (ours, theirs), (ours, ours)):

        @one_makes(frozen=True)
        class Base:
            """It is frozen."""

            a: int

        @other_makes(frozen=True)
        class Derived(Base):
            """It is, too."""

            b: int

        assert (Derived(1, 2), hash(Derived(1, 2))) == (Derived(1, 2), hash((1, 2)))
        with pytest.raises(dataclasses.FrozenInstanceError):
            Derived(1, 2).a = 3
        with pytest.raises(TypeError, match="cannot inherit non-frozen dataclass from a frozen one"):

            @other_makes
            class Changed(Base):
                """It is not."""


def test_what_was_found_is_kept() -> None:
    for made in same(frozen):
        known = made(3)
        assert (known.double, known.double) == (6, 6)


def test_an_object_that_holds_itself_is_shown() -> None:
    for made in same(one):
        held: list[Any] = []
        held.append(made(held))
        assert repr(held[0]) == f"{made.__qualname__}(a=[...])"


def test_nothing_is_compiled_before_it_is_called() -> None:
    made = one(exover.dataclass.dataclass)
    before = {name: made.__dict__[name] for name in ("__init__", "__eq__", "__hash__")}
    a, b = made(1), made(1)
    assert (made.__dict__["__init__"] is before["__init__"], made.__dict__["__eq__"] is before["__eq__"]) == (
        False,
        True,
    )
    assert a == b and hash(a) == hash(b)
    after = {name: made.__dict__[name] for name in before}
    assert all(after[name] is not before[name] for name in before)
    assert a == b and hash(a) == hash(b) and made(2) != a
    assert all(made.__dict__[name] is after[name] for name in before)
