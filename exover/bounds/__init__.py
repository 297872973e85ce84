"""How much an event costs at most, and how much the checker takes: bounds that are read from the tables."""
