"""The closed loop by binary decision diagrams: exact, on sets of states; CTL and LTL as fixpoints of preimages."""
