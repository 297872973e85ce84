"""The memory that this process takes (on Linux)."""

from mmap import PAGESIZE
from pathlib import Path


def more_than_now(mib: int) -> int:
    """Return the MiB of address space that this process takes, and so many more."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    return (pages * PAGESIZE >> 20) + mib
