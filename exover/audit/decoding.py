"""Decodes the messages of a bag by the types that the bag defines; needs `rosbags`."""

from collections.abc import Iterator, Mapping
from itertools import count
from typing import Any

from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag2 import Reader as BagReader
from rosbags.rosbag2 import ReaderError
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from exover.audit.binary import NoMission
from exover.diagnostics import quote

LONGEST = 160
"""How many characters of a text of `rosbags` are told."""


class Fields(Mapping[str, Any]):
    """A message as a read-only mapping: field by name."""

    def __init__(self, message: Any) -> None:
        self._message = message

    def __getitem__(self, key: str) -> Any:
        """Return a field, as `plain` gives it."""
        if key not in self._message.__dataclass_fields__:
            raise KeyError(key)
        return plain(getattr(self._message, key))

    def __contains__(self, key: object) -> bool:
        """Return whether there is such a field."""
        return key in self._message.__dataclass_fields__

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the fields."""
        return iter(self._message.__dataclass_fields__)

    def __len__(self) -> int:
        """Return the number of fields."""
        return len(self._message.__dataclass_fields__)


def plain(found: Any) -> Any:
    """Return a value of a message as mappings, lists and scalars, as in JSON."""
    if hasattr(found, "__dataclass_fields__"):
        return Fields(found)
    if hasattr(found, "tolist"):
        return found.tolist()
    return [plain(each) for each in found] if isinstance(found, list | tuple) else found


def decoded(reader: BagReader, wanted: list[Any]) -> Iterator[tuple[str, int, Any]]:
    """Yield topic, time in nanoseconds and content of each message of these connections. Raises `NoMission`."""
    messages = reader.messages(connections=wanted)
    stores: dict[str, Typestore] = {}
    for number in count():
        try:
            connection, stamp, data = next(messages)
        except StopIteration:
            return
        except Exception as error:  # a damaged file may raise anything, here and below
            raise NoMission(f"the message behind {number} cannot be read: {reason(error)}") from error
        kind = connection.msgtype
        try:
            if kind not in stores:
                stores[kind] = _types_of(connection)
            store = stores[kind]
        except Exception as error:
            why = f"the definition of its type {quote(str(kind))} cannot be read"
            raise NoMission(f"the message behind {number} cannot be read: {why}") from error
        try:
            message = plain(store.deserialize_cdr(data, _known(store, kind)))
        except Exception as error:
            why = f"it does not fit the definition of its type {quote(str(kind))}"
            raise NoMission(f"the message behind {number} cannot be read: {why}") from error
        yield connection.topic, stamp, message


def _types_of(connection: Any) -> Typestore:
    """Return the types that a connection of a bag defines, or those of ROS if it defines none."""
    form, text = connection.msgdef.format, connection.msgdef.data
    if form == MessageDefinitionFormat.NONE:
        return get_typestore(Stores.LATEST)
    store = get_typestore(Stores.EMPTY)
    if form == MessageDefinitionFormat.MSG:
        store.register(get_types_from_msg(text, connection.msgtype))
        return store
    parts = text.split(f"{'=' * 80}\nIDL: ")
    for part in parts[1:] or [f"\n{text}"]:
        store.register(get_types_from_idl(part.split("\n", 1)[1]))
    return store


def _known(store: Typestore, name: str) -> str:
    """Return the name of a type in `rosbags`, which files types of services under `msg`."""
    if name in store.fielddefs:
        return name
    package, _, own = name.rpartition("/")
    return f"{package}/msg/{own}"


def reason(error: Exception) -> str:
    """Return why a bag cannot be read, as a short line."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    line = next(iter(str(error).splitlines()), "") if isinstance(error, ReaderError) else ""
    return (line if len(line) <= LONGEST else f"{line[:LONGEST]}…") or "it is damaged"
