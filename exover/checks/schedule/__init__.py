"""Which engines answer the questions, in which order, for how long and in which processes."""
