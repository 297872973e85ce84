"""Programs of others end when we do."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep

import pytest

from exover.engines.compiler import compile_in
from exover.engines.process import NotRunnable, run

BOTH = "import sys; print('out', sys.argv[1]); print('err', file=sys.stderr); sys.exit(3)"
FAMILY = "echo $$; sleep 60 & echo $!; wait"
PARENT = f"from exover.engines.process import run; from pathlib import Path; run(['sh', '-c', {FAMILY!r}], Path())"


def test_a_command_is_answered_with_its_status_and_what_it_printed(tmp_path: Path) -> None:
    ended = run([sys.executable, "-c", BOTH, "ä"], tmp_path)
    assert (ended.status, ended.printed, ended.complained) == (3, "out ä\n", "err\n")


@pytest.mark.parametrize("name", ["SEGV", "PIPE", "XFSZ"])
def test_a_signal_is_a_status_as_the_shell_has_it(name: str, tmp_path: Path) -> None:
    """Also one that Python ignores: the command does not."""
    number = int(getattr(signal, f"SIG{name}"))
    assert run(["sh", "-c", f"kill -{number} $$"], tmp_path).status == 128 + number


def test_a_compiler_leaves_its_temporary_files_where_it_works(tmp_path: Path) -> None:
    compile_in(tmp_path, ["sh", "-c", 'touch "$TMPDIR/made"'], "made")
    assert [path.name for path in tmp_path.iterdir()] == ["made"]


@pytest.mark.parametrize("what", ["missing", "folder", "text"])
def test_what_cannot_be_started_is_said(tmp_path: Path, what: str) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "text").write_text("no program")
    with pytest.raises(NotRunnable, match=f"cannot run .*{what}: [A-Z]"):
        run([str(tmp_path / what)], tmp_path)


def test_a_command_with_a_limit_ends_with_all_its_processes(tmp_path: Path) -> None:
    started = monotonic()
    with pytest.raises(TimeoutError, match=r"took longer than 0\.5 s"):
        run(["sh", "-c", f"({FAMILY}) > pids"], tmp_path, seconds=0.5)
    assert monotonic() - started < 60  # they sleep for minutes
    pids = [int(pid) for pid in (tmp_path / "pids").read_text().split()]
    assert len(pids) == 2
    _gone(pids)


def test_a_process_left_behind_by_a_command_ends_with_it(tmp_path: Path) -> None:
    ended = run(["sh", "-c", "sleep 60 > /dev/null 2>&1 & echo $!"], tmp_path)
    _gone([int(ended.printed)])


def test_a_command_ends_when_we_are_killed(tmp_path: Path) -> None:
    script = PARENT.replace("echo $!", f"echo $! > {tmp_path}/pid")
    with subprocess.Popen([sys.executable, "-c", script]) as parent:
        file = tmp_path / "pid"
        until = monotonic() + 20
        while not (file.exists() and file.read_text()) and monotonic() < until:
            sleep(0.02)
        parent.kill()
    _gone([int(file.read_text())])


def _gone(pids: list[int]) -> None:
    """Assert that these processes are gone within a second."""
    until = monotonic() + 1
    while any(_lives(pid) for pid in pids) and monotonic() < until:
        sleep(0.02)
    assert [pid for pid in pids if _lives(pid)] == []


def _lives(pid: int) -> bool:
    """Return whether a process is there and no zombie."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text()
