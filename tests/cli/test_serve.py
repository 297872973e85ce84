"""`exover serve`: clients at a socket, by lines and by records, one state for all."""

import errno
import json
import os
import resource
import signal
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from random import Random
from time import monotonic, sleep
from typing import Any

import pytest

from exover.cli import serve as command
from exover.cli.status import CliError
from exover.model.event import Action, Event, Killed
from exover.model.model import Model
from exover.model.wire_reading import MAX_LINE
from exover.pipeline import load
from exover.run import serve
from exover.run.simulate import ReferenceEngine
from exover.source import Source
from tests.support.command import COMMAND, environment
from tests.support.events import Stream

SPEC = """spec demo;
enum zone { near, far }
poster speed: real in 0 .. 2 = 0;
poster ok: int in -3 .. 3 = 0 else -3;
resource ink: 10 consumable = 5;
module nd {
    request goto(x: real in -5 .. 5, where: zone, fast: bool) returns (dist: real) fails (blocked, lost) {
        interrupts self;
    }
    request stop();
}
module arm { request move(n: int in -2 .. 9) { consumes ink 3; } }
mutex still: nd.goto, arm.move by wait because "one at a time";
mutex nd.stop over nd.goto;
launch home: nd.stop() when speed > 1 because "too fast";
"""
PATIENCE = 20.0


class Peer:
    """A client that waits for answers."""

    def __init__(self, path: Path, magic: bytes = b"") -> None:
        self.coming = b""
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.settimeout(PATIENCE)
        self.socket.connect(str(path))
        self.socket.sendall(magic)

    def tell(self, *events: dict[str, Any]) -> None:
        self.socket.sendall("".join(f"{json.dumps(event)}\n" for event in events).encode())

    def hear(self) -> dict[str, Any]:
        while b"\n" not in self.coming:
            self._more()
        line, _, self.coming = self.coming.partition(b"\n")
        found: dict[str, Any] = json.loads(line)
        return found

    def ask(self, event: dict[str, Any]) -> list[dict[str, Any]]:
        self.tell(event)
        actions: list[dict[str, Any]] = self.hear()["actions"]
        return actions

    def record(self) -> bytes:
        while len(self.coming) < 4 or len(self.coming) < 4 + struct.unpack("<I", self.coming[:4])[0]:
            self._more()
        (length,) = struct.unpack("<I", self.coming[:4])
        found, self.coming = self.coming[4 : 4 + length], self.coming[4 + length :]
        return found

    def send(self, record: bytes) -> None:
        self.socket.sendall(struct.pack("<I", len(record)) + record)

    def _more(self) -> None:
        data = self.socket.recv(1 << 16)
        if not data:
            raise EOFError
        self.coming += data


class Served:
    """A process that serves a spec, and those that speak to it."""

    def __init__(self, folder: Path, *options: str) -> None:
        (folder / "demo.exo").write_text(SPEC)
        self.peers: list[Peer] = []
        self.path = folder / "sock"
        command = [*COMMAND, "serve", "demo.exo", "--socket", "sock", *options]
        self.process = subprocess.Popen(command, cwd=folder, env=environment(), stderr=subprocess.PIPE, text=True)
        assert self.process.stderr is not None
        self.said = self.process.stderr.readline()

    def peer(self, magic: bytes = b"") -> Peer:
        self.peers.append(Peer(self.path, magic))
        return self.peers[-1]

    def end(self, number: int = signal.SIGTERM) -> int:
        self.process.send_signal(number)
        status = self.process.wait(PATIENCE)
        for peer in self.peers:
            peer.socket.close()
        assert self.process.stderr is not None
        self.process.stderr.close()
        return status


