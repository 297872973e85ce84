"""The names and texts of a spec as C sources; a small target may leave them out."""

from collections.abc import Iterable, Iterator, Sequence

from exover.emit.cheader import header
from exover.emit.identifiers import figure, parameters, prefix
from exover.model.index import ModelIndex
from exover.model.model import Model
from exover.model.types import Enum, Type
from exover.ocrd.reasons import reasons

LONGEST = 4000
"""The most bytes of a text that is a string literal; a C99 compiler need not take more than 4095."""


def declarations(model: Model, name: str) -> str:
    """Return the text of `NAME_names.h`."""
    start = prefix(name)
    figures = [(figure(name, what), count) for what, count in _lengths(model)]
    one, many = f"extern const char *const {start}_", f"extern const char *const *const {start}_"
    declared = f"""{"".join(f"#define {macro} {count}{chr(10)}" for macro, count in figures)}
/* By index. `because` is NULL for a reason without a text. */
{one}request_names[];
{one}variable_names[]; /* posters, module states, latches */
{one}stock_names[];
{one}reason_names[];
{one}reason_because[];

/* By index in the tables: the parameters of a request, then its results, request after request. */
{one}param_names[];

/* The values of enums by index of the parameter or variable; NULL if it is of another type. */
{many}param_values[];
{many}variable_values[];

/* The statuses of failed reports by index of the request. */
{many}status_names[];
"""
    about = f"/* What the things of the spec {model.name} are called. Behind the last of every table stands a NULL. */"
    return header([about], figure(name, "NAMES_H"), [], declared.split("\n"))


def _lengths(model: Model) -> Iterator[tuple[str, int]]:
    yield "REQUESTS", len(model.requests)
    yield "VARIABLES", len(ModelIndex(model).readings)
    yield "STOCKS", len(ModelIndex(model).consumables)
    yield "REASONS", len(reasons(model))
    yield "PARAMS", len(parameters(model))


def source(model: Model, name: str) -> str:
    """Return the text of `NAME_names.c`."""
    start = prefix(name)
    index = ModelIndex(model)
    texts = reasons(model)
    params = parameters(model)
    return "\n".join(
        [
            f"/* What the things of the spec {model.name} are called. */",
            "#include <stddef.h>",
            "",
            f'#include "{name}_names.h"',
            "",
            *_strings(f"{start}_request_names", index.requests),
            *_strings(f"{start}_variable_names", index.readings),
            *_strings(f"{start}_stock_names", index.stocks),
            *_strings(f"{start}_reason_names", [reason.rule for reason in texts]),
            *_strings(f"{start}_reason_because", [reason.because for reason in texts]),
            *_strings(f"{start}_param_names", [parameter.name for _, parameter in params]),
            *_lists(f"{start}_param_values", [_values(parameter.type) for _, parameter in params]),
            *_lists(f"{start}_variable_values", [_values(kind) for _, kind in index.typed_readings]),
            *_lists(f"{start}_status_names", [request.statuses for request in model.requests]),
        ]
    )


def _values(kind: Type) -> tuple[str, ...] | None:
    return kind.values if isinstance(kind, Enum) else None


def _strings(name: str, texts: Sequence[str | None], storage: str = "") -> Iterator[str]:
    """Yield the lines of an array of strings, terminated by NULL; texts above LONGEST are arrays of characters."""
    long = {index: text for index, text in enumerate(texts) if text is not None and len(text.encode()) > LONGEST}
    for number, characters in long.items():
        yield f"static const char {name}_{number}[] = {{{_characters(characters)}}};"
    yield f"{storage}const char *const {name}[] = {{"
    for index, text in enumerate(texts):
        yield f"    {f'{name}_{index}' if index in long else _literal(text)},"
    yield "    NULL,"
    yield "};"
    yield ""


def _lists(name: str, lists: Sequence[Sequence[str] | None]) -> Iterator[str]:
    """Yield the lines of an array of arrays of strings, terminated by NULL; equal arrays are written once."""
    made: dict[tuple[str, ...], str] = {}
    for texts in lists:
        if texts is not None and tuple(texts) not in made:
            made[tuple(texts)] = f"{name}_{len(made)}"
            yield from _strings(made[tuple(texts)], texts, "static ")
    yield f"const char *const *const {name}[] = {{"
    for texts in lists:
        yield f"    {'NULL' if texts is None else made[tuple(texts)]},"
    yield "    NULL,"
    yield "};"
    yield ""


def _literal(text: str | None) -> str:
    return "NULL" if text is None else f'"{_escaped(text.encode())}"'


def _escaped(data: Iterable[int]) -> str:
    """Return the text of a literal: octal but for printable ASCII without `"`, backslash and `?` (trigraphs)."""
    return "".join(chr(byte) if 32 <= byte < 127 and byte not in b'"\\?' else f"\\{byte:03o}" for byte in data)


def _characters(text: str) -> str:
    return ", ".join(f"'\\{byte:03o}'" for byte in (*text.encode(), 0))
