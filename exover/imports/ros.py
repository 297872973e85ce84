"""Definitions of ROS 2 actions, services and messages to parts of specs (docs/imports.md)."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rosbags.typesys import TypesysError, get_types_from_msg

from exover.imports.part import Imported, ImportedField, PartText, UnreadableDescription, module_head, near
from exover.model.wording import counted
from exover.source import Source

SECTIONS = {".action": ("goal", "result", "feedback"), ".srv": ("request", "response"), ".msg": ("message",)}
"""By suffix, the sections of a file."""
UNKNOWN_PACKAGE = "ros"
NO_DEFINITION = "this is no definition of ROS"
RULER = re.compile(r"^---[ \t]*(?:#.*)?$", re.MULTILINE)
"""The line between two sections."""
_HUMP = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
_INTEGERS = {
    "int8": (-(2**7), 2**7 - 1),
    "int16": (-(2**15), 2**15 - 1),
    "int32": (-(2**31), 2**31 - 1),
    "int64": (-(2**63), 2**63 - 1),
    "uint8": (0, 2**8 - 1),
    "octet": (0, 2**8 - 1),
    "byte": (0, 2**8 - 1),
    "char": (0, 2**8 - 1),
    "uint16": (0, 2**16 - 1),
    "uint32": (0, 2**32 - 1),
    "uint64": (0, 2**63 - 1),
}
_REALS = {"float32", "float64"}
_TEXTS = {"string", "wstring"}
_VALUED = re.compile(r"^[ \t]*([^#@\s]\S*)[ \t]+([A-Za-z]\w*)[ \t]+([^=#\s].*)$", re.MULTILINE)
"""A field with a default value: type, name, and the rest of the line."""
_LOCAL = "section/msg/"
"""The package that stands for that of messages which a file names without a package."""
_HEADER = f"MSG: {_LOCAL}Section\n"
"""What rosbags puts before a section."""
_STOPPED = re.compile(r"\ACould not parse:\n.*\n([0-9]+)\n")
"""What rosbags says of a section that it cannot read; the number is of characters."""


class Definition(NamedTuple):
    """A file as it was read: the fields of each section, and its constants in words."""

    source: Source
    sections: dict[str, tuple[ImportedField, ...]]
    constants: tuple[str, ...]

    @property
    def path(self) -> Path:
        """The path of the file."""
        return Path(self.source.name)


def import_ros(sources: Sequence[Source], head: str) -> Imported:
    """Return actions and services as requests, messages as posters: a module for each package, under `head`.

    Raises `UnreadableDescription` if a source is no definition of ROS 2.
    """
    part = PartText()
    packages: dict[str, list[Definition]] = {}
    for source in sources:
        found = _read(source)
        packages.setdefault(package_of(found.path), []).append(found)
    for package, definitions in packages.items():
        name = part.name(package, definitions[0].source.name)
        if package == UNKNOWN_PACKAGE:
            part.leave_open(definitions[0].source.name, f"the package is not known, and the module is called `{name}`")
        part.lines.append(module_head(name, ""))
        for each in definitions:
            _add(part, each)
        part.lines.append("}")
    return part.finished(sources[0].name, head)


def package_of(path: Path) -> str:
    """Return the package of a file, the folder above `action`, `srv` or `msg`, in exo; UNKNOWN_PACKAGE if none."""
    folder = path.absolute().parent
    if folder.name not in ("action", "srv", "msg") or not folder.parent.name:
        return UNKNOWN_PACKAGE
    return named(folder.parent.name)


def named(text: str) -> str:
    """Return a text as a name of exo: CamelCase as snake_case, and `_` for each character that no name may have."""
    name = re.sub(r"\W", "_", _HUMP.sub("_", text).lower(), flags=re.ASCII)
    return f"_{name}" if not name or name[0].isdigit() else name


def _read(source: Source) -> Definition:
    path = Path(source.name)
    names = SECTIONS.get(path.suffix)
    if names is None:
        raise UnreadableDescription(
            source.name, f"it is no file of ROS: its name ends with none of {', '.join(SECTIONS)}"
        )
    texts = RULER.split(source.text.replace("\r\n", "\n"))
    if len(texts) != len(names):
        rulers = len(names) - 1
        raise UnreadableDescription(source.name, f"it has {_lines(len(texts) - 1)}, and {path.suffix} has {rulers}")
    sections, constants, line = {}, [], 1
    for name, text in zip(names, texts, strict=True):
        sections[name], found = _section(source, text, line)
        constants += [f"{name}: {each}" for each in found]
        line += text.count("\n")
    return Definition(source, sections, tuple(constants))


def _section(source: Source, text: str, line: int) -> tuple[tuple[ImportedField, ...], list[str]]:
    """Return the fields of a section that begins on a line, and its constants."""
    try:
        ((constants, fields),) = get_types_from_msg(text, f"{_LOCAL}Section").values()
    except (TypesysError, ValueError) as error:
        at, reason = _unread(error, text)
        raise UnreadableDescription(f"{source.name}:{line + at}", f"{NO_DEFINITION}: {reason}") from error
    for found in _VALUED.finditer(text):
        if not _is_value(*found.group(1, 3)):
            place = f"{source.name}:{line + text.count(chr(10), 0, found.start(1))}"
            raise UnreadableDescription(place, f"{NO_DEFINITION}: `{found[3].strip()}` is no value of `{found[1]}`")
    return (
        tuple(_field(source, text, line, name, kind) for name, kind in fields),
        [f"{name} = {value}" for name, _, value in constants],
    )


def _unread(error: Exception, text: str) -> tuple[int, str]:
    """Return how many lines of a section rosbags has read, and what it says of the next."""
    found = _STOPPED.search(str(error))
    if found is None:
        return 0, " ".join(str(error).split())
    rest = text[max(int(found[1]) - len(_HEADER), 0) :].lstrip()
    return text.count(
        "\n", 0, len(text) - len(rest)
    ), f"`{rest.partition(chr(10))[0].strip()}` is no field and no constant"


def _lines(rulers: int) -> str:
    return f"{counted(rulers, 'line')} `---`"


def _is_value(kind: str, text: str) -> bool:
    """Return whether a text, perhaps with a comment, is a default value of a type; a message type has none."""
    value = text.partition("#")[0].strip().lower()
    base = re.split(r"<|\[", kind)[0]
    if "[" in kind:
        return value.startswith("[")
    if base == "bool":
        return value in ("true", "false", "0", "1")
    if base in _INTEGERS:
        return re.fullmatch(r"[-+]?(\d+|0x[\da-f]+)", value, re.ASCII) is not None
    if base in _REALS:
        return re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?|[-+]?(inf|nan)", value, re.ASCII) is not None
    return base in _TEXTS


def _field(source: Source, text: str, line: int, name: str, kind: Any) -> ImportedField:
    found = re.search(rf"^[ \t]*[^#\s]\S*[ \t]+{re.escape(name)}\b(?![ \t]*=)", text, re.MULTILINE)
    place = f"{source.name}:{line + text.count(chr(10), 0, found.start()) if found else line}"
    node, what = kind
    match node.name, what:
        case "BASE", ("bool", _):
            return ImportedField(name, "bool", place)
        case "BASE", (str(base), _) if base in _REALS:
            return ImportedField(name, "real", place)
        case "BASE", (str(base), _) if base in _INTEGERS:
            low, high = _INTEGERS[base]
            return ImportedField(
                name, f"int in {low} .. {high}", place, "exo has no integers above it" if base == "uint64" else ""
            )
        case "BASE", (base, _):
            return ImportedField(name, None, place, f"a {base}")
        case "NAME", str(full) if full.removeprefix(_LOCAL) in _TEXTS:
            return ImportedField(name, None, place, f"a {full.removeprefix(_LOCAL)}")
        case "NAME", _:
            return ImportedField(name, None, place, f"a message `{what.removeprefix(_LOCAL)}`")
        case _:
            return ImportedField(name, None, place, "an array" if node.name == "ARRAY" else "a sequence")


# ---- what is written ----


def _add(part: PartText, found: Definition) -> None:
    """Add the request or the posters that a file defines."""
    place, name = found.source.name, named(found.path.stem)
    part.say(f"{near(place)}")
    for each in found.constants:
        part.say(f"constant of the {each}")
    if found.path.suffix == ".msg":
        _posters(part, name, found.sections["message"])
        return
    going, coming = (found.sections[section] for section in SECTIONS[found.path.suffix][:2])
    params, results = part.fields(going), part.fields(coming, [each.name for each in going if each.kind])
    for told in found.sections.get("feedback", ()):
        part.leave_open(told.place, f"`{told.name}` is left out: it is feedback, which no request has")
    request = f"request {part.name(name, place)}({params})"
    part.lines.append(f"{request} returns ({results});" if results else f"{request};")


def _posters(part: PartText, name: str, fields: Iterable[ImportedField]) -> None:
    for each in fields:
        full = f"{name}_{each.name}"
        if kind := part.kind(full, each):
            part.poster(full, kind, "false" if kind == "bool" else "0", each.place)
