"""The progress line: on terminals only, and gone at the end."""

import io

import pytest

from exover.cli.streams import ProgressLine


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_the_line_is_replaced_and_erased(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    with pytest.raises(KeyError), ProgressLine() as progress:
        progress("safety drive")
        progress("x" * 500)
        raise KeyError
    erase = "\r\x1b[K"
    assert terminal.getvalue() == f"{erase}safety drive{erase}{'x' * 79}{erase}"


@pytest.mark.parametrize("stream", [io.StringIO(), None])
def test_nothing_is_shown_elsewhere(monkeypatch: pytest.MonkeyPatch, stream: io.StringIO | None) -> None:
    monkeypatch.setattr("sys.stderr", stream)
    with ProgressLine() as progress:
        progress("safety drive")
    assert stream is None or not stream.getvalue()
