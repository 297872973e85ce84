"""Streams, signals and processes: who goes away, who does not go, who does not read."""

import json
import math
import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from exover.gate.mcp.session import McpSession

SPEC = """spec s;
module m { request go(); request halt() { interrupts m.go; } }
"""
BIND = """[gate]
spec = "s"
start = "idle"
wait = 5
stop = 1
pass = ["noise"]
[request."m.go"]
tool = "go"
cancel = { tool = "stop", ends = true }
[request."m.halt"]
tool = "halt"
cancel = { tool = "stop", ends = true }
"""
SERVER = """
import json, sys, time
log = open("server.txt", "w")
for line in sys.stdin.buffer:
    asked = json.loads(line)
    name = asked.get("params", {}).get("name")
    print(name, file=log, flush=True)
    if name == "die":
        sys.exit(3)
    if name == "noise":
        result = {"content": [{"type": "text", "text": "x" * (1000000 if "loud" in sys.argv else 10)}]}
    else:
        result = {"content": []}
    if name != "go" and "id" in asked:
        sys.stdout.buffer.write(json.dumps({"jsonrpc": "2.0", "id": asked["id"], "result": result}).encode() + b"\\n")
        sys.stdout.buffer.flush()
print("end", file=log, flush=True)
if "stay" in sys.argv:
    time.sleep(600)
"""


def written(folder: Path, *server: str, bind: str = BIND) -> list[str]:
    """Write the files of a gate, and return the command that starts it."""
    for name, text in (("s.exo", SPEC), ("b.toml", bind), ("server.py", SERVER)):
        (folder / name).write_text(text)
    options = ["s.exo", "--bind", "b.toml", "--unchecked", "--log", "log"]
    return [sys.executable, "-m", "exover", "gate", "mcp", *options, "--", sys.executable, "server.py", *server]


class Session:
    """A gate as a process, spoken to line by line."""

    def __init__(self, folder: Path, *server: str, bind: str = BIND) -> None:
        self.folder = folder
        command = written(folder, *server, bind=bind)
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, cwd=folder, stdin=pipe, stdout=pipe, stderr=pipe, bufsize=0)

    def call(self, id: int, name: str) -> None:
        assert self.process.stdin
        body = {"jsonrpc": "2.0", "id": id, "method": "tools/call", "params": {"name": name}}
        self.process.stdin.write(json.dumps(body).encode() + b"\n")

    def notify(self, method: str) -> None:
        assert self.process.stdin
        self.process.stdin.write(json.dumps({"jsonrpc": "2.0", "method": method}).encode() + b"\n")

    def line(self) -> dict[str, Any]:
        assert self.process.stdout and select.select([self.process.stdout], [], [], 60)[0], "it says nothing"
        found: dict[str, Any] = json.loads(self.process.stdout.readline())
        return found

    def running(self) -> None:
        """Let a motion run."""
        self.call(1, "go")
        self.call(2, "noise")
        assert self.line()["id"] == 2

    def ended(self) -> tuple[int, str]:
        """Return the status of the gate and what it has complained of."""
        try:
            _, told = self.process.communicate(timeout=60)
        finally:
            self.process.kill()
        return self.process.returncode, told.decode()

    def events(self) -> list[Any]:
        return [json.loads(line).get("event") for line in (self.folder / "log").read_text().splitlines()]


ABORTED = [{"abort": "m.go", "instance": 0}, {"report": "m.go", "instance": 0, "outcome": "interrupted"}]


def test_a_client_that_closes_its_end_ends_everything(tmp_path: Path) -> None:
    session = Session(tmp_path)
    session.running()
    status, told = session.ended()
    assert (status, told) == (0, "") and session.events()[1:] == ABORTED
    assert (tmp_path / "server.txt").read_text().split() == ["go", "noise", "stop", "end"]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_stops_what_runs(tmp_path: Path, number: signal.Signals) -> None:
    session = Session(tmp_path)
    session.running()
    session.process.send_signal(number)
    assert session.ended()[0] == 128 + number and session.events()[1:] == ABORTED


def test_a_server_that_does_not_end_is_ended(tmp_path: Path) -> None:
    session = Session(tmp_path, "stay")
    session.running()
    begun = time.monotonic()
    assert session.ended()[0] == 0 and time.monotonic() - begun < 30


def test_what_does_not_stop_is_told_by_the_status(tmp_path: Path) -> None:
    session = Session(tmp_path, bind=BIND.replace('tool = "stop", ends = true', 'tool = "stop"'))
    session.running()
    status, told = session.ended()
    assert status == 1 and told.endswith("exover gate: m.go[0] still ran when the gate gave up waiting for its end\n")


def test_a_server_that_dies_while_the_client_stays(tmp_path: Path) -> None:
    session = Session(tmp_path, bind=BIND.replace('["noise"]', '["noise", "die"]'))
    session.running()
    session.call(3, "die")
    answers = {answer["id"]: answer for answer in (session.line(), session.line())}
    assert answers[1]["result"]["_meta"]["exover/rule"] == "unavailable" and answers[3]["error"]["code"] == -32000
    session.call(4, "halt")
    assert session.line()["result"]["_meta"]["exover/rule"] == "unavailable"
    status, told = session.ended()
    assert status == 1 and "module-gone m.go[0]" in told


def test_a_client_that_does_not_read_holds_nobody_up(tmp_path: Path) -> None:
    session = Session(tmp_path, "loud")
    for number in range(75):  # megabytes
        session.call(number, "noise")
    deadline = time.monotonic() + 60
    while session.process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.1)
    gone = session.process.poll()
    session.ended()
    assert gone == 0


def test_who_does_not_read_standard_error_holds_nobody_up(tmp_path: Path) -> None:
    session = Session(tmp_path)
    session.running()
    for number in range(2000):
        session.notify(f"x/{number}")  # more than a pipe holds
    session.call(3, "halt")
    assert {session.line()["id"], session.line()["id"]} == {1, 3}
    status, told = session.ended()
    assert status == 0 and told.count(" without an id\n") == 2000


def test_a_server_is_ended_even_if_what_stops_fails(tmp_path: Path) -> None:
    class Failing:
        """A proxy that cannot stop what runs, which the server ends a moment later."""

        due, left = math.inf, 2
        gate = SimpleNamespace(binding=SimpleNamespace(longest_stop=60))
        given_up = False

        @property
        def active(self) -> bool:
            self.left -= 1
            return self.left >= 0

        def start(self) -> None: ...

        def client_gone(self) -> None:
            raise ValueError("no stop")

        def give_up(self) -> None:
            self.given_up = True

    reading, writing = os.pipe()
    os.close(writing)
    answers, to_client = os.pipe()
    (tmp_path / "server.py").write_text(f"import sys; sys.stdin.read(); open({str(tmp_path / 'ended')!r}, 'w')")
    session = McpSession([sys.executable, str(tmp_path / "server.py")], (reading, to_client))
    proxy: Any = Failing()
    with pytest.raises(ValueError, match="no stop"):
        session.run(proxy, 1024)
    assert proxy.given_up and proxy.left < 0 and (tmp_path / "ended").exists()
    for file in (reading, answers):
        os.close(file)
    assert session._server.stdout
    session._server.stdout.close()


def test_without_streams_nothing_starts(tmp_path: Path) -> None:
    closed = subprocess.run(
        ["sh", "-c", 'exec "$0" "$@" <&-', *written(tmp_path)],
        cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    assert closed.returncode == 2 and "standard input" in closed.stderr
