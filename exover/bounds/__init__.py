"""Worst-case bounds of events, and the sizes of the checker, by static analysis of the tables."""
