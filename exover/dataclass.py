"""A `dataclass` decorator as in the standard library that takes a tenth of the time.

`dataclasses` (PEP 557) compiles up to six methods of a class when the class is made. A command imports hundreds of
classes and uses a part of them, so that took longer than its answer. Here a method is compiled at its first call.
Fields, slots and `__match_args__` are made by the standard library, whose `field`, `fields` and `replace` work on these
classes. The checker of certificates uses the standard library, because it imports nothing of exover.
"""

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from dataclasses import MISSING, Field, FrozenInstanceError
from inspect import Parameter, Signature
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any

Method = Callable[..., Any]
Fields = Sequence[Field[Any]]

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(cls=None, *, frozen=False, slots=False, eq=True):
        """Return the class with the methods of a dataclass added that it does not define itself."""
        return _made(cls, frozen, slots, eq) if cls else lambda given: _made(given, frozen, slots, eq)


def _made(given: type, frozen: bool, slots: bool, eq: bool) -> type:
    own = set(given.__dict__)
    bare = dataclasses.dataclass(init=False, repr=False, eq=False, slots=slots, frozen=frozen and _is_frozen(given))
    cls: Any = bare(given)
    cls.__dataclass_params__.frozen = frozen  # of classes that are derived, here or by the standard library
    fields = dataclasses.fields(cls)
    methods: dict[str, Method | None] = {
        "__init__": _compiled_later(cls, "__init__", lambda: _initializer(cls, fields, frozen and slots, frozen)),
        "__repr__": _representation(fields),
    }
    if eq:
        methods["__eq__"] = _compiled_later(cls, "__eq__", lambda: _equality(fields))
        methods["__hash__"] = _compiled_later(cls, "__hash__", lambda: _hash(fields)) if frozen else None
        if given.__hash__ is None and "__eq__" in own:
            own -= {"__hash__"}  # it is there since objects that are equal in their own way have no other
    for name in methods.keys() - own:
        setattr(cls, name, methods[name])
    if "__init__" not in own:
        cls.__signature__ = _FieldSignature(fields)
    if frozen:
        _freeze(cls, fields, slots)
    return cls  # type: ignore[no-any-return]


def _is_frozen(given: type) -> bool:
    """Return whether a class is derived from a frozen dataclass."""
    known: list[Any] = [base for base in given.__mro__[1:] if dataclasses.is_dataclass(base)]
    return any(base.__dataclass_params__.frozen for base in known)


class _FieldSignature:
    """The signature of a class, for `inspect` before its `__init__` is compiled."""

    def __init__(self, fields: Fields) -> None:
        self._fields = sorted((each for each in fields if each.init), key=lambda each: each.kw_only is True)

    def __get__(self, made: object, cls: type) -> Signature:
        return Signature([self._parameter(each) for each in self._fields], return_annotation=None)

    @staticmethod
    def _parameter(field: "Field[Any]") -> Parameter:
        kind = Parameter.KEYWORD_ONLY if field.kw_only else Parameter.POSITIONAL_OR_KEYWORD
        default = field.default if field.default_factory is MISSING else field.default_factory
        return Parameter(
            field.name, kind, default=Parameter.empty if default is MISSING else default, annotation=field.type
        )


def _compiled_later(cls: Any, name: str, compiled: Callable[[], Method]) -> Method:
    """Return a method that, at its first call, compiles the real one, puts it in its own place and calls it."""

    def method(self: Any, *args: Any, **kwargs: Any) -> Any:
        made = compiled()
        made.__qualname__ = f"{cls.__qualname__}.{name}"
        setattr(cls, name, made)
        return made(self, *args, **kwargs)

    return method


def _defined(name: str, parameters: Iterable[str], body: Sequence[str], known: dict[str, Any]) -> Method:
    """Return a method compiled from its parameters and statements, with the globals `known`."""
    source = f"def {name}({', '.join(parameters)}):\n " + "\n ".join(body or ["pass"])
    exec(source, known)
    method: Method = known[name]
    return method


def _initializer(cls: Any, fields: Fields, by_slots: bool, frozen: bool) -> Method:
    """Return `__init__`: positional parameters in the order of the fields, then the keyword-only ones."""
    known: dict[str, Any] = {"_missing": MISSING, "_set": object.__setattr__}
    positional, named, body = ["self"], list[str](), list[str]()
    for each in fields:
        name = value = each.name
        default = ""
        if each.default_factory is not MISSING:
            known[f"_new_{name}"], default = each.default_factory, "=_missing"
            value = f"_new_{name}() if {name} is _missing else {name}" if each.init else f"_new_{name}()"
        elif each.default is not MISSING:
            known[f"_default_{name}"], default = each.default, f"=_default_{name}"
            value = name if each.init else f"_default_{name}"
        elif not each.init:
            continue
        if each.init:
            (named if each.kw_only else positional).append(name + default)
        if by_slots:
            known[f"_set_{name}"] = getattr(cls, name).__set__
            body.append(f"_set_{name}(self, {value})")
        else:
            body.append(f"_set(self, {name!r}, {value})" if frozen else f"self.{name} = {value}")
    if hasattr(cls, "__post_init__"):
        body.append("self.__post_init__()")
    return _defined("__init__", [*positional, *(["*", *named] if named else [])], body, known)


def _tuple_of(owner: str, fields: Iterable[Field[Any]]) -> str:
    return f"({''.join(f'{owner}.{each.name}, ' for each in fields)})"


def _equality(fields: Fields) -> Method:
    compared = [each for each in fields if each.compare]
    equal = f"{_tuple_of('self', compared)} == {_tuple_of('other', compared)}"
    return _defined(
        "__eq__", ["self", "other"], [f"return {equal} if other.__class__ is self.__class__ else NotImplemented"], {}
    )


def _hash(fields: Fields) -> Method:
    hashed = [each for each in fields if (each.compare if each.hash is None else each.hash)]
    return _defined("__hash__", ["self"], [f"return hash({_tuple_of('self', hashed)})"], {})


def _representation(fields: Fields) -> Method:
    shown = [each.name for each in fields if each.repr]

    @recursive_repr()
    def __repr__(self: Any) -> str:
        return f"{self.__class__.__qualname__}({', '.join(f'{name}={getattr(self, name)!r}' for name in shown)})"

    return __repr__


def _freeze(cls: Any, fields: Fields, slots: bool) -> None:
    """Make assignment to fields an error outside `__init__`; with slots, also define how to pickle and copy."""
    names = {each.name for each in fields}

    def __setattr__(self: Any, name: str, value: Any) -> None:
        if type(self) is cls or name in names:
            raise FrozenInstanceError(f"cannot assign to field {name!r}")
        super(cls, self).__setattr__(name, value)

    def __delattr__(self: Any, name: str) -> None:
        if type(self) is cls or name in names:
            raise FrozenInstanceError(f"cannot delete field {name!r}")
        super(cls, self).__delattr__(name)

    def __getstate__(self: Any) -> list[Any]:
        return [getattr(self, each.name) for each in fields]

    def __setstate__(self: Any, state: list[Any]) -> None:
        for each, value in zip(fields, state, strict=True):
            object.__setattr__(self, each.name, value)

    cls.__setattr__, cls.__delattr__ = __setattr__, __delattr__
    if slots:
        cls.__getstate__, cls.__setstate__ = __getstate__, __setstate__
