"""And-Inverter Graphs: built, unrolled, as clauses for a solver, as AIGER."""
