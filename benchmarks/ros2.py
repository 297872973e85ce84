"""The gate of ROS 2: its own time for a goal, what it adds on DDS beside a relay that only copies, and 10 000 goals."""

import os
import struct
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.measure import ROOT, Row
from exover.gate.binding import Binding
from exover.gate.gate import Gate, checker_of
from exover.gate.journal import JournalFile, stamped
from exover.gate.reading import read_binding
from exover.model.model import Model
from exover.pipeline import build, load
from exover.source import Source

FOLDER = ROOT / "examples" / "nav2_docking"
TYPE = "nav2_msgs/action/NavigateToPose"
OUTER, INNER = "/navigate_to_pose", "/gated/navigate_to_pose"
GOALS = 10_000
DOMAIN = 71
LOOPBACK = """<CycloneDDS><Domain>
<General><Interfaces><NetworkInterface name="lo"/></Interfaces><AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""
MARK = b"thebench"


def installed() -> bool:
    """Return whether the extra `exover[ros2]` is there."""
    return find_spec("cyclonedds") is not None and find_spec("rosbags") is not None


def _robot() -> tuple[Model, Binding]:
    model = load(Source("nav2_docking.exo", (FOLDER / "nav2_docking.exo").read_text("utf-8"))).model
    assert model is not None
    binding, mistakes = read_binding(Source("nav2_docking.bind.toml", _bind()), model)
    assert binding is not None, mistakes
    return model, binding


def _bind() -> str:
    """Return the binding with navigation alone, which does not run at the start: there is nobody else."""
    text = (FOLDER / "nav2_docking.bind.toml").read_text("utf-8")
    head, goal, rest = (text.index(each) for each in ("[watch.", '[request."base.navigate"]', '[request."base.dock"]'))
    return text[:head].replace("\nwait", '\nstart = "idle"\nwait') + text[goal:rest]


# ---- its own time ----


def own(rounds: int) -> Iterator[Row]:
    """Yield the microseconds from a goal to the server's request, plus those from its answer to that of the client."""
    from exover.gate.ros2 import cdr
    from exover.gate.ros2.checking import mistakes
    from exover.gate.ros2.files import finder
    from exover.gate.ros2.interfaces import Interfaces
    from exover.gate.ros2.names import Port
    from exover.gate.ros2.proxy import Ros2Proxy

    model, binding = _robot()
    types = Interfaces(finder([str(FOLDER / "interfaces")], {}))
    assert not list(mistakes(binding, types, apart=False))
    checker, reason = checker_of(model, build(model).tables)
    sent: dict[Port, tuple[float, bytes]] = {}

    def send(port: Port, data: bytes, peer: int) -> None:
        sent[port] = time.perf_counter(), data

    with tempfile.TemporaryDirectory() as folder:
        journal = JournalFile(str(Path(folder) / "log.jsonl"), print)
        gate = Gate(model, binding, checker, time.monotonic, stamped(journal))
        proxy = Ros2Proxy(gate, types, send, print, lambda: cdr.Stamp(1, 0), lambda: os.urandom(16), b"the gate")
        proxy.start()
        for bound in binding.requests:
            name = f"/{bound.inner}"
            proxy.servers("action", name, frozenset({"server"}))
            question = Port("inner", name, "cancel_goal")
            idle = cdr.service(sent[question][1][cdr.BODY : cdr.HEAD], cdr.cancel_reply(cdr.CANCEL_UNKNOWN, ()))
            proxy.take(question, idle, 2)
        assert gate.state.started
        goal, times = types.write(f"{TYPE}_Goal"), []
        result = types.write(f"{TYPE}_GetResult_Response", [(("status",), cdr.SUCCEEDED)])
        for number in range(1, rounds * 1000):
            asked = cdr.service(MARK + bytes(8), number.to_bytes(16, "big") + goal)
            begin = time.perf_counter()
            proxy.take(Port("outer", OUTER, "send_goal"), asked, 1)
            there, data = sent[Port("inner", INNER, "send_goal")]
            answer = cdr.service(data[4:20], cdr.goal_reply(True, cdr.Stamp(1, 0)))
            again = time.perf_counter()
            proxy.take(Port("inner", INNER, "send_goal"), answer, 2)
            times.append(there - begin + sent[Port("outer", OUTER, "send_goal")][0] - again)
            _, data = sent[Port("inner", INNER, "get_result")]
            proxy.take(Port("inner", INNER, "get_result"), cdr.service(data[4:20], result), 2)
        assert not gate.state.slots
        journal.close()
    note = f"99 of 100 within {sorted(times)[len(times) * 99 // 100] * 1e6:.0f} us"
    yield Row(
        "gate: its own code for a goal of ROS 2 and its answer", median(times) * 1e6, "us", 50, note=reason or note
    )


