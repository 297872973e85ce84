"""Reports for people and for programs: one renderer per file, each a pure function of its input."""
