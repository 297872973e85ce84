"""The folders of a project, in which the configuration of a spec is looked for."""

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


def _named(file: Path) -> Path:
    """Return an absolute path without `..`; where `..` follows a link, the folder is the real one."""
    folder = os.path.abspath(file.parent)
    real = os.path.realpath(file.parent)
    return Path(folder if os.path.realpath(folder) == real else real, file.name)
