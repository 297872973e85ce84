"""`exover gate ros2` between an action client and an action server of the crate ros2-client, which `make ros2` builds.

All of it runs in a network namespace of its own where that is permitted, else on the loopback.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from time import sleep

import pytest

pytest.importorskip("cyclonedds", reason="the extra exover[ros2] is not installed")
pytest.importorskip("rosbags", reason="the extra exover[ros2] is not installed")

from tests.gate.yard import BIND, INTERFACES, SPEC

PEERS = os.environ.get("EXOVER_ROS2_PEERS", "")
GOALS = int(os.environ.get("EXOVER_ROS2_GOALS", "200"))
if not PEERS:
    pytest.skip("no peers are built: make ros2 builds them and runs this", allow_module_level=True)

DOMAIN = 45
BINDING = (
    '[gate]\nspec = "yard"\nwait = 30\nstart = "idle"\n'
    + BIND[BIND.index('[request."base.drive"]') : BIND.index('[request."base.halt"]')]
)
"""Without the battery, of which no peer tells. A server of ros2-client answers "rejected" to a cancel of all goals
where nothing runs, so it cannot be asked what does."""
LOOPBACK = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces>
</General><Discovery><LeaseDuration>2s</LeaseDuration></Discovery></Domain></CycloneDDS>"""


SILENCE = 30 + GOALS / 20
"""Seconds after which a peer counts as silent: far more than all goals take."""


