"""The closed loop as a circuit: states, events, questions; runs of the circuit as traces."""
