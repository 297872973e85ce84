"""The ordered constrained rule diagram (OCRD): one decision diagram for each event, and the packed tables."""
