"""`python -m benchmarks [--slow] [NAME …]`: a table of what was measured beside its limit. Missing one is no failure.

With names, only those rows or groups of rows.
"""

import argparse
import platform
from collections.abc import Callable, Iterator, Sequence
from functools import partial

from benchmarks import audit, changes, checks, editor, engines, gate, others, page, robot, ros2, runtime, scale
from benchmarks.measure import Row, cores, load
from exover.engines.compiler import NativeUnavailable, find_compiler

LINE = "{:<64} {:>12} {:>14} {:>12}  {:<7} {}"
Rows = Callable[[], Iterator[Row]]


def main() -> None:
    """Print the table, each row as soon as it is known."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--slow", action="store_true", help="more rounds and larger specs: minutes instead of seconds")
    parser.add_argument("--list", action="store_true", help="print the names of all rows, group by group, and end")
    parser.add_argument("names", metavar="NAME", nargs="*", help="a row or a group of rows (default: all)")
    arguments = parser.parse_args()
    rounds = 15 if arguments.slow else 5
    known = groups(rounds, arguments.slow)
    names = {*known, *(name for members in known.values() for name in members)}
    unknown = [name for name in arguments.names if name not in names]
    if unknown:
        parser.error(f"no rows are called {', '.join(unknown)}; --list tells what they are called")
    if arguments.list:
        for group, members in known.items():
            print(f"{group}: {' '.join(members)}")
        return
    print(f"{platform.machine()}, {cores()} cores, load {load():.1f}, Python {platform.python_version()}")
    print(f"medians of {rounds} rounds; where no limit stands, one round")
    print(LINE.format("", "limit", "others", "measured", "", "").rstrip())
    for row in chosen(known, arguments.names):
        limit = "" if row.limit is None else f"<= {row.limit:g} {row.unit}".rstrip()
        value = f"{_number(row.value)} {row.unit}".rstrip()
        print(LINE.format(row.what, limit, row.paper, value, row.verdict, row.note).rstrip(), flush=True)


def groups(rounds: int, slow: bool) -> dict[str, dict[str, Rows]]:
    """Return what can be measured, by its name, in groups."""
    return {
        "robot": {"processes": partial(robot.processes, rounds), "tables": partial(robot.tables, rounds)},
        "runtime": {
            "events": partial(_compiled, partial(robot.runtime, rounds)),
            "steps": partial(_compiled, partial(runtime.steps, rounds)),
            "others": partial(_compiled, partial(others.decisions, rounds)),
        },
        "page": {"pages": partial(page.pages, rounds)},
        "editor": {"keys": partial(editor.keys, rounds)},
        "changes": {
            "diffs": partial(changes.diffs, slow),
            "unchanged": partial(changes.unchanged, rounds),
            "edits": changes.edits,
        },
        "gate": {
            "decisions": partial(gate.decisions, rounds),
            "calls": partial(gate.calls, rounds),
            **({"goals": partial(ros2.own, rounds), "dds": ros2.added} if ros2.installed() else {}),
        },
        "audit": {"missions": partial(_compiled, partial(audit.missions, rounds))},
        "scale": {"mutexes": partial(scale.mutexes, rounds, slow), "kinds": partial(scale.others, slow)},
        "diagrams": {
            "guarded": partial(checks.guarded, slow),
            "queues": partial(checks.queues, slow),
            "modules": checks.modules,
        },
        **engines.groups(),
    }


def chosen(known: dict[str, dict[str, Rows]], names: Sequence[str]) -> Iterator[Row]:
    """Yield the rows of these names, or all."""
    for group, members in known.items():
        for name, rows in members.items():
            if not names or group in names or name in names:
                yield from rows()


def _compiled(rows: Rows) -> Iterator[Row]:
    """Yield rows for which a C compiler is needed."""
    try:
        find_compiler()
    except NativeUnavailable as reason:
        print(f"C runtime: not measured, {reason}")
    else:
        yield from rows()


def _number(value: float) -> str:
    return f"{value:.0f}" if value == int(value) or value >= 100 else f"{value:.3g}"


if __name__ == "__main__":
    main()
