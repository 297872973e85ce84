"""Audits of recorded missions by a spec (docs/audit.md)."""
