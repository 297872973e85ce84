"""What says that a slot is idle or reported: found for all slots in one pass over the events."""

from collections.abc import Iterator

from exover.engines.aig.encoding.encoder import EncodedEvent, Encoding
from exover.engines.aig.liveness.k_liveness import fair_reports
from exover.model.property import NO_PROPERTIES
from tests.support.engines import model_of
from tests.support.small import compiled


class Counted(list[EncodedEvent]):
    """Events that count how often they are gone through."""

    passes = 0

    def __iter__(self) -> Iterator[EncodedEvent]:
        self.passes += 1
        return super().__iter__()


def test_the_events_are_gone_through_once() -> None:
    requests = " ".join(f"request r{n}(){' instances 2' if n == 3 else ''};" for n in range(9))
    encoding = Encoding(compiled(model_of(f"spec s; module m {{ {requests} }}")), NO_PROPERTIES)
    encoding.events = counted = Counted(encoding.events)
    assert len(fair_reports(encoding)) == 10
    assert counted.passes == 1
