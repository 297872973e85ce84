"""What stands around the declarations of every emitted C header: its guard, what it includes, and C linkage in C++."""

from collections.abc import Iterable

OPENED = ("#ifdef __cplusplus", 'extern "C" {', "#endif")
CLOSED = ("#ifdef __cplusplus", "}", "#endif")


def header(
    about: Iterable[str], guard: str, includes: Iterable[str], declarations: Iterable[str], before: Iterable[str] = ()
) -> str:
    """Return the text of a header: a comment, then the declarations, which have C linkage in a C++ compiler, too.

    What stands `before` them, behind what is included, is for the preprocessor alone.
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