# ---- on DDS ----


class Ends:
    """The services of an action on DDS, asked or served; numbers of what is waited for begin behind `others`."""

    def __init__(self, name: str, asks: bool, others: "Ends | None" = None) -> None:
        from cyclonedds.domain import DomainParticipant

        from exover.gate.ros2 import endpoints
        from exover.gate.ros2.files import finder
        from exover.gate.ros2.idl import SampleTypes
        from exover.gate.ros2.interfaces import CANCEL, Interfaces
        from exover.gate.ros2.names import Port, reply_topic, request_topic

        self.types = Interfaces(finder([str(FOLDER / "interfaces")], {}))
        self.types.load(TYPE)
        samples, participant = SampleTypes(self.types), DomainParticipant(DOMAIN)
        self.waiting: endpoints.Waiting = others.waiting if others else endpoints.Waiting()
        self.ends: list[tuple[str, Any, Any]] = []
        taken = len(others.ends) if others else 0
        of: dict[Any, str] = {"send_goal": f"{TYPE}_SendGoal", "cancel_goal": CANCEL, "get_result": f"{TYPE}_GetResult"}
        for number, (part, type_) in enumerate(of.items(), taken + 1):
            port = Port("outer", name, part)
            request = request_topic(port), samples.service(f"{type_}_Request")
            reply = reply_topic(port), samples.service(f"{type_}_Response")
            come, go = (reply, request) if asks else (request, reply)
            reader = endpoints.TopicReader(participant, *come, endpoints.REQUESTS)
            self.ends.append((part, reader, endpoints.TopicWriter(participant, *go, endpoints.REPLIES)))
            self.waiting.watch(reader.condition, number)

    def there(self) -> bool:
        """Return whether the other side is there."""
        return all(list(writer.readers()) and list(reader.writers()) for _, reader, writer in self.ends)


def serve() -> None:
    """Answer every goal at once, and say at the end of the input how many came, and whether one came twice."""
    from exover.gate.ros2 import cdr

    ends, seen = Ends(INNER, asks=False), Counter[bytes]()
    result = ends.types.write(f"{TYPE}_GetResult_Response", [(("status",), cdr.SUCCEEDED)])
    bodies = {
        "send_goal": cdr.goal_reply(True, cdr.Stamp(1, 0)),
        "cancel_goal": cdr.cancel_reply(cdr.CANCEL_OK, ()),
        "get_result": result,
    }
    print("ready", flush=True)
    os.set_blocking(0, False)
    while not _told_to_end():
        for number in ends.waiting.ready(0.2):
            part, reader, writer = ends.ends[number - 1]
            for data, _ in reader.take():
                writer.write(cdr.service(data[4:20], bodies[part]))
                if part == "send_goal":
                    seen[data[20:36]] += 1
    print(len(seen), max(seen.values(), default=0), flush=True)


def _told_to_end() -> bool:
    """Return whether standard input, which blocks nobody, has said anything or has ended."""
    try:
        os.read(0, 1)
    except BlockingIOError:
        return False
    return True


def relay() -> None:
    """Copy what clients ask to the server, and its answers back: what any gate in Python costs at least on DDS."""
    clients = Ends(OUTER, asks=False)
    servers = Ends(INNER, asks=True, others=clients)
    ways = [(each[1], other[2]) for each, other in zip(clients.ends, servers.ends, strict=True)]
    ways += [(other[1], each[2]) for each, other in zip(clients.ends, servers.ends, strict=True)]
    print("ready", flush=True)
    os.set_blocking(0, False)
    while not _told_to_end():
        for number in clients.waiting.ready(0.2):
            reader, writer = ways[number - 1]
            for data, _ in reader.take():
                writer.write(data)


