"""Modules that are imported when something of them is asked for first."""

from importlib import import_module
from typing import Any


class LazyModule:
    """Stands for a module, and imports it when it has to."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        """Return what the module calls so."""
        return getattr(import_module(self._name), name)


def lazily(name: str) -> Any:
    """Return what stands for the module of this name."""
    return LazyModule(name)
