"""Formal verification of robot safety rules: a spec becomes checked tables and a running checker."""

__version__ = "0.1.0"
