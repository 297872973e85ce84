"""One question of the closed loop per file (docs/checks.md)."""