@contextmanager
def here(folder: Path, model: Model, said: list[str]) -> Iterator[serve.CheckerServer]:
    """Give a server of this process, whose turns the test takes, and what it tells of odd clients."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listener:
        listener.bind(str(folder / "sock"))
        listener.listen()
        listener.setblocking(False)
        with closing(serve.CheckerServer(model, ReferenceEngine(model), listener, said.append)) as server:
            yield server


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    found = Served(tmp_path, "--engine", "tables")
    yield found
    if found.process.poll() is None:
        found.end()


@pytest.fixture(scope="module")
def model() -> Model:
    found = load(Source("demo.exo", SPEC)).model
    assert found is not None
    return found


GOTO = {"ask": "nd.goto", "args": {"x": 1, "where": "far", "fast": True}}
MOVE = {"ask": "arm.move", "args": {"n": 3}}


def test_lines_are_answered_as_exover_simulate_answers_them(run, served: Served, model: Model) -> None:
    events = list(Stream(model, 1).lines(200))
    expected = run("simulate", "demo.exo", "-", input="\n".join(events)).stdout.splitlines()
    peer = served.peer()
    peer.socket.sendall("\n".join([*events, "", ""]).encode())
    assert [peer.hear() for _ in expected] == [json.loads(line) for line in expected]
    assert served.said == "exover: note: demo is served at sock by the engine tables\n"


def test_the_emitted_c_decides_if_there_is_a_compiler(tmp_path: Path) -> None:
    served = Served(tmp_path)
    assert "by the engine c" in served.said
    peer = served.peer()
    assert [each.get("launch") for each in peer.ask(GOTO)] == ["nd.goto"]
    assert peer.ask({"observe": "speed", "value": 1.5}) == [
        {"kill": "nd.goto", "instance": 0, "rule": "mutex.2"},
        {"wait": "nd.stop", "rule": "mutex.2", "launch_rule": "home"},
    ]
    assert served.end() == 143


def test_clients_share_one_state_and_listeners_hear_of_all(served: Served) -> None:
    above, below, other = served.peer(), served.peer(), served.peer()
    below.tell({"listen": True})
    assert below.ask({"abort": "nd.goto"})[0]["invalid"] == "nothing-to-abort"
    assert above.ask(GOTO)[0]["launch"] == "nd.goto"
    assert other.ask(MOVE) == [{"wait": "arm.move", "rule": "still", "because": "one at a time"}]
    heard = [below.hear() for _ in range(2)]
    assert [(each["step"], next(iter(each["actions"][0]))) for each in heard] == [(2, "launch"), (3, "wait")]
    assert [next(iter(each)) for each in below.ask({"report": "nd.goto", "outcome": "interrupted"})] == ["launch"]
    above.socket.close()
    late = served.peer()
    assert late.ask(MOVE) == [{"reject": "arm.move", "rule": "busy"}] == below.hear()["actions"]
    below.tell({"listen": False})
    below.ask({"observe": "ok", "value": 1})
    late.ask({"ask": "nd.nothing"})
    below.tell({"observe": "ok", "value": 2})
    assert below.hear() == {"step": 8, "actions": []}


def test_bad_lines_are_answered_and_the_client_stays(served: Served) -> None:
    peer = served.peer()
    peer.socket.sendall(b"what\n\n  \n[1]\n\xff\n" + b"x" * (3 << 20) + b"\n" + json.dumps(GOTO).encode())
    peer.socket.shutdown(socket.SHUT_WR)
    codes = [peer.hear()["actions"][0].get("invalid") for _ in range(5)]
    assert codes == ["bad-event", "bad-event", "bad-event", "bad-event", None]
    with pytest.raises(EOFError):
        peer.hear()


@pytest.mark.parametrize("first", [1, 2, 3])
def test_a_line_that_is_too_long_is_no_event_wherever_it_is_cut(tmp_path: Path, model: Model, first: int) -> None:
    full = json.dumps(GOTO).encode().ljust(MAX_LINE)
    with here(tmp_path, model, []) as server, closing(Peer(tmp_path / "sock").socket) as connected:
        server.turn(PATIENCE)
        (client,) = server.clients.values()
        codes = []
        for pieces in ((b"\r" * first, b" \n"), (b"\r", b"\n")):
            client.coming += full
            for piece in pieces:
                connected.sendall(piece)
                server.turn(PATIENCE)
            codes += [json.loads(line)["actions"][0].get("invalid") for line in connected.recv(1 << 16).splitlines()]
        assert codes == ["bad-event", None]


def test_records_say_what_lines_say(served: Served, tmp_path: Path, model: Model) -> None:
    plain, binary = served.peer(), served.peer(b"EXO1")
    told = json.loads(binary.record())
    assert (told["spec"], [each["name"] for each in told["observables"]]) == ("demo", ["speed", "ok", "ink"])
    assert [each["rule"] for each in told["rules"]][:4] == ["busy", "superseded", "aborted", "abort"]
    plain.tell({"listen": True})
    assert plain.ask({"abort": "nd.goto"})[0]["invalid"] == "nothing-to-abort"  # so it listens by now
    random = Random(2)
    for _ in range(300):
        binary.send(event(told, random))
        line, record = plain.hear(), binary.record()
        assert decoded(told, record) == [line["step"], [undetailed(each) for each in line["actions"]]]


def event(told: dict[str, Any], random: Random) -> bytes:
    """Return a random record, often a wrong one."""
    number = random.randrange(len(told["requests"]) + (random.random() < 0.05))
    request = told["requests"][number % len(told["requests"])]
    match random.randrange(6):
        case 0 | 1:
            return struct.pack("<BH", 0, number) + b"".join(value(each, random) for each in request["args"])
        case 2:
            outcome, status = random.randrange(4), random.choice((0, 1, 2, 65535))
            ending = b"".join(value(each, random) for each in request["results"]) if outcome == 0 else b""
            return struct.pack("<BHHBH", 1, number, 0, outcome, status) + ending
        case 3:
            seen = random.randrange(4)
            return struct.pack("<BH", 2, seen) + value(told["observables"][seen % 3], random)
        case 4:
            return struct.pack("<BHH", 3, number, random.randrange(2))
        case _:
            return random.choice((struct.pack("<BH", 4, number), b"", b"\x09\0\0", b"\x00\0\0" + b"\0" * 5))


def value(kind: dict[str, Any], random: Random) -> bytes:
    if kind["type"] == "real":
        return struct.pack("<d", random.choice((0.5, 1.5, -9.0, float("nan"), -0.0)))
    return struct.pack("<q", random.choice((0, 1, 1, 2, 7, -1)))


def decoded(told: dict[str, Any], record: bytes) -> list[Any]:
    """Return an answer as its line says it, without details."""
    step, count = struct.unpack_from("<QH", record)
    place, actions = 10, []
    for _ in range(count):
        kind, request, slot, rule, origin, code = struct.unpack_from("<BHHIIB", record, place)
        place += 14
        word = ("launch", "wait", "reject", "kill", "violation", "invalid")[kind]
        found: dict[str, Any] = {word: told["requests"][request]["name"] if request < 65535 else None}
        found |= {"instance": slot} if slot < 65535 else {}
        if word == "launch":
            found["args"] = {}
            for each in told["requests"][request]["args"]:
                (number,) = struct.unpack_from("<d" if each["type"] == "real" else "<q", record, place)
                place += 8
                number = bool(number) if each["type"] == "bool" else number
                found["args"][each["name"]] = each["values"][number] if each["type"] == "enum" else number
        if rule != 0xFFFFFFFF and word != "violation":
            found |= told["rules"][rule]
        if word == "violation":
            texts = {key: text for key, text in told["rules"][rule].items() if key != "rule"}
            found = {"violation": told["rules"][rule]["rule"]} | texts
        found |= {"launch_rule": told["rules"][origin]["rule"]} if origin != 0xFFFFFFFF else {}
        actions.append({"invalid": told["codes"][code]} if word == "invalid" else found)
    assert place == len(record)
    return [step, actions]


def undetailed(action: dict[str, Any]) -> dict[str, Any]:
    return {key: part for key, part in action.items() if key != "detail"}


def test_a_record_that_is_too_long_ends_the_connection_alone(served: Served) -> None:
    binary, plain = served.peer(b"EXO1"), served.peer()
    binary.record()
    binary.socket.sendall(struct.pack("<I", 1 << 30))
    with pytest.raises(EOFError):
        binary.record()
    assert plain.ask(GOTO)[0]["launch"] == "nd.goto"


def test_what_was_sent_before_a_record_that_is_too_long_is_answered(served: Served) -> None:
    peer = served.peer(b"EXO1")
    ask = struct.pack("<I", 2) + bytes([1, 255])
    peer.socket.sendall(3 * ask + struct.pack("<I", 1 << 30) + ask)
    assert len([peer.record() for _ in range(4)]) == 4
    with pytest.raises(EOFError):
        peer.record()


def test_nobody_waits_for_who_does_not_read_standard_error(served: Served) -> None:
    for _ in range(1000):  # more than a pipe holds
        odd = Peer(served.path, b"EXO1" + struct.pack("<I", 1 << 30))
        odd.record()
        odd.socket.close()
    assert served.peer().ask(GOTO)[0]["launch"] == "nd.goto"
    assert served.end() == 143


@pytest.mark.skipif(sys.platform != "linux", reason="limits of another process are of Linux")
def test_a_first_line_is_read_though_no_file_can_be_opened(served: Served) -> None:
    peer, later = served.peer(), served.peer(b"EXO1")
    later.record()  # so both are accepted
    resource.prlimit(served.process.pid, resource.RLIMIT_NOFILE, (3, 3))
    peer.socket.sendall(b"\xef\xbb\xbf" + json.dumps(GOTO).encode() + b"\n")
    assert peer.hear()["actions"][0]["launch"] == "nd.goto"


def test_a_listener_that_does_not_read_is_let_go_and_nobody_waits_for_it(
    tmp_path: Path, model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serve, "MAX_WAITING", 1 << 18)
    said: list[str] = []
    with here(tmp_path, model, said) as server:
        deaf, busy = Peer(tmp_path / "sock"), Peer(tmp_path / "sock")
        deaf.tell({"listen": True})
        for _ in range(5):
            server.turn(0.1)
        assert len(server.clients) == 2
        for _ in range(20_000):
            busy.tell({"observe": "ok", "value": 9})
            server.turn(1)
            busy.hear()
            if len(server.clients) < 2:
                break
        assert said == ["client 1 is let go: more than 0 MiB of answers wait for it"]
        deaf.socket.close()
        busy.socket.close()


def test_a_client_that_does_not_read_its_answers_is_read_no_more_and_that_is_told_once(
    tmp_path: Path, model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serve, "ENOUGH", 1 << 16)
    said: list[str] = []
    with here(tmp_path, model, said) as server:
        deaf = Peer(tmp_path / "sock")
        deaf.socket.setblocking(False)
        sent = 0
        for _ in range(2_000):
            with suppress(BlockingIOError):
                sent += deaf.socket.send(b'{"observe": "ok", "value": 9}\n' * 100)
            server.turn(0)
        assert 30 * server.steps < sent, "some of it was never read"
        assert said == ["nothing more is read from client 1: more than 0 MiB of answers wait for it"]
        deaf.socket.close()


OBSERVE = b'{"observe": "ok", "value": 1}\n'


def until_gone(server: serve.CheckerServer) -> int:
    """Take turns until there is no client; return the number of steps."""
    server.turn(PATIENCE)
    while server.clients:
        server.turn(PATIENCE)
    return server.steps


def test_all_that_a_client_has_sent_is_taken_though_it_has_gone_before_its_answers(
    tmp_path: Path, model: Model
) -> None:
    with here(tmp_path, model, []) as server:
        gone = Peer(tmp_path / "sock", OBSERVE * 3000)  # more than is read at once
        gone.socket.close()
        assert until_gone(server) == 3000


def test_nobody_waits_for_all_that_another_has_sent(tmp_path: Path, model: Model) -> None:
    with here(tmp_path, model, []) as server:
        busy, other = (Peer(tmp_path / "sock", OBSERVE * count) for count in (2000, 1))
        while server.steps < 200:
            server.turn(PATIENCE)
        assert other.hear()["step"] < 200
        busy.socket.close()
        other.socket.close()


def test_what_a_gone_client_has_sent_is_taken_before_anything_of_who_comes_after_it(
    tmp_path: Path, model: Model
) -> None:
    with here(tmp_path, model, []) as server:
        old = Peer(tmp_path / "sock", OBSERVE * 1000)
        server.turn(PATIENCE)
        old.socket.close()
        new = Peer(tmp_path / "sock", OBSERVE)
        while server.steps < 1001:
            server.turn(PATIENCE)
        assert new.hear()["step"] == 1001
        new.socket.close()


def test_the_last_line_needs_no_end_though_the_client_has_left_answers_unread(tmp_path: Path, model: Model) -> None:
    with here(tmp_path, model, []) as server:
        gone = Peer(tmp_path / "sock", OBSERVE)
        for _ in range(2):
            server.turn(PATIENCE)
        gone.socket.sendall(OBSERVE.rstrip())
        gone.socket.close()
        assert until_gone(server) == 2


def test_a_client_that_reads_nothing_may_say_so_and_is_read(tmp_path: Path, model: Model) -> None:
    with here(tmp_path, model, []) as server:
        mute = Peer(tmp_path / "sock")
        mute.socket.shutdown(socket.SHUT_RD)
        server.turn(PATIENCE)
        for _ in range(3):
            mute.socket.sendall(OBSERVE)
            server.turn(PATIENCE)
        assert (server.steps, len(server.clients)) == (3, 1)
        mute.socket.close()


class Faulty:
    """A connection on which a call fails, as where the system has no memory for it."""

    def __init__(self, connected: socket.socket, call: str) -> None:
        self._connected = connected
        setattr(self, call, self._fail)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._connected, name)

    def _fail(self, *_: object) -> None:
        raise OSError(errno.ENOBUFS, os.strerror(errno.ENOBUFS))


@pytest.mark.parametrize(("call", "taken"), (("recv", 0), ("send", 1)))
def test_a_connection_that_fails_ends_lest_the_client_wait_for_an_answer(
    tmp_path: Path, model: Model, call: str, taken: int
) -> None:
    said: list[str] = []
    with here(tmp_path, model, said) as server, closing(Peer(tmp_path / "sock").socket) as peer:
        server.turn(PATIENCE)
        client = server.clients[1]
        client.socket = Faulty(client.socket, call)  # type: ignore[assignment]
        peer.sendall(OBSERVE)
        server.turn(PATIENCE)
        assert (server.steps, server.clients) == (taken, {})
        with suppress(ConnectionResetError):
            assert peer.recv(1) == b""
    assert said == ["client 1 is let go: No buffer space available"]


def test_a_client_that_does_not_listen_is_not_let_go_for_answers_to_what_was_read_at_once(
    tmp_path: Path, model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serve, "ENOUGH", 1 << 11)
    monkeypatch.setattr(serve, "MAX_WAITING", 1 << 12)
    with here(tmp_path, model, []) as server:
        busy = Peer(tmp_path / "sock", OBSERVE * 1000 + b"{")
        busy.socket.shutdown(socket.SHUT_WR)
        assert until_gone(server) == 1001
        assert [busy.hear()["step"] for _ in range(1001)] == list(range(1, 1002))
        busy.socket.close()


class Many:
    """An engine that answers with more actions than a record may have."""

    def step(self, event: Event) -> tuple[Action, ...]:
        return (Killed("nd.stop", 0, "abort"),) * 65_536


def test_an_answer_that_fits_no_record_ends_the_connections_by_records_alone(tmp_path: Path, model: Model) -> None:
    said: list[str] = []
    with here(tmp_path, model, said) as server:
        server.engine = Many()
        peers = [Peer(tmp_path / "sock", start) for start in (b"EXO1", OBSERVE)]
        peers[1].socket.setblocking(False)
        while not peers[1].coming.endswith(b"\n"):
            server.turn(PATIENCE)
            with suppress(BlockingIOError):
                peers[1].coming += peers[1].socket.recv(1 << 20)
        assert len(peers[1].hear()["actions"]) == 65_536
        peers[0].send(b"\0\1\0")
        server.turn(PATIENCE)
        assert said[1:] == ["client 1 is let go: an answer of 65536 actions, and a record has at most 65535"]
        for peer in peers:
            peer.socket.close()


@contextmanager
def no_more_files() -> Iterator[None]:
    """Let this process open no file more than it has open now."""
    first_free = os.dup(0)
    os.close(first_free)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (first_free, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_clients_that_cannot_be_accepted_wait_for_others_to_go_and_that_is_told_once(
    tmp_path: Path, model: Model
) -> None:
    said: list[str] = []
    with here(tmp_path, model, said) as server:
        first = Peer(tmp_path / "sock")
        server.turn(PATIENCE)
        second = Peer(tmp_path / "sock")
        second.tell(GOTO)
        with no_more_files():
            server.turn(PATIENCE)
            begun = monotonic()
            for _ in range(10):
                server.turn(0.02)
            assert monotonic() - begun >= 5 * 0.02, "it is not heard all the time of a client that waits"
            assert said == ["clients wait until others go: Too many open files"]
            first.tell(GOTO)
            server.turn(PATIENCE)
            assert first.hear()["actions"][0]["launch"] == "nd.goto"
            first.socket.close()
            while 2 not in server.clients:
                server.turn(PATIENCE)
        server.turn(PATIENCE)
        assert second.hear()["step"] == 2
        second.socket.close()
    assert len(said) == 1


def test_a_client_that_cannot_be_watched_is_let_go(
    tmp_path: Path, model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    said: list[str] = []
    with here(tmp_path, model, said) as server, closing(Peer(tmp_path / "sock").socket) as peer:
        monkeypatch.setattr(server._selector, "register", refuse)
        server.turn(PATIENCE)
        assert (peer.recv(1), server.clients) == (b"", {})
    assert said == ["a client cannot be served: No space left on device"]


def test_what_is_no_word_on_listening_is_answered(served: Served) -> None:
    """Else a client would take it that it hears of kills."""
    lines = ('{"listen": 1}', '{"listen": "true"}', '{"listen": null}', '{"listen": true, "step": 1}')
    for step, line in enumerate(lines, 1):
        peer = served.peer()
        peer.socket.sendall(f"{line}\n".encode())
        answer = peer.hear()
        assert (answer["step"], [each["invalid"] for each in answer["actions"]]) == (step, ["bad-event"]), line


def test_a_record_that_is_no_word_on_listening_is_answered(served: Served) -> None:
    for record in (b"\5", b"\5\7"):
        peer = served.peer(b"EXO1")
        told = json.loads(peer.record())
        peer.send(record)
        assert [undetailed(each) for each in decoded(told, peer.record())[1]] == [{"invalid": "bad-event"}], record


def test_a_client_that_sends_in_pieces_is_understood(served: Served) -> None:
    peer, late = served.peer(), served.peer()
    for byte in json.dumps(GOTO).encode() + b"\n":
        peer.socket.sendall(bytes([byte]))
    assert peer.hear()["actions"][0]["launch"] == "nd.goto"
    for byte in b"EXO1":
        late.socket.sendall(bytes([byte]))
        sleep(0.01)
    assert json.loads(late.record())["spec"] == "demo"


def test_the_socket_is_its_owners_alone_and_goes_with_the_process(served: Served, tmp_path: Path) -> None:
    assert os.stat(served.path).st_mode & 0o777 == 0o600
    second = subprocess.run(
        [*COMMAND, "serve", "demo.exo", "--socket", "sock", "--engine", "tables"],
        cwd=tmp_path, env=environment(), capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    other = "another exover serves at sock, and locks sock.lock: end it first"
    assert (second.returncode, second.stderr) == (2, f"exover: error: {other}\n")
    assert served.end(signal.SIGINT) == 130
    assert [each.name for each in tmp_path.iterdir()] == ["demo.exo"]


def test_what_is_left_of_a_killed_process_is_replaced_and_nothing_else(run, tmp_path: Path) -> None:
    first = Served(tmp_path, "--engine", "tables")
    first.end(signal.SIGKILL)
    assert first.path.exists()
    again = Served(tmp_path, "--engine", "tables")
    assert again.peer().ask(GOTO)[0]["launch"] == "nd.goto"
    again.end()
    (tmp_path / "sock").write_text("mine")
    done = run("serve", "demo.exo", "--socket", "sock", "--engine", "tables")
    assert (done.returncode, done.stderr) == (2, "exover: error: sock is there and is no socket\n")
    assert (tmp_path / "sock").read_text() == "mine"
    (tmp_path / "sock").unlink()
    (tmp_path / "sock").symlink_to("nowhere")
    assert run("serve", "demo.exo", "--socket", "sock", "--engine", "tables").stderr == done.stderr
    done = run("serve", "demo.exo", "--socket", "no/folder/sock", "--engine", "tables")
    assert (done.returncode, "cannot listen at no/folder/sock" in done.stderr) == (2, True)


def test_a_socket_whose_process_lets_nobody_in_is_left_alone(
    run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "demo.exo").write_text(SPEC)
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listener:
        listener.bind(str(tmp_path / "sock"))
        listener.listen(0)
        waiting = Peer(tmp_path / "sock")
        full = run("serve", "demo.exo", "--socket", "sock", "--engine", "tables")
        assert (full.returncode, full.stderr) == (2, "exover: error: another process listens at sock\n")
        with monkeypatch.context() as patched:
            patched.setattr(socket, "socket", Forbidden)
            shut = run("serve", "demo.exo", "--socket", "sock", "--engine", "tables")
        waiting.socket.close()
    why = "cannot replace sock, which may be in use: Permission denied"
    assert (shut.returncode, shut.stderr) == (2, f"exover: error: {why}\n")
    assert (tmp_path / "sock").exists()


def test_of_two_that_begin_where_a_socket_was_left_one_listens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, both, lock = str(tmp_path / "sock"), threading.Barrier(2), command._lock
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as left:
        left.bind(path)

    def together(name: str) -> int:
        both.wait(PATIENCE)
        return lock(name)

    def begin() -> str:
        try:
            with command._listening(path):
                ended.wait(PATIENCE)
        except CliError as error:
            ended.set()
            return str(error)
        return "listened"

    ended = threading.Event()
    monkeypatch.setattr(command, "_lock", together)
    with ThreadPoolExecutor(2) as pool:
        said = {future.result() for future in [pool.submit(begin) for _ in range(2)]}
    assert said == {"listened", SERVED.format(path)}


SERVED = "another exover serves at {0}, and locks {0}.lock: end it first"


def test_a_removed_socket_lets_no_second_process_serve(tmp_path: Path) -> None:
    path = tmp_path / "sock"
    with command._listening(str(path)):
        path.unlink()
        with pytest.raises(CliError, match=SERVED.format(path)), command._listening(str(path)):
            pass
        path.write_text("mine")
    assert [each.name for each in tmp_path.iterdir()] == ["sock"]


def test_a_lock_that_goes_while_it_is_taken_is_taken_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name, stands_at, tries = tmp_path / "sock.lock", command._stands_at, []

    def too_late(file: int, path: str) -> bool:
        tries.append(path)
        if len(tries) == 1:
            name.unlink()  # as the process does that had it
        return stands_at(file, path)

    monkeypatch.setattr(command, "_stands_at", too_late)
    with command._listening(str(tmp_path / "sock")):
        assert name.exists()
        with pytest.raises(CliError, match="end it first"), command._listening(str(tmp_path / "sock")):
            pass
    assert not name.exists()


@pytest.mark.parametrize(
    "lock, why",
    [
        (lambda path: path.write_text("mine"), "{0} is there and is no lock file"),
        (os.mkfifo, "{0} is there and is no lock file"),
        (lambda path: path.symlink_to("victim"), "cannot listen at sock: cannot lock {0}: " + os.strerror(errno.ELOOP)),
        (Path.mkdir, "cannot listen at sock: cannot lock {0}: " + os.strerror(errno.EISDIR)),
    ],
)
def test_what_is_no_lock_is_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lock: Callable[[Path], object], why: str
) -> None:
    monkeypatch.chdir(tmp_path)
    lock(tmp_path / "sock.lock")
    with pytest.raises(CliError) as refused, command._listening("sock"):
        pass
    assert str(refused.value) == why.format("sock.lock")
    assert [each.name for each in tmp_path.iterdir()] == ["sock.lock"]


class Forbidden(socket.socket):
    """A socket of somebody who may connect to none: the tests may be run by root, who always may."""

    def connect(self, address: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def test_systemd_is_told_when_clients_may_come(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(tmp_path / "notify"))
        listening.settimeout(PATIENCE)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        served = Served(tmp_path, "--engine", "tables")
        assert listening.recv(100) == b"READY=1"
        served.end()


def test_many_clients_at_once_get_their_own_answers(served: Served) -> None:
    peers = [served.peer() for _ in range(50)]
    until = monotonic() + PATIENCE
    for turn in range(20):
        for peer in peers:
            peer.tell({"observe": "ok", "value": turn % 4}, {"ask": "nd.nothing"})
        found = [(peer.hear(), peer.hear()) for peer in peers]
        assert all(not first["actions"] for first, _ in found)
        assert all(second["actions"][0]["invalid"] == "unknown-request" for _, second in found)
    assert monotonic() < until
