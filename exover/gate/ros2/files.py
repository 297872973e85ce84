"""Finds definitions of types in folders of packages, as the `share` of a ROS installation is."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from exover.gate.ros2.interfaces import Find, UnknownType


def finder(folders: Sequence[str], environment: Mapping[str, str]) -> Find:
    """Return a function that finds a type's text in these folders, or below a prefix in `AMENT_PREFIX_PATH`."""
    prefixes = [each for each in environment.get("AMENT_PREFIX_PATH", "").split(":") if each]
    places = [Path(each) for each in folders] + [Path(each) / "share" for each in prefixes]

    def find(name: str) -> str | None:
        package, kind, last = name.split("/")
        for place in places:
            file = place / package / kind / f"{last}.{kind}"
            try:
                return file.read_text(encoding="utf-8")
            except (FileNotFoundError, NotADirectoryError):
                continue
            except (OSError, UnicodeDecodeError) as error:
                raise UnknownType(f"the type {name} cannot be read from {file}: {error}") from error
        return None

    return find
