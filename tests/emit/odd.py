"""Specs whose names and texts are odd in C and in Rust."""

from collections.abc import Iterable

from exover.syntax.lex import RESERVED

ODD = r"""
spec _x;
enum kind { int, void }
enum answer { a }
module a_b {
    request c(k: kind, int_: int in 0 .. 5, r2c: bool, _y: real, EOF: int in 0 .. 99999999999, linux: answer)
            fails (EOF, errno) {
        check k == int because "??/ ??= */ /* \"quoted\" \\ %s é 漢";
    }
    request C() instances 3;
    request D(x: bool) returns (y: {p, q}) instances 2;
}
module a { request b_c(); poster tables: bool = false; }
poster LONG_MAX: kind = int;
poster state: real = 0 else 1;
resource fuel: 10 consumable;
"""
TYPES = ("bool", "int in 0 .. 3", "kind", "real", "int in 0 .. 99999999999")


def speaking(words: Iterable[str]) -> str:
    """Return a spec in which every word that may be one is a parameter and a result, a few in each request."""
    used = sorted(set(words) - RESERVED)
    parts = [used[i : i + 20] for i in range(0, len(used), 20)]
    requests = [
        f"request a{i}({given}); request r{i}() returns ({given}) instances 2;"
        for i, part in enumerate(parts)
        for given in [", ".join(f"{word}: {TYPES[at % len(TYPES)]}" for at, word in enumerate(part))]
    ]
    return f"spec x; enum kind {{ one, two }} module m {{ {' '.join(requests)} }}"
