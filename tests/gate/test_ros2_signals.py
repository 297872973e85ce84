"""A signal waits until what is being done is done."""

import signal

import pytest

from exover.gate.ros2.signals import DeferredSignals


def test_a_signal_is_raised_at_the_end_and_a_second_one_at_once() -> None:
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), DeferredSignals() as signals:
        signal.raise_signal(signal.SIGINT)
        assert signals.heard == signal.SIGINT
    with pytest.raises(KeyboardInterrupt), DeferredSignals():
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        raise AssertionError("it was kept")
    with DeferredSignals() as signals:
        assert not signals.heard
    assert signal.getsignal(signal.SIGINT) is before
