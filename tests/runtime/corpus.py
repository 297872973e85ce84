"""What libFuzzer begins with: `python -m tests.runtime.corpus FOLDER` writes a file for each spec.

It is made anew from the specs each time, for what is kept would be of an old format one day, and refused at once.
"""

import sys
from pathlib import Path
from random import Random

from exover.ocrd.packing import checks, pack, width, words
from tests.runtime.compiling import SPECS, built

WIDTH = 2
"""The bytes of words in the build that is looked at."""
EVENT, EVENTS = 4, 200
"""The bytes of an event, and how many there are behind the tables."""


def write(folder: Path) -> list[Path]:
    """Write a file for each spec: packed tables without their check words, then random events. Return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for path in SPECS:
        tables = built(path).tables
        if width(words(tables)) == WIDTH:
            packed = pack(tables)
            events = Random(path.stem).randbytes(EVENT * EVENTS)
            files.append(folder / path.stem)
            files[-1].write_bytes(packed[: len(packed) - WIDTH * len(checks(tables))] + events)
    return files


if __name__ == "__main__":
    write(Path(sys.argv[1]))
