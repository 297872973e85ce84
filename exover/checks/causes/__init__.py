"""Causes of violations: what the messages of findings add to the texts of their checks."""
