"""The answers that differ between two versions of a spec."""
