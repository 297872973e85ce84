"""The closed loop as SMV text, for NuSMV and nuXmv, and what they say of it."""

from exover.engines.smv.program import find

__all__ = ["find"]
