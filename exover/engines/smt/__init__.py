"""The closed loop as formulas over Int, Real and Bool, its arguments exact, and Z3 to answer what is asked of it."""

from exover.engines.smt.engine import Smt

__all__ = ["Smt"]
