"""The frame of every emitted C header: include guard, includes, and C linkage in C++."""

from collections.abc import Iterable

OPENED = ("#ifdef __cplusplus", 'extern "C" {', "#endif")
CLOSED = ("#ifdef __cplusplus", "}", "#endif")


def header(
    about: Iterable[str], guard: str, includes: Iterable[str], declarations: Iterable[str], before: Iterable[str] = ()
) -> str:
    """Return the text of a header: a comment, the guard, the includes, and the declarations, with C linkage in C++ too.

    `before`: lines for the preprocessor between the includes and the declarations.
    """
    included = [f'#include "{file}"' for file in includes]
    lines = [
        *about,
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        *([*included, ""] if included else []),
        *before,
        *OPENED,
        "",
        *declarations,
        *CLOSED,
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"
