"""What the toolkit is measured by; `python -m benchmarks` prints the table."""

import os

os.environ["EXOVER_NO_CACHE"] = "1"
"""Checks are measured, not what they said before."""
