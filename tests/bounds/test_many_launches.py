"""Bounds of specs with many launch rules: what all events wake alike is followed once."""

import heapq

import pytest

from exover.bounds import settling
from exover.bounds.events import bounds
from tests.support.engines import model_of
from tests.support.small import compiled


def test_what_events_wake_alike_is_followed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    count, followed = 40, [0]
    requests = " ".join(f"request r{n}();" for n in range(count))
    launches = "\n".join(f"launch l{n}: m.r{n}() when e == {n % 9};" for n in range(count))
    text = f"spec s; poster e: int in 0 .. 9 = 0; module m {{ {requests} }}\n{launches}"

    def counted(heap: list[int]) -> int:
        followed[0] += 1
        return heapq.heappop(heap)

    monkeypatch.setattr(settling, "heappop", counted)
    bounds(compiled(model_of(text)).tables)
    assert count <= followed[0] < 3 * count
