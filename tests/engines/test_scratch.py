"""Temporary files of processes that are killed: their folder is gone, or there was none."""

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from exover.engines.scratch import PAUSE, TRIES, Scratch, files_in


def test_a_process_has_its_files_in_the_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", tempfile.gettempdir())
    with Scratch() as scratch:
        files_in(scratch.folder)
        made = Path(tempfile.mkdtemp())
        assert made.parent == Path(scratch.folder)
        (made / "file").touch()
    assert not Path(scratch.folder).exists()


def test_what_is_written_while_it_is_removed_is_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    slept = list[float]()

    def late(folder: str, ignore_errors: bool) -> None:
        if len(slept) == 2:
            os.rmdir(folder)

    monkeypatch.setattr("exover.engines.scratch.shutil.rmtree", late)
    monkeypatch.setattr("exover.engines.scratch.sleep", slept.append)
    with Scratch() as scratch:
        pass
    assert slept == [PAUSE] * 2
    assert not Path(scratch.folder).exists()


def test_a_folder_that_stays_is_given_up(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    slept = list[float]()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr("exover.engines.scratch.shutil.rmtree", lambda folder, ignore_errors: None)
    monkeypatch.setattr("exover.engines.scratch.sleep", slept.append)
    with Scratch():
        pass
    assert len(slept) == TRIES


def test_where_no_folder_can_be_made_there_is_none(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))
    with Scratch() as scratch:
        assert scratch.folder == ""
        files_in(scratch.folder)
        assert tempfile.gettempdir() == str(tmp_path / "nowhere")


INTERRUPTED = """
import os, signal
from exover.engines.process import uninterrupted
signal.signal(signal.SIGINT, signal.default_int_handler)  # which is not so where the tests run in the background
with uninterrupted(signal.SIGINT):
    os.kill(os.getpid(), signal.SIGINT)
    print("on", flush=True)
print("further")
"""


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="the system has no masks of signals")
def test_signals_wait_for_the_end() -> None:
    ended = subprocess.run([sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=False)
    assert (ended.stdout, ended.returncode) == ("on\n", -signal.SIGINT)
