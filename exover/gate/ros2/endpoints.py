"""DDS readers and writers, with their QoS, for the ports of a gate; needs `cyclonedds`."""

import ctypes
from collections.abc import Iterator
from typing import Any

from cyclonedds._clayer import ddspy_take, ddspy_write
from cyclonedds.core import DDSException, DDSStatus, InstanceState, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

EVERYTHING = 0x7FFF0100
"""The handle of the root entity of DDS in this process (`DDS_CYCLONEDDS_HANDLE`)."""
UNSIGNED = (1 << 64) - 1
SECOND = 1_000_000_000
"""A second in the unit of DDS durations, nanoseconds."""
AT_ONCE = 100
"""The most samples that are taken from one reader in its turn."""
WORD = 4
"""Messages are padded to a multiple of so many bytes."""
_ANY = ViewState.Any | InstanceState.Any | SampleState.Any
_RELIABLE = Policy.Reliability.Reliable(duration(milliseconds=100))
_XCDR1 = Policy.DataRepresentation(use_cdrv0_representation=True)
_VOLATILE = Policy.Durability.Volatile

REQUESTS = Qos(
    _XCDR1,
    _RELIABLE,
    _VOLATILE,
    Policy.History.KeepAll,
    Policy.ResourceLimits(max_samples=10_000, max_instances=-1, max_samples_per_instance=-1),
)
"""Readers keep each sample until it is taken; when the limit is reached, writers have to wait (back-pressure)."""
KEPT = 1000
"""How many replies are kept for clients that do not read them."""
REPLIES = Qos(_XCDR1, _RELIABLE, _VOLATILE, Policy.History.KeepLast(KEPT))
"""Writers keep only the last replies, so that a client that does not read blocks nobody."""
FEEDBACK = Qos(_XCDR1, _RELIABLE, _VOLATILE, Policy.History.KeepLast(100))
LATCHED = Qos(_XCDR1, _RELIABLE, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))
DECISIONS = Qos(
    _XCDR1,
    _RELIABLE,
    Policy.Durability.TransientLocal,
    Policy.History.KeepLast(100),
    Policy.DurabilityService(
        cleanup_delay=0,
        history=Policy.History.KeepLast(100),
        max_samples=-1,
        max_instances=-1,
        max_samples_per_instance=-1,
    ),
)
WATCHED = Qos(_XCDR1, Policy.Reliability.BestEffort, _VOLATILE, Policy.History.KeepLast(10))


class _All:
    """Stands for a participant when a `WaitSet` is made: all of DDS in this process, of any domain."""

    _ref = EVERYTHING


class Waiting(WaitSet):
    """A wait set that returns the numbers of the entities that have triggered."""

    def __init__(self) -> None:
        super().__init__(_All())  # type: ignore[arg-type]
        self._found = (ctypes.c_void_p * 0)()

    def watch(self, entity: Any, number: int) -> None:
        """Attach an entity; `number`, above 0, stands for it."""
        done = self._waitset_attach(self._ref, entity._ref, number)
        if done < 0:
            raise DDSException(done, "while an entity was attached")
        self.attached.append((entity, number))
        self._found = (ctypes.c_void_p * len(self.attached))()

    def ready(self, seconds: float) -> list[int]:
        """Return the numbers of the entities that have triggered, once there is one or after `seconds`."""
        count = self._waitset_wait(self._ref, self._found, len(self._found), max(0, int(seconds * SECOND)))
        if count < 0:
            raise DDSException(count, "while the gate was waiting")
        return [number for number in self._found[:count] if number]


def _named(qos: Qos, user: str) -> Qos:
    """Return the QoS of an end point with this text as its user data; unchanged if the text is empty."""
    return qos + Qos(Policy.Userdata(user.encode())) if user else qos


class TopicWriter:
    """Writes messages of one topic."""

    def __init__(
        self, participant: DomainParticipant, topic: str, type_: type[IdlStruct], qos: Qos, user: str = ""
    ) -> None:
        self.entity: Any = DataWriter(participant, Topic(participant, topic, type_), _named(qos, user))
        self.entity.set_status_mask(DDSStatus.PublicationMatched)

    def write(self, data: bytes) -> None:
        """Write a message. Raises `DDSException`."""
        status = ddspy_write(self.entity._ref, data + bytes(-len(data) % WORD))
        if status < 0:
            raise DDSException(status, "while a message was written")

    def changed(self) -> None:
        """Reset the status that says that the matching readers have changed."""
        self.entity.get_publication_matched_status()

    def readers(self) -> Iterator[Any]:
        """Yield the discovery data of the matching readers."""
        for handle in self.entity.get_matched_subscriptions():
            found = self.entity.get_matched_subscription_data(handle)
            if found is not None:
                yield found


class TopicReader:
    """Reads messages of one topic."""

    def __init__(
        self, participant: DomainParticipant, topic: str, type_: type[IdlStruct], qos: Qos, user: str = ""
    ) -> None:
        self.entity: Any = DataReader(participant, Topic(participant, topic, type_), _named(qos, user))
        self.entity.set_status_mask(DDSStatus.SubscriptionMatched)
        self.condition = ReadCondition(self.entity, _ANY)

    def take(self) -> list[tuple[bytes, int]]:
        """Return at most `AT_ONCE` messages that have arrived, each with the handle of its writer.

        Raises `DDSException`.
        """
        taken = ddspy_take(self.entity._ref, _ANY, AT_ONCE)
        if isinstance(taken, int):
            raise DDSException(taken, "while messages were taken")
        return [(data, info.publication_handle) for data, info in taken if info.valid_data]

    def changed(self) -> None:
        """Reset the status that says that the matching writers have changed."""
        self.entity.get_subscription_matched_status()

    def handles(self) -> set[int]:
        """Return the handles of the matching writers as unsigned numbers, as messages have them."""
        return {handle & UNSIGNED for handle in self.entity.get_matched_publications()}

    def writers(self) -> Iterator[Any]:
        """Yield the discovery data of the matching writers."""
        for handle in self.entity.get_matched_publications():
            found = self.entity.get_matched_publication_data(handle)
            if found is not None:
                yield found


def key_of(endpoint: Any) -> str:
    """Return a key that reader and writer of one client share: `clientid` in their user data, else the participant."""
    for policy in endpoint.qos:
        if isinstance(policy, Policy.Userdata):
            for entry in bytes(policy.data).split(b";"):
                if entry.startswith(b"clientid="):
                    return entry.decode("ascii", "replace")
    return str(endpoint.participant_key)
