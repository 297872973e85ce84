"""The ordered constrained rule diagram: rules as decisions, one small diagram for each event, and the packed tables."""
