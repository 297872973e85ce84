"""The HTML report: one file that opens offline, with diagrams, runs and a simulator of the tables."""
