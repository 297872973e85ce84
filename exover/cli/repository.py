"""Where the files of a project are: the folders up to the root of its repository, and the real place of a file."""

import os
from pathlib import Path

CONFIG = "exover.toml"


def folders_up(file: Path) -> list[Path]:
    """Return the folder of a file and, in a repository, those above it up to its root, which holds `.git`.

    The paths are absolute. A file that is a link is in the folder by which it is named.
    """
    folders = list(_named(file).parents)
    root = next((place for place, folder in enumerate(folders) if (folder / ".git").exists()), 0)
    return folders[: root + 1]


def real_place(file: str | Path) -> str:
    """Return the name of a file in the real folder that holds it; the file itself may be a link.

    What belongs to a spec is looked for where it is named, so links to one file in two folders are two specs.
    """
    return os.path.join(os.path.realpath(os.path.dirname(file)), os.path.basename(file))


def _named(file: Path) -> Path:
    """Return an absolute path without `..`; where `..` follows a link, the folder is the real one."""
    folder = os.path.abspath(file.parent)
    real = os.path.realpath(file.parent)
    return Path(folder if os.path.realpath(folder) == real else real, file.name)
