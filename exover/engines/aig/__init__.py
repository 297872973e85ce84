"""The closed loop as one And-Inverter Graph, and SAT solvers to answer what is asked of it."""
