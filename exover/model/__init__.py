"""The vocabulary of a resolved spec, its meaning, and runs of it; below it is only how things are worded."""
