"""`python -m benchmarks [--slow]`: one table of what was measured beside its limit. A missed limit is no failure."""

import argparse
import platform
from collections.abc import Iterator

from benchmarks import checks, others, robot, runtime, scale
from benchmarks.measure import Row, cores, load
from exover.gateway.native import NativeUnavailable, find_compiler

LINE = "{:<64} {:>12} {:>14} {:>12}  {:<7} {}"


def main() -> None:
    """Print the table, each row as soon as it is known."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--slow", action="store_true", help="more rounds and larger specs: minutes instead of seconds")
    slow = parser.parse_args().slow
    rounds = 15 if slow else 5
    print(f"{platform.machine()}, {cores()} cores, load {load():.1f}, Python {platform.python_version()}")
    print(f"medians of {rounds} rounds; where no limit stands, one round")
    print(LINE.format("", "limit", "others", "measured", "", "").rstrip())
    for row in rows(rounds, slow):
        limit = "" if row.limit is None else f"<= {row.limit:g} {row.unit}".rstrip()
        value = f"{_number(row.value)} {row.unit}".rstrip()
        print(LINE.format(row.what, limit, row.paper, value, row.verdict, row.note).rstrip(), flush=True)


def rows(rounds: int, slow: bool) -> Iterator[Row]:
    """Yield everything that is measured."""
    yield from robot.processes(rounds)
    yield from robot.tables(rounds)
    try:
        find_compiler()
    except NativeUnavailable as reason:
        print(f"C runtime: not measured, {reason}")
    else:
        yield from robot.runtime(rounds)
        yield from runtime.steps(rounds)
        yield from others.decisions(rounds)
    yield from scale.mutexes(rounds, slow)
    yield from scale.others(slow)
    yield from checks.guarded(slow)
    yield from checks.queues(slow)
    yield from checks.modules()


def _number(value: float) -> str:
    return f"{value:.0f}" if value == int(value) or value >= 100 else f"{value:.3g}"


if __name__ == "__main__":
    main()