class Peer:
    """A process that is told lines and says lines."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        self.process = process
        self._told: list[str] = []
        self._lines: SimpleQueue[str] = SimpleQueue()
        Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self.process.stdout
        for line in self.process.stdout:
            self._lines.put(line.strip())
        self._lines.put("")

    def say(self, line: str) -> None:
        assert self.process.stdin
        self._told.append(line)
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def heard(self) -> str:
        """Return the next line that it says, empty at its end."""
        try:
            line = self._lines.get(timeout=SILENCE)
        except Empty:
            raise AssertionError(f"no answer in {SILENCE} s; so far: {self._told}") from None
        self._told.append(f"-> {line}")
        return line

    def ask(self, line: str) -> str:
        """Tell it a line, and return its answer."""
        self.say(line)
        return self.heard()

    def end(self) -> str:
        """End its input, and return the last that it says."""
        assert self.process.stdin
        self.process.stdin.close()
        last = self.heard()
        self.process.wait(60)
        return last


class Net:
    """Processes that reach nobody but each other."""

    def __init__(self, stack: ExitStack, folder: Path) -> None:
        self._stack = stack
        self._folder = folder
        self._inside: list[str] = []
        self._errors = stack.enter_context((folder / "stderr").open("w"))
        keeper = ["unshare", "--net", "sh", "-c", "ip link set lo up multicast on && echo up && exec cat"]
        if shutil.which("unshare") and shutil.which("ip"):
            found = self._popen(keeper)
            if found.heard() == "up":
                self._inside = ["nsenter", "--net", "--target", str(found.process.pid)]

    def _popen(self, command: list[str]) -> Peer:
        process = self._stack.enter_context(
            subprocess.Popen(
                command,
                cwd=self._folder,
                text=True,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                env=os.environ | {"CYCLONEDDS_URI": LOOPBACK},
            )
        )
        self._stack.callback(process.kill)
        return Peer(process)

    def peer(self, *words: object) -> Peer:
        found = self._popen([*self._inside, PEERS, *map(str, words)])
        assert found.heard() == "ready", (self._folder / "stderr").read_text()
        return found

    def gate(self) -> Peer:
        (self._folder / "yard.exo").write_text(SPEC)
        (self._folder / "yard.bind.toml").write_text(BINDING)
        command = [
            sys.executable,
            "-m",
            "exover",
            "gate",
            "ros2",
            "yard.exo",
            "--bind",
            "yard.bind.toml",
            "--unchecked",
        ]
        options = ["--interfaces", str(INTERFACES), "--domain", str(DOMAIN), "--log", "log.jsonl"]
        return self._popen([*self._inside, *command, *options])

    def log(self) -> str:
        return (self._folder / "log.jsonl").read_text()


@pytest.fixture
def net(tmp_path: Path) -> Iterator[Net]:
    with ExitStack() as stack:
        yield Net(stack, tmp_path)


def begun(client: Peer) -> None:
    """Ask until the gate has started: what is refused by then never reached the server."""
    while client.ask("many 1") != "well 1 other 0 refused 0":
        pass


def test_launch_reject_kill_and_death(net: Net) -> None:
    server = net.peer("server", DOMAIN, "/gated/drive")
    net.gate()
    client = net.peer("client", DOMAIN, "/drive")
    begun(client)
    assert client.ask("goal 2.5") == "accepted" and client.ask("result 0") == "Succeeded 2.5"
    assert client.ask("goal 9.5") == "refused"  # by the server
    assert client.ask("goal 11") == "refused"  # by the gate: out of range
    assert client.ask("goal nan") == "refused"
    assert client.ask("goal -1") == "accepted"  # number 4: it runs on
    other = net.peer("client", DOMAIN, "/drive")
    assert other.ask("goal 1.5") == "accepted"  # it waits for what it kills
    assert client.ask("result 4") == "Canceled -1" and other.ask("result 0") == "Succeeded 1.5"
    assert client.ask("goal -2") == "accepted" and client.ask("cancel 5") == "None"
    assert client.ask("result 5") == "Canceled -2"
    assert client.ask("goal -3") == "accepted"
    client.say("result 6")
    server.end()
    assert client.heard() == "Aborted 0" and client.ask("goal 1") == "refused"
    assert '"rule": "unavailable"' in net.log() and '"alarm": "module-gone"' in net.log()
    again = net.peer("server", DOMAIN, "/gated/drive")
    begun(client)
    assert again.end() == "done 1 refused 0 cancelled 0"


def test_a_client_that_dies_stops_what_it_runs(net: Net) -> None:
    server = net.peer("server", DOMAIN, "/gated/drive")
    net.gate()
    client, other = net.peer("client", DOMAIN, "/drive"), net.peer("client", DOMAIN, "/drive")
    begun(client)
    assert other.ask("goal -1") == "accepted"
    assert other.process.stdin
    other.process.stdin.close()
    other.process.wait(60)
    for _ in range(1200):  # what says that a client is gone may be lost: then its lease must end
        if '"interrupted"' in net.log():
            break
        sleep(0.1)
    assert client.ask("goal -2") == "accepted" and client.ask("cancel 0") == "None"
    assert client.ask("result 0") == "Canceled -2"
    assert server.end() == "done 1 refused 0 cancelled 2"


def test_no_goal_is_lost_or_doubled(net: Net) -> None:
    server = net.peer("server", DOMAIN, "/gated/drive")
    net.gate()
    client = net.peer("client", DOMAIN, "/drive")
    begun(client)
    assert client.ask(f"many {GOALS}") == f"well {GOALS} other 0 refused 0"
    assert server.end() == f"done {GOALS + 1} refused 0 cancelled 0"
    assert net.log().count('"launch"') == GOALS + 1


def test_two_clients_at_once(net: Net) -> None:
    server = net.peer("server", DOMAIN, "/gated/drive")
    net.gate()
    clients = net.peer("client", DOMAIN, "/drive"), net.peer("client", DOMAIN, "/drive")
    begun(clients[0])
    each = GOALS // 2
    for client in clients:
        client.say(f"many {each}")
    said = [client.heard().split() for client in clients]
    well, other, refused = (sum(int(words[at]) for words in said) for at in (1, 3, 5))
    assert well + other + refused == 2 * each and well
    done = int(server.end().split()[1])
    assert net.log().count('"launch"') == done + net.log().count('"failed"')
