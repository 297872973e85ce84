"""A spec and its properties as they were at a revision, read by the program git."""

import errno
import os
import posixpath
import subprocess
from contextlib import suppress
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

from exover.cli.files import model_of, properties_of, source_of, the_properties
from exover.cli.repository import real_place
from exover.cli.status import CliError
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES, Properties
from exover.pipeline import load
from exover.places import PROPERTIES, SUFFIX

NAMES_REPOSITORY = ("GIT_DIR", "GIT_WORK_TREE", "GIT_COMMON_DIR")
"""Variables by which git takes a repository, whatever the folder is in which it is called."""


class Revision:
    """The files of a revision of the repository that contains a path.

    Raises `CliError` if there is no git, no repository, or no such revision.
    """

    def __init__(self, path: str, name: str) -> None:
        self.name, self._folder = name, _folder(path)
        if path == "-":
            raise CliError("--against is for a file in a repository, not for standard input")
        self._root = self._git("rev-parse", "--show-toplevel", otherwise=f"{path} is in no git repository").strip()
        missing = f"there is no revision {name} in {self._root}"
        self._commit = self._git(
            "rev-parse", "--verify", "--quiet", "--end-of-options", f"{name}^{{commit}}", otherwise=missing
        ).strip()
        self._path = PurePosixPath(os.path.relpath(real_place(path), os.path.realpath(self._root)))

    def shown(self, path: PurePosixPath | None = None) -> str:
        """Return the name of a file in messages, REVISION:PATH; default: of the spec."""
        return f"{self.name}:{path or self._path}"

    def model(self) -> Model:
        """Return the model of the spec; if it has mistakes, they go to standard error, and `CliError` is raised."""
        return model_of(load(source_of(self.shown(), self._content(self._path)), self._part, self._joined))

    def _joined(self, name: str, path: str) -> str:
        """Return the name of a file, REVISION:PATH, by its path from the file of this name."""
        folder = self._within(name).parent
        return self.shown(PurePosixPath(posixpath.normpath(folder / path)))

    def _within(self, name: str) -> PurePosixPath:
        """Return the path from the root of the repository that is in a name as `shown` returns it."""
        return PurePosixPath(name.removeprefix(f"{self.name}:"))

    def _part(self, name: str, most: int) -> bytes:
        """Return the first `most` bytes of an included file; `OSError` if there is none."""
        path = self._within(name)
        if ".." not in path.parts:  # which git would take from the folder where it is called
            with suppress(CliError):
                return self._content(path)[:most]
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), name)

    def properties(self, model: Model) -> Properties:
        """Return the properties that the spec had at the revision; the file is searched as in the work tree."""
        with TemporaryDirectory() as folder:
            spec = Path(folder, self._path)
            blobs = [(place, *self._blob(place)) for place in self._beside()]
            for place, content in {name: (place, content) for place, name, content in reversed(blobs)}.values():
                Path(folder, place).parent.mkdir(parents=True, exist_ok=True)
                Path(folder, place).write_bytes(content)
            spec.parent.mkdir(parents=True, exist_ok=True)
            spec.write_bytes(self._content(self._path))
            found = the_properties(str(spec), model.name, "--old-properties")
            if found is None:
                return NO_PROPERTIES
            name = PurePosixPath(os.path.relpath(os.path.realpath(found), os.path.realpath(folder)))
            return properties_of(source_of(self.shown(name), Path(found).read_bytes()), model)

    def _beside(self) -> list[PurePosixPath]:
        """Return the properties files of the revision in the places where those of the spec are searched."""
        folder = self._path.parent
        places = dict.fromkeys((folder, folder / PROPERTIES, folder.parent / PROPERTIES))
        found = []
        for place in places:
            where = "" if str(place) == "." else f"{place}/"
            listed = self._git("ls-tree", "-z", "--name-only", "--full-tree", self._commit, where or "./")
            found += [PurePosixPath(name) for name in listed.split("\0") if name.endswith(SUFFIX)]
        return list(dict.fromkeys(found))

    def _content(self, path: PurePosixPath) -> bytes:
        return self._blob(path)[1]

    def _blob(self, path: PurePosixPath) -> tuple[bytes, bytes]:
        """Return git's object name and the content of a file, or of the file to which a link leads."""
        asked = os.fsencode(f"{self._commit}:{path}\n")
        head, _, rest = self._bytes("cat-file", "--batch", "--follow-symlinks", told=asked).partition(b"\n")
        match head.split(b" "):
            case [name, b"blob", size]:
                return name, rest[: int(size)]
            case [b"symlink" | b"dangling" | b"loop" | b"notdir", _]:
                raise CliError(f"{self.shown(path)} is a link that leads to no file of {self.name}")
            case _:
                raise CliError(f"{self.name} has no file {path}")

    def _git(self, *words: str, otherwise: str = "") -> str:
        return os.fsdecode(self._bytes(*words, otherwise=otherwise))

    def _bytes(self, *words: str, otherwise: str = "", told: bytes = b"") -> bytes:
        command = ["git", "-C", self._folder, *words]
        try:
            ended = subprocess.run(command, input=told, capture_output=True, check=False, env=_environment())
        except FileNotFoundError as error:
            raise CliError("--against asks git, which is not on PATH") from error
        if ended.returncode:
            said = ended.stderr.decode(errors="replace").strip().partition("\n")[0]
            raise CliError(f"{otherwise or 'git failed'}{f' (git: {said})' if said else ''}")
        return ended.stdout


def _environment() -> dict[str, str]:
    """Return the environment without what names a repository, as in a hook of git: the folder of the spec does."""
    return {name: value for name, value in os.environ.items() if name not in NAMES_REPOSITORY}


def _folder(path: str) -> str:
    """Return the nearest folder above a path that exists."""
    return str(next(each for each in Path(os.path.abspath(path)).parents if each.is_dir()))
