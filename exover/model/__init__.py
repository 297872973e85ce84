"""The vocabulary of a resolved spec, its meaning, and runs of it; imports nothing but itself."""
