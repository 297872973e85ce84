"""The closed loop as formulas over Int, Real and Bool, with exact arguments, and Z3 to decide claims about it."""

from exover.engines.smt.engine import Smt

__all__ = ["Smt"]
