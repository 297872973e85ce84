"""Converters for the values of arguments; each raises `argparse.ArgumentTypeError` for a wrong text."""

import argparse
import os
from contextlib import suppress

REPORT_FORMATS = ("text", "json", "sarif", "junit", "github")
MAX_SECONDS = 1_000_000
MAX_JOBS = 256
USUAL_JOBS = 8
"""The most processes by default: each explores the loop for itself."""
MAX_DOMAIN = 232
"""The greatest domain for which DDS has port numbers."""
MAX_MEBIBYTES = 2**24
MAX_DIGITS = 18


def output(text: str) -> tuple[str, str]:
    """Return format and file of `FORMAT=FILE`; standard output is no file."""
    form, _, file = text.partition("=")
    if form not in REPORT_FORMATS or not file:
        raise argparse.ArgumentTypeError(f"{text!r} is no FORMAT=FILE with a format of {', '.join(REPORT_FORMATS)}")
    if file == "-":
        raise argparse.ArgumentTypeError(f"- is no file: --format {form} prints to standard output")
    return form, file


def text(given: str) -> str:
    """Return any text but an empty one, as which a shell passes a variable that is not set."""
    if given:
        return given
    raise argparse.ArgumentTypeError("the value is empty")


def renaming(text: str) -> tuple[str, str]:
    """Return the two requests of `OLD=NEW`."""
    old, _, new = text.partition("=")
    if not old or not new:
        raise argparse.ArgumentTypeError(f"{text!r} is no OLD=NEW with two requests")
    return old, new


def names(text: str) -> list[str]:
    """Return the names between commas, none of them empty."""
    names = [name.strip() for name in text.split(",")]
    if all(names):
        return names
    raise argparse.ArgumentTypeError(f"{text!r} is no list of checks, separated by commas")


def domain(text: str) -> int:
    """Return the number of a DDS domain."""
    if text.isascii() and text.isdigit() and int(text) <= MAX_DOMAIN:
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is no DDS domain from 0 to {MAX_DOMAIN}")


def seconds(text: str) -> float:
    """Return a number of seconds above 0."""
    with suppress(ValueError):
        if 0 < float(text) <= MAX_SECONDS:
            return float(text)
    raise argparse.ArgumentTypeError(f"{text!r} is no number of seconds above 0 and at most {MAX_SECONDS}")


def limit(text: str) -> int:
    """Return a natural number."""
    if text.isascii() and text.isdigit() and len(text) <= MAX_DIGITS:
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is no natural number of at most {MAX_DIGITS} digits")


def mebibytes(text: str) -> int:
    """Return a number of MiB, at least 1."""
    with suppress(ValueError):
        if 1 <= int(text) <= MAX_MEBIBYTES:
            return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is no number of MiB from 1 to {MAX_MEBIBYTES}")


def cores() -> int:
    """Return the default number of processes: one for each core that this process may use, at most USUAL_JOBS."""
    mine = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(mine, USUAL_JOBS)


def jobs(text: str) -> int:
    """Return a number of processes, at least 1."""
    with suppress(ValueError):
        if 1 <= int(text) <= MAX_JOBS:
            return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is no number from 1 to {MAX_JOBS}")
