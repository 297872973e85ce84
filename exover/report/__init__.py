"""What was found out, for people and for programs: one renderer per file, each a pure function of a `Summary`."""
