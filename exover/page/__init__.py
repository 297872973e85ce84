"""A report to look at: one HTML file that opens offline, with diagrams, runs and a simulator of the tables."""
