"""A folder for the temporary files of processes that may be killed while they write them."""

import os
import shutil
import tempfile
from time import sleep

TRIES, PAUSE = 25, 0.02
"""The tries to remove a folder, and the seconds after each: programs that a killed process has started may go on
writing for a moment."""


class Scratch:
    """A temporary folder, removed when this context is left; processes that start in it call `files_in`.

    `folder`: its path, empty if none can be made.
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
    """Put the temporary files of this process into a folder from now on; do nothing if the path is empty."""
    if folder:
        tempfile.tempdir = folder
