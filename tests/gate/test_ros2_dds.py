"""`exover gate ros2` on the loopback, between clients and servers that were written with cyclonedds."""

import json
import os
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("cyclonedds", reason="the extra exover[ros2] is not installed")
pytest.importorskip("rosbags", reason="the extra exover[ros2] is not installed")

from exover.gate.ros2 import session
from exover.gate.ros2.endpoints import KEPT
from exover.gate.ros2.names import Port
from exover.gate.ros2.session import Served, topics_first
from tests.gate import ros_peers as ros
from tests.gate.ros_peers import ABORTED, CANCELED, DRIVE, EXECUTING, REACH, SUCCEEDED, Client, Node, Server
from tests.gate.yard import BIND, INTERFACES, SPEC

DOMAIN = 20 + os.getpid() % 100
OPTIONS = ("--interfaces", str(INTERFACES))


@pytest.fixture(scope="module")
def yard(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A gate, the servers below it, and a client of each action."""
    below, above = Node(DOMAIN), Node(DOMAIN)
    drive, reach = Server(below, "/gated/drive", DRIVE), Server(below, "/gated/reach", REACH)
    halt = below.reader("rq/gated/haltRequest", ros.HaltRequest), below.writer("rr/gated/haltReply", ros.HaltReply)
    battery = below.writer("rt/battery", ros.Battery)
    decisions = above.reader("rt/exover/decisions", ros.Text, ros.LATCHED)
    above.poll_with(lambda: (drive.poll(), reach.poll()))  # type: ignore[func-returns-value]
    with ros.gate(tmp_path_factory.mktemp("yard"), SPEC, BIND, DOMAIN, *OPTIONS) as log:
        clients = Client(above, "/drive", DRIVE), Client(above, "/reach", REACH)
        found = SimpleNamespace(above=above, below=below, drive=drive, reach=reach, halt=halt, battery=battery,
                                driver=clients[0], reacher=clients[1], decisions=decisions, log=log)  # fmt: skip
        calls = above.writer("rq/haltRequest", ros.HaltRequest), above.reader("rr/haltReply", ros.HaltReply)
        found.halter = calls
        above.until(lambda: calls[0].get_matched_subscriptions() and calls[1].get_matched_publications())
        above.until(lambda: started(found), "the gate has started")
        yield found


def started(yard: Any) -> bool:
    """Return whether a goal goes through; what it begins is ended."""
    id, number = yard.driver.send(0.5)
    if not yard.driver.answer(number).accepted:
        return False
    yard.drive.end(id, SUCCEEDED, 0.5, 0)
    yard.driver.answer(yard.driver.result(id))
    return True


def halting(yard: Any, number: int) -> Any:
    """Call the service, let its server answer, and return the answer."""
    yard.halter[0].write(ros.HaltRequest(1, number, 9))

    def serve() -> Any:
        for each in ros.taken(yard.halt[0]):
            assert each.reason == 9
            yard.halt[1].write(ros.HaltReply(each.client_, each.number_, True, "stands"))
        return [each for each in ros.taken(yard.halter[1]) if each.number_ == number]

    (answer,) = yard.above.until(serve, "the answer of the service")
    return answer


def test_launch_feedback_and_result(yard: Any) -> None:
    id = yard.driver.accepted(2.5)
    assert yard.drive.goals[id].x == 2.5
    number = yard.driver.result(id)
    yard.above.until(lambda: yard.driver.statuses.get(id) == EXECUTING, "its status")
    yard.drive.feedback.write(DRIVE["feedback"](ros.Uuid(list(id)), DRIVE["Feedback"](1.25)))
    yard.above.until(lambda: [each for each in yard.driver.feedback if each[0] == id], "feedback")
    assert yard.driver.feedback[-1][1].left == 1.25
    yard.drive.end(id, SUCCEEDED, 2.4, 0)
    answer = yard.driver.answer(number)
    assert (answer.status, answer.result.metres) == (SUCCEEDED, 2.4)
    yard.above.until(lambda: yard.driver.statuses.get(id) == SUCCEEDED, "its last status")


def test_a_refusal_stands_on_the_decision_topic(yard: Any) -> None:
    def low() -> Any:
        yard.battery.write(ros.Battery(5.0))
        return [each for each in decided(yard) if each.get("event", {}).get("observe") == "base.battery"]

    yard.above.until(low, "the poster")
    _, number = yard.driver.send(1.0)
    assert not yard.driver.answer(number).accepted
    refusal = {"reject": "base.drive", "rule": "base.drive.charged", "because": "the battery is empty"}
    yard.above.until(lambda: any(refusal in each.get("actions", ()) for each in decided(yard)), "the decision")
    assert refusal in [action for each in logged(yard) for action in each.get("actions", ())]
    yard.battery.write(ros.Battery(90.0))
    yard.above.until(lambda: [each for each in logged(yard) if each.get("event", {}).get("value", 0) > 0.8])


def decided(yard: Any) -> list[Any]:
    """Return the decisions that have come on the topic since this was asked for last."""
    return [json.loads(each.data) for each in ros.taken(yard.decisions)]


def logged(yard: Any) -> list[Any]:
    return [json.loads(line) for line in yard.log.read_text("utf-8").splitlines()]


def test_wait_and_kill(yard: Any) -> None:
    first = yard.driver.accepted(1.0)
    reaching = yard.reacher.accepted("l")  # it waits
    assert reaching not in yard.reach.goals
    second, number = yard.driver.send(2.0)
    assert yard.driver.answer(number).accepted
    yard.above.until(lambda: first in yard.drive.cancelled, "the cancel")
    assert second not in yard.drive.goals
    yard.drive.end(first, CANCELED, 0.1, 0)
    yard.above.until(lambda: second in yard.drive.goals, "the second goal")
    assert yard.driver.answer(yard.driver.result(first)).status == CANCELED
    yard.drive.end(second, SUCCEEDED, 2.0, 0)
    yard.above.until(lambda: reaching in yard.reach.goals, "what waited")
    assert yard.reach.goals[reaching].side == "l"
    yard.reach.end(reaching, SUCCEEDED, True)
    assert yard.reacher.answer(yard.reacher.result(reaching)).result.touched


def test_a_cancel_of_the_client(yard: Any) -> None:
    id = yard.driver.accepted(1.0)
    assert yard.driver.cancel(id) == 0
    yard.above.until(lambda: id in yard.drive.cancelled, "the cancel")
    yard.drive.end(id, CANCELED, 0.0, 0)
    assert yard.driver.answer(yard.driver.result(id)).status == CANCELED
    assert yard.driver.cancel(id) == 3 and yard.driver.cancel(bytes(range(16))) == 2


def test_a_service(yard: Any) -> None:
    assert halting(yard, 1).message == "stands"
    id = yard.driver.accepted(1.0)
    yard.halter[0].write(ros.HaltRequest(1, 2, 9))
    yard.above.until(lambda: id in yard.drive.cancelled, "the cancel")
    yard.halter[0].write(ros.HaltRequest(1, 3, 9))  # a second one, while the first waits
    refused = yard.above.until(lambda: list(ros.taken(yard.halter[1])), "the refusal")
    assert [(each.number_, each.success, each.message) for each in refused] == [(3, False, "refused by busy")]
    yard.drive.end(id, CANCELED, 0.0, 0)

    def serve() -> Any:
        for each in ros.taken(yard.halt[0]):
            yard.halt[1].write(ros.HaltReply(each.client_, each.number_, True, "stands"))
        return [each.number_ for each in ros.taken(yard.halter[1])]

    assert yard.above.until(serve, "the answer of what waited") == [2]


def test_two_clients_at_once(yard: Any) -> None:
    node = Node(DOMAIN)
    node.poll_with(yard.drive.poll)
    other = Client(node, "/drive", DRIVE)
    for turn in range(20):
        mine, yours = yard.driver.send(1.0), other.send(2.0)
        answers = yard.driver.answer(mine[1]), other.answer(yours[1])
        assert all(each.accepted for each in answers)
        wanted = yard.driver.result(mine[0]), other.result(yours[0])

        def ended() -> bool:
            for id in list(yard.drive.active):
                killed = id in yard.drive.cancelled
                if killed or len(yard.drive.goals.keys() & {mine[0], yours[0]}) == 2:  # noqa: B023
                    yard.drive.end(id, CANCELED if killed else SUCCEEDED, float(turn), 0)  # noqa: B023
            return yard.driver.answered(wanted[0]) and other.answered(wanted[1])  # noqa: B023

        node.until(ended, "both results")
        results = {yard.driver.answer(wanted[0]).status, other.answer(wanted[1]).status}
        assert results == {SUCCEEDED, CANCELED}


def test_a_client_that_dies_while_it_waits(yard: Any) -> None:
    id = yard.driver.accepted(1.0)
    node = Node(DOMAIN)
    node.poll_with(yard.drive.poll)
    waiting = Client(node, "/reach", REACH).accepted("r")
    node.close()
    yard.above.until(lambda: any(each.get("event", {}).get("waiting") for each in logged(yard)), "it is given up")
    yard.drive.end(id, SUCCEEDED, 1.0, 0)
    yard.driver.answer(yard.driver.result(id))
    assert waiting not in yard.reach.goals


def test_a_stray_goal_is_cancelled_and_denies_everything(yard: Any) -> None:
    stray = bytes([7] * 16)
    yard.drive.active[stray] = EXECUTING
    yard.drive.show()
    yard.above.until(lambda: stray in yard.drive.cancelled, "the cancel")
    _, number = yard.reacher.send("l")
    assert not yard.reacher.answer(number).accepted
    yard.drive.end(stray, CANCELED, 0.0, 0)
    yard.above.until(lambda: started(yard), "it is over")


def test_a_server_that_dies_and_comes_back(tmp_path: Path) -> None:
    domain = DOMAIN + 100
    below, above = Node(domain), Node(domain)
    server = Server(below, "/gated/drive", DRIVE)
    above.poll_with(server.poll)
    bind = BIND[: BIND.index('[request."base.halt"]')].replace(
        "stop = 2", "stop = 0.5"
    )  # what is bound to nothing need not be there
    with ros.gate(tmp_path, SPEC, bind, domain, *OPTIONS):
        client = Client(above, "/drive", DRIVE)
        here = SimpleNamespace(driver=client, drive=server)
        above.until(lambda: started(here), "the gate has started")
        id = client.accepted(1.0)
        number = client.result(id)
        above.forget(server.poll)
        below.close()
        assert client.answer(number).status == ABORTED
        _, number = client.send(1.0)
        assert not client.answer(number).accepted
        again = Server(Node(domain), "/gated/drive", DRIVE)
        above.poll_with(again.poll)
        here.drive = again
        above.until(lambda: started(here), "the gate has seen the new server")
        running = client.accepted(1.0)
    again.poll()
    assert running in again.cancelled  # since the gate has ended


def test_servers_in_a_domain_of_their_own_have_the_outer_names() -> None:
    from exover.gate.gate import Gate
    from exover.gate.ros2 import cdr
    from exover.gate.ros2.checking import mistakes
    from exover.gate.ros2.proxy import Ros2Proxy
    from exover.gate.ros2.session import Ros2Session
    from exover.ocrd.machine import Machine
    from tests.gate.carts import binding_of
    from tests.gate.ros_middle import known, yard

    outer, inner = DOMAIN + 110, DOMAIN + 111
    bind = BIND[: BIND.index('[request."base.halt"]')].replace('inner = "/gated/drive"\n', "")
    above, below = Node(outer), Node(inner)
    server = Server(below, "/drive", DRIVE)
    model, tables = yard().model, yard().tables
    binding = binding_of(bind, model)
    assert not list(mistakes(binding, known(), apart=True))
    told: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CYCLONEDDS_URI", ros.LOOPBACK)
        session = Ros2Session(binding, known(), outer, inner, told.append)
    gate = Gate(model, binding, Machine(model, tables), time.monotonic, lambda entry: None)
    own = lambda: cdr.NEVER, lambda: b"i" * 16, b"the gate"
    proxy = Ros2Proxy(gate, known(), session.send, told.append, *own)  # type: ignore[misc]
    proxy.start()
    above.poll_with(lambda: session.turn(proxy, 0.001))
    above.poll_with(server.poll)
    client = Client(above, "/drive", DRIVE)
    here = SimpleNamespace(driver=client, drive=server)
    above.until(lambda: started(here), "the gate has started")
    id = client.accepted(1.0)
    server.end(id, SUCCEEDED, 1.0, 0)
    assert client.answer(client.result(id)).status == SUCCEEDED and not told


def test_messages_are_bytes_of_whole_words_and_what_is_not_written_is_told() -> None:
    from exover.gate.ros2 import endpoints
    from exover.gate.ros2.cdr import topic
    from exover.gate.ros2.idl import SampleTypes
    from tests.gate.ros_middle import known

    node = Node(DOMAIN + 1)
    text = SampleTypes(known()).message("std_msgs/msg/String")
    reader = endpoints.TopicReader(node.participant, "text", text, endpoints.REQUESTS)
    writer = endpoints.TopicWriter(node.participant, "text", text, endpoints.REPLIES)
    node.until(lambda: list(writer.readers()) and list(reader.writers()))
    writer.write(topic(b"\2\0\0\0x\0"))
    ((data, peer),) = reader.take()
    assert data == topic(b"\2\0\0\0x\0\0\0") and peer in reader.handles() and not reader.take()
    node.close()
    with pytest.raises(endpoints.DDSException):
        writer.write(data)
    with pytest.raises(endpoints.DDSException):
        reader.take()


def test_what_a_topic_holds_is_taken_before_a_reply() -> None:
    reply, canceled, goal, topic = (Port("inner", "/a", p) for p in ("call", "cancel_goal", "status", "message"))
    found = topics_first([(reply, 1), (canceled, 2), (goal, 3), (topic, 4)])
    assert found == [(topic, 4), (goal, 3), (reply, 1), (canceled, 2)]


def test_of_replies_for_a_client_without_a_reader_the_last_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session, "PATIENCE", 1000.0)
    written: list[bytes] = []
    entity = SimpleNamespace(get_matched_publication_data=lambda _: None)
    requests: Any = SimpleNamespace(entity=entity, handles=lambda: {7})
    replies: Any = SimpleNamespace(write=written.append, readers=lambda: ())
    served = Served(requests, replies)
    for number in range(KEPT + 2):
        served.answer(number.to_bytes(2, "little"), 7)
    served.catch_up()
    assert not written and len(served.late) == KEPT
    served.ready.add(7)
    served.catch_up()
    assert [int.from_bytes(data, "little") for data in written] == [*range(2, KEPT + 2)] and not served.late
