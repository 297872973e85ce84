"""Recorded missions asked of a spec (docs/audit.md)."""
