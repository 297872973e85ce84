"""A folder for the temporary files of processes that may be killed while they write some."""

import os
import shutil
import tempfile
from time import sleep

TRIES, PAUSE = 25, 0.02
"""How often it is tried to remove a folder, and the seconds after each try: programs that a killed process has started
may write a little longer."""


class Scratch:
    """A folder, by its path, that is gone when this context is left; processes that begin in it call `files_in`.

    Where none can be made `folder` is empty.
    """

    def __init__(self) -> None:
        self.folder = ""

    def __enter__(self) -> "Scratch":
        try:
            self.folder = tempfile.mkdtemp(prefix="exover-")
        except OSError:
            self.folder = ""
        return self

    def __exit__(self, *error: object) -> None:
        for _ in range(TRIES):
            shutil.rmtree(self.folder, ignore_errors=True)
            if not os.path.exists(self.folder):
                break
            sleep(PAUSE)


def files_in(folder: str) -> None:
    """Let this process, from now on, have its temporary files in a folder; where it is empty, nothing changes."""
    if folder:
        tempfile.tempdir = folder
