"""`exover lsp` as an editor has it: from a key to what is wrong with the text."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
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

    def processor(self) -> float | None:
        """Return the milliseconds of the processor that the server has had; None where the system does not say."""
        stat = Path(f"/proc/{self.process.pid}/stat")
        if not stat.is_file():
            return None
        ticks = stat.read_text().rpartition(")")[2].split()[11:13]
        return 1000 * sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")

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
            place = text.index("\n", len(text) // 3)
            session.diagnostics(text)
            before = session.processor()
            # A key in the first half, each time another one: nothing is known of the text yet.
            found = [session.diagnostics(text[:place] + "\n" * (n + 1) + text[place:]) for n in range(2 * rounds)]
            after = session.processor()
            assert all(bool(told) == bool(mistakes) for _, told in found), what
            lines = f"editor: diagnostics of {text.count(chr(10))} lines, {what}"
            yield Row(lines, median(took for took, _ in found), "ms", LIMIT)
            if before is not None and after is not None:
                yield Row(f"{lines}, processor", (after - before) / len(found), "ms", LIMIT)
    finally:
        session.end()
