"""`exover lsp` as an editor has it: from a key to what is wrong with the text."""

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from statistics import median
from typing import Any

from benchmarks import families
from benchmarks.measure import ROOT, Row

MODULES = 35
LIMIT = 150.0
URI = "file:///nowhere/coupled.exo"


class Session:
    """A session with the server, without checks in the background; messages are sent and read as they stand."""

    def __init__(self) -> None:
        command = [sys.executable, "-m", "exover", "lsp"]
        self.process = subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.send(
            "initialize", {"capabilities": {}, "initializationOptions": {"checkSeconds": 0}, "processId": None}, 1
        )
        while self.read().get("id") != 1:
            pass
        self.send("initialized", {})
        self.version = 0

    def send(self, method: str, params: Any, number: int | None = None) -> None:
        """Send a request with a number, or a notification."""
        message = {"jsonrpc": "2.0", "method": method, "params": params} | ({} if number is None else {"id": number})
        body = json.dumps(message).encode()
        assert self.process.stdin
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))
        self.process.stdin.flush()

    def read(self) -> dict[str, Any]:
        """Return the next message."""
        assert self.process.stdout
        length = 0
        while line := self.process.stdout.readline().strip():
            if line.lower().startswith(b"content-length:"):
                length = int(line.partition(b":")[2])
        found: dict[str, Any] = json.loads(self.process.stdout.read(length))
        return found

    def diagnostics(self, text: str) -> tuple[float, list[Any]]:
        """Return the milliseconds from sending a text to what is wrong with it, and that."""
        self.version += 1
        document = {"uri": URI, "version": self.version}
        begin = time.perf_counter()
        if self.version == 1:
            self.send("textDocument/didOpen", {"textDocument": document | {"languageId": "exo", "text": text}})
        else:
            self.send("textDocument/didChange", {"textDocument": document, "contentChanges": [{"text": text}]})
        while True:
            message = self.read()
            if (
                message.get("method") == "textDocument/publishDiagnostics"
                and message["params"]["version"] == self.version
            ):
                return 1000 * (time.perf_counter() - begin), message["params"]["diagnostics"]

    def end(self) -> None:
        """Close the pipe, which ends the server."""
        assert self.process.stdin
        self.process.stdin.close()
        self.process.wait(60)
        assert self.process.stdout
        self.process.stdout.close()


def texts() -> dict[str, tuple[str, int]]:
    """Return a spec of 1 000 lines with and without a mistake in its middle, and how many mistakes are told of it."""
    spec = families.coupled(MODULES)
    middle = spec.index("\n", len(spec) // 2)
    return {
        "without a mistake": (spec, 0),
        "with an unknown name": (spec.replace("check free: mode", "check free: mod", 1), 1),
        "half a statement": (f"{spec[:middle]} mut{spec[middle:]}", 1),
    }


def keys(rounds: int) -> Iterator[Row]:
    """Yield how long it takes after a key until diagnostics of 1 000 lines are there."""
    session = Session()
    try:
        for what, (text, mistakes) in texts().items():
            session.diagnostics(text)
            found = [session.diagnostics(text + "\n" * number) for number in range(rounds)]
            assert all(bool(told) == bool(mistakes) for _, told in found), what
            lines = text.count("\n")
            yield Row(f"editor: diagnostics of {lines} lines, {what}", median(took for took, _ in found), "ms", LIMIT)
    finally:
        session.end()
