"""Equivalence of decisions: of the tables and the rules, or of the rules with and without one of them."""
