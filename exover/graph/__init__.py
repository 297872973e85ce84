"""Who excludes whom, launches whom and wakes whom: read from the model, and drawn."""
