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


THREADS = """
import resource
from threading import Thread
from exover.checks.schedule.serving import is_memory
with open("/proc/self/statm", encoding="ascii") as pages:
    size = int(pages.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + (4 << 20), resource.RLIM_INFINITY))
try:
    Thread(target=print).start()
except RuntimeError as error:
    assert is_memory(error, limited=True) and not is_memory(error)
else:
    raise AssertionError("there is room for the stack of a thread")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux alone")
def test_a_thread_without_room_for_its_stack_is_for_want_of_memory() -> None:
    done = subprocess.run([sys.executable, "-c", THREADS], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


SILENT = """
import os, sys
from exover.checks.schedule.serving import serve

class Full:
    def poll(self, seconds): return True
    def recv(self): raise MemoryError
    def send(self, message): raise MemoryError

serve(Full(), os.getppid(), print, None, False, sys.argv[1])
"""


def test_a_process_without_memory_to_say_so_ends_in_silence(tmp_path: Path) -> None:
    command = [sys.executable, "-c", SILENT, str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "")
