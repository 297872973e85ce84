"""What a process that serves questions takes for want of memory."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
FULL = """
import resource
from exover.checks.schedule.serving import is_memory
strange = AttributeError("what a library that is loaded in part raises")
assert not is_memory(strange, limited=True)
resource.setrlimit(resource.RLIMIT_AS, (1 << 20, resource.RLIM_INFINITY))
assert is_memory(strange, limited=True)
assert not is_memory(strange)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux alone")
def test_whatever_is_raised_where_no_memory_is_left_is_for_want_of_it() -> None:
    done = subprocess.run([sys.executable, "-c", FULL], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
