"""A mission that wants too much, on a robot with Nav2 behind the gate. Prints what becomes of it.

Run as `python mission.py [LOG]`, in any folder; the decisions of the gate are appended to LOG.
"""

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from nav2 import HERE, Client, Server, World

from exover.gate.ros2 import cdr, endpoints
from exover.gate.ros2.endpoints import TopicReader
from exover.gate.ros2.names import Port, message_topic

DOMAIN = 63
ENDED = {cdr.SUCCEEDED: "succeeded", cdr.CANCELED: "canceled", cdr.ABORTED: "aborted"}
CHARGING, DISCHARGING = 1, 2


class Mission:
    """Clients of three actions, their servers behind the gate, and the battery."""

    def __init__(self) -> None:
        world = self.world = World(DOMAIN)
        types = {"navigate": "NavigateToPose", "dock": "DockRobot", "undock": "UndockRobot"}
        names = {"navigate": "navigate_to_pose", "dock": "dock_robot", "undock": "undock_robot"}
        self.servers = {
            verb: Server(world, f"/gated/{names[verb]}", f"nav2_msgs/action/{type_}") for verb, type_ in types.items()
        }
        battery = "sensor_msgs/msg/BatteryState"
        self._battery = world.writer("outer", "/battery_state", "message", battery, endpoints.FEEDBACK)
        self.supply(DISCHARGING)
        self._next = 0.0
        world.live.append(self._publish)
        decisions = message_topic(Port("outer", "/exover/decisions", "message"))
        self._decisions = TopicReader(
            world.participant, decisions, world.samples.message("std_msgs/msg/String"), endpoints.DECISIONS
        )
        self._clients = {
            verb: Client(world, f"/{names[verb]}", f"nav2_msgs/action/{type_}") for verb, type_ in types.items()
        }
        world.until(self._started, "the gate has started")

    def supply(self, status: int) -> None:
        """Let the battery say whether it is charged."""
        values = [(("power_supply_status",), status)]
        self._state = cdr.topic(self.world.types.write("sensor_msgs/msg/BatteryState", values))
        self._battery.write(self._state)

    def _publish(self) -> None:
        if time.monotonic() > self._next:
            self._next = time.monotonic() + 0.1
            self._battery.write(self._state)

    def _started(self) -> bool:
        id = self._clients["navigate"].send()
        if id is None:
            return False
        self.servers["navigate"].end(cdr.SUCCEEDED)
        self.world.until(self._clients["navigate"].result(id), "a result")
        return True

    def send(self, verb: str, **goal: object) -> bytes | None:
        """Send a goal, and say whether it is accepted; if not, why, as the gate tells on its topic."""
        self._decided()
        id = self._clients[verb].send(**goal)
        print(f"{verb}: {'accepted' if id else self.world.until(self._refusal, 'the reason')}", flush=True)
        return id

    def _refusal(self) -> str | None:
        for entry in self._decided():
            for said in (entry, *entry.get("actions", ())):
                if "reject" in said or "refused" in said:
                    return f"refused by {said['rule']}: {said['because']}"
        return None

    def _decided(self) -> list[dict[str, Any]]:
        """Return the decisions that were told since this was asked for last."""
        return [json.loads(data[8:-1].rstrip(b"\0")) for data, _ in self._decisions.take()]

    def charged(self, status: int) -> None:
        """Let the battery say whether it is charged, and the gate have heard it."""
        self.supply(status)
        seen = {"observe": "supply", "value": status}
        self.world.until(lambda: any(each.get("event") == seen for each in self._decided()), "the battery is heard")

    def result(self, verb: str, id: bytes | None) -> None:
        """Say how a goal has ended."""
        assert id
        print(f"{verb}: {ENDED[self.world.until(self._clients[verb].result(id), 'a result')[0]]}", flush=True)

    def running(self, verb: str) -> None:
        """Say that a goal has come to its server."""
        self.world.until(lambda: self.servers[verb].running, f"{verb} runs")
        print(f"  {verb} runs", flush=True)


def drive(mission: Mission) -> None:
    """Do the mission."""
    going = mission.send("navigate", pose__pose__position__x=3.0)
    mission.running("navigate")
    print("-- to the dock, while the robot drives")
    home = mission.send("dock", dock_id="home")
    mission.result("navigate", going)
    mission.running("dock")
    print("-- somewhere else, while it docks (issue 4503)")
    mission.send("navigate", pose__pose__position__x=-3.0)
    mission.send("undock")
    print("-- with a drive to the staging pose, past the gate")
    mission.send("dock", dock_id="home", navigate_to_staging_pose=True)
    mission.servers["dock"].end(cdr.SUCCEEDED, success=True)
    mission.result("dock", home)
    mission.charged(CHARGING)
    print("-- it is docked (issues 4447 and 4503)")
    mission.send("navigate")
    mission.send("dock", dock_id="home")
    out = mission.send("undock")
    mission.running("undock")
    mission.charged(DISCHARGING)
    mission.servers["undock"].end(cdr.SUCCEEDED, success=True)
    mission.result("undock", out)
    print("-- it is not")
    mission.send("undock")
    away = mission.send("navigate", pose__pose__position__x=1.0)
    mission.running("navigate")
    mission.servers["navigate"].end(cdr.ABORTED, error_code=106)
    mission.result("navigate", away)


def main() -> None:
    """Start the gate, do the mission, end the gate."""
    options = ["--bind", "nav2_docking.bind.toml", "--interfaces", "interfaces", "--domain", str(DOMAIN)]
    options += ["--log", str(Path(sys.argv[1]).resolve())] if len(sys.argv) > 1 else []
    command = [sys.executable, "-P", "-m", "exover", "gate", "ros2", "nav2_docking.exo", *options]
    with subprocess.Popen(command, cwd=HERE) as gate:
        try:
            drive(Mission())
        finally:
            gate.terminate()


if __name__ == "__main__":
    main()
