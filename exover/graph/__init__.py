"""The graph of interactions between requests, as exclusion and launches: found in the model, and drawn."""
