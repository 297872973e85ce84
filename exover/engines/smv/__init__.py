"""The closed loop as SMV text for NuSMV and nuXmv, and the evaluation of their answers."""

from exover.engines.smv.program import find

__all__ = ["find"]
