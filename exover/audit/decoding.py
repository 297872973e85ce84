"""The messages of a bag as objects, whatever types it defines; needs `rosbags`."""

from collections.abc import Iterator, Mapping
from itertools import count
from typing import Any

from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag2 import Reader as BagReader
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from exover.audit.binary import NoMission


class Fields(Mapping[str, Any]):
    """A message as an object whose keys are its fields."""

    def __init__(self, message: Any) -> None:
        self._message = message

    def __getitem__(self, key: str) -> Any:
        """Return a field as JSON would have it."""
        if key not in self._message.__dataclass_fields__:
            raise KeyError(key)
        return plain(getattr(self._message, key))

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the fields."""
        return iter(self._message.__dataclass_fields__)

    def __len__(self) -> int:
        """Return how many fields there are."""
        return len(self._message.__dataclass_fields__)


def plain(found: Any) -> Any:
    """Return what a message holds as JSON would have it."""
    if hasattr(found, "__dataclass_fields__"):
        return Fields(found)
    if hasattr(found, "tolist"):
        return found.tolist()
    return [plain(each) for each in found] if isinstance(found, list | tuple) else found


def decoded(reader: BagReader, wanted: list[Any]) -> Iterator[tuple[str, int, Any]]:
    """Yield the messages of connections: topic, time in nanoseconds, the message. Raises `NoMission`."""
    messages = reader.messages(connections=wanted)
    stores: dict[str, Typestore] = {}
    for number in count():
        try:
            connection, stamp, data = next(messages)
            if connection.msgtype not in stores:
                stores[connection.msgtype] = _types_of(connection)
            store = stores[connection.msgtype]
            message = plain(store.deserialize_cdr(data, _known(store, connection.msgtype)))
        except StopIteration:
            return
        except Exception as error:  # whatever a damaged file makes of it
            raise NoMission(f"the message behind {number} cannot be read: {first_line(error)}") from error
        yield connection.topic, stamp, message


def _types_of(connection: Any) -> Typestore:
    """Return the types that a topic of a bag defines, or those of ROS if it defines none."""
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
    """Return what `rosbags` calls a type: it puts those of services into a folder of messages."""
    if name in store.fielddefs:
        return name
    package, _, own = name.rpartition("/")
    return f"{package}/msg/{own}"


def first_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
