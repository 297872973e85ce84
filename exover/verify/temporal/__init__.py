"""Properties of runs, decided on sets of states."""