class Client:
    """Asks one thing after another."""

    def __init__(self, name: str) -> None:
        self.ends = Ends(name, asks=True)
        self._numbers = count(1)
        end = time.monotonic() + 60
        while not self.ends.there():
            assert time.monotonic() < end, f"there is no server of {name}"
            time.sleep(0.01)
        time.sleep(0.5)  # the other side has to know us as well, and no message says that it does

    def ask(self, at: int, body: bytes) -> tuple[float, bytes]:
        """Ask the service of this number; return the seconds that it took, and the body of its answer."""
        from exover.gate.ros2 import cdr

        header = MARK + struct.pack("<q", next(self._numbers))
        _, reader, writer = self.ends.ends[at]
        begin = time.perf_counter()
        writer.write(cdr.service(header, body))
        while True:
            assert self.ends.waiting.ready(30), "no answer"
            for data, _ in reader.take():
                if data[4:20] == header:
                    return time.perf_counter() - begin, data[20:]


def _goals(client: Client, number: int) -> list[float]:
    """Return how long goals took to be accepted, each of which has succeeded."""
    body, times = client.ends.types.write(f"{TYPE}_Goal"), []
    for _ in range(number):
        id = os.urandom(16)
        took, answer = client.ask(0, id + body)
        assert answer[0] == 1, "a goal was refused"
        times.append(took)
        assert client.ask(2, id)[1][0] == 4, "a goal has not succeeded"
    return times


def added() -> Iterator[Row]:
    """Yield the milliseconds that the gate and a mere relay add to the answer to a goal, and how many are amiss."""
    os.environ["CYCLONEDDS_URI"] = LOOPBACK
    with _helper("serve") as server:
        direct = _goals(Client(INNER), 2000)
        with _helper("relay"):
            relayed = _goals(Client(OUTER), 2000)
        through = _through(GOALS)
        assert server.stdin and server.stdout
        server.stdin.close()
        came, most = map(int, server.stdout.read().split())
    alone, copied, with_it = (median(times[500:]) * 1000 for times in (direct, relayed, through))
    note = f"{alone:.2f} ms without it, {with_it:.2f} ms with it"
    yield Row("gate: added to the answer to a goal of ROS 2", with_it - alone, "ms", 0.3, note=note)
    note = "a process in Python that copies the messages, and does nothing else"
    yield Row("relay: added to the same", copied - alone, "ms", note=note)
    lost = GOALS + len(direct) + len(relayed) - came + (most - 1)
    yield Row("gate: lost or doubled of 10 000 goals of ROS 2", lost, "goals", 0)


@contextmanager
def _helper(does: str) -> Iterator["subprocess.Popen[bytes]"]:
    """Run a function of this module in a process, until its input ends."""
    command = [sys.executable, "-m", "benchmarks.ros2", does]
    with subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout and process.stdout.readline() == b"ready\n"
        yield process


def _through(number: int) -> list[float]:
    """Return how long goals took to be accepted through a gate."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "bind.toml").write_text(_bind())
        spec = (FOLDER / "nav2_docking.exo").read_text("utf-8")
        (folder / "spec.exo").write_text(spec)
        options = ["--bind", "bind.toml", "--interfaces", str(FOLDER / "interfaces"), "--domain", str(DOMAIN)]
        command = [sys.executable, "-m", "exover", "gate", "ros2", "spec.exo", *options, "--log", "log.jsonl"]
        with subprocess.Popen([*command, "--unchecked"], cwd=folder, stderr=subprocess.DEVNULL) as gate:
            try:
                client = Client(OUTER)
                body = client.ends.types.write(f"{TYPE}_Goal")
                _until(lambda: client.ask(0, os.urandom(16) + body)[1][0] == 1)
                return _goals(client, number - 1)
            finally:
                gate.terminate()


def _until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end


if __name__ == "__main__":
    {"serve": serve, "relay": relay}[sys.argv[1]]()
