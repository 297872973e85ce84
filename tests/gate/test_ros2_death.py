"""A server of ROS 2 that is killed says nothing: the gate finds it out by its lease, which is 2 s here."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("cyclonedds", reason="the extra exover[ros2] is not installed")
pytest.importorskip("rosbags", reason="the extra exover[ros2] is not installed")

from tests.gate import ros_peers as ros
from tests.gate.ros_peers import ABORTED, DRIVE, REACH, SUCCEEDED, Client, Node, Server
from tests.gate.yard import BIND, INTERFACES, SPEC

DOMAIN = 20 + (os.getpid() + 50) % 100
ROOT = Path(__file__).parents[2]
WITHOUT_HALT = BIND[: BIND.index('[request."base.halt"]')] + BIND[BIND.index('[request."arm.reach"]') :]


@contextmanager
def drive_server() -> Iterator["subprocess.Popen[bytes]"]:
    command = [sys.executable, "-m", "tests.gate.drive_server", str(DOMAIN)]
    with subprocess.Popen(command, cwd=ROOT) as process:
        try:
            yield process
        finally:
            process.kill()


def launched(client: Client) -> bytes | None:
    """Return the id of a goal if it is accepted."""
    id, number = client.send(1.0)
    return id if client.answer(number).accepted else None


def test_what_a_killed_server_ran_stays_active_until_one_says_that_it_does_not_run(tmp_path: Path) -> None:
    below, above = Node(DOMAIN), Node(DOMAIN)
    reach = Server(below, "/gated/reach", REACH)
    above.poll_with(reach.poll)
    with ros.gate(tmp_path, SPEC, WITHOUT_HALT, DOMAIN, "--interfaces", str(INTERFACES)) as log:
        driver, reacher = Client(above, "/drive", DRIVE), Client(above, "/reach", REACH)
        with drive_server() as server:
            id = above.until(lambda: launched(driver), "the gate has started")
            number = driver.result(id)
            server.kill()
            assert driver.answer(number).status == ABORTED
        assert "module-gone" in [each["alarm"] for each in entries(log) if each.get("request") == "base.drive"]
        assert not launched(driver) and entries(log)[-1]["rule"] == "unavailable"
        reaching = reacher.accepted("l")  # it waits until nothing drives
        waits = {"wait": "arm.reach", "rule": "arm.reach.wait.1", "because": "reaching needs a base that stands"}
        assert entries(log)[-1]["actions"] == [waits]
        assert reaching not in reach.goals
        with drive_server():
            above.until(lambda: reaching in reach.goals, "the new server has said that nothing drives")
            report = {"report": "base.drive", "instance": 0, "outcome": "interrupted"}
            assert report in [each.get("event") for each in entries(log)]
            reach.end(reaching, SUCCEEDED, True)
            assert reacher.answer(reacher.result(reaching)).status == SUCCEEDED


def entries(log: Path) -> list[Any]:
    return [json.loads(line) for line in log.read_text("utf-8").splitlines()]
