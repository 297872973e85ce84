"""Formal verification of robot safety rules: a spec becomes checked tables and a running checker.

The names of `exover.library` can be used from here (docs/library.md). That module is imported at its first use, so that
`import exover`, and with it the command, costs nothing.
"""
# ruff: noqa: F403, F405

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from exover.library import *

__version__ = "0.1.0"
__all__ = [
    "NO_PROPERTIES",
    "Abort",
    "AbortWaiting",
    "Action",
    "Answer",
    "Ask",
    "Diagnostic",
    "Event",
    "Finding",
    "Findings",
    "Invalid",
    "Killed",
    "Launched",
    "Moment",
    "NativeUnavailable",
    "Observe",
    "Properties",
    "Rejected",
    "Report",
    "Spec",
    "SpecError",
    "Tables",
    "TablesError",
    "Trace",
    "Violated",
    "Waits",
    "__version__",
    "check",
    "compile",
    "load",
    "load_properties",
    "load_tables",
    "loads",
    "simulate",
]


def __getattr__(name: str) -> Any:
    """Return the object of this name in `exover.library`; raises `AttributeError`."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module("exover.library"), name)


def __dir__() -> list[str]:
    """Return all names, those of the library among them."""
    return sorted({*globals(), *__all__})
