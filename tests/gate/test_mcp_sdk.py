"""The gate between the client and the server of the official SDK, over their standard streams."""

from __future__ import annotations

import json
import subprocess
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
import pytest

from tests.gate.carts import BIND, SPEC
from tests.support import warm

if find_spec("mcp") is None:
    pytest.skip("mcp is not installed", allow_module_level=True)
if TYPE_CHECKING:  # it takes a second of every process that collects the tests
    from mcp import Client

HERE = Path(__file__).parent


class Rig:
    """A gate with its files, and what it has written."""

    def __init__(self, folder: Path, bind: str = BIND) -> None:
        self.folder = folder
        (folder / "cart.exo").write_text(SPEC)
        (folder / "cart.bind.toml").write_text(bind)
        self.errors = folder / "errors.txt"

    def command(self) -> list[str]:
        files = ["cart.exo", "--bind", "cart.bind.toml", "--log", "log.jsonl", "--unchecked"]
        server = str(warm.command(verbs=(str(HERE / "cart_server.py"),)))
        return [str(warm.command()), "gate", "mcp", *files, "--", server]

    @asynccontextmanager
    async def client(self, mode: str = "auto") -> AsyncIterator[Client]:
        from mcp import Client
        from mcp.client.stdio import StdioServerParameters, stdio_client

        program, *args = self.command()
        with self.errors.open("w") as errors:
            transport = stdio_client(StdioServerParameters(command=program, args=args, cwd=self.folder), errlog=errors)
            async with Client(transport, mode=mode) as client:
                await self.ready(client)
                yield client

    async def ready(self, client: Client) -> None:
        """Wait until the watch has said what runs."""
        for _ in range(200):
            found = await client.call_tool("brake", {})
            if not found.is_error:
                return
            assert found.content[0].text.startswith("refused by starting"), found
            await anyio.sleep(0.05)
        raise AssertionError("the gate never starts")

    def log(self) -> list[dict[str, Any]]:
        return [
            json.loads(line) for line in (self.folder / "log.jsonl").read_text().splitlines(True) if line[-1] == "\n"
        ]

    async def noted(self, action: str, request: str) -> None:
        """Wait until the log has an action on a request."""
        while not any(each.get(action) == request for entry in self.log() for each in entry.get("actions", ())):
            await anyio.sleep(0.02)

    def arrive(self) -> None:
        """Let the base arrive."""
        (self.folder / "arrive").touch()


def text(result: Any) -> str:
    return str(result.content[0].text)


def played(folder: Path, play: Callable[[Rig, Client], Awaitable[None]], mode: str = "auto", bind: str = BIND) -> Rig:
    """Return a gate after a play with it."""
    rig = Rig(folder, bind)

    async def run() -> None:
        with anyio.fail_after(60):
            async with rig.client(mode) as client:
                await play(rig, client)

    anyio.run(run)
    return rig


@pytest.mark.parametrize("mode", ["auto", "legacy"])
def test_launch_wait_kill_and_reject(tmp_path: Path, mode: str) -> None:
    async def play(rig: Rig, client: Client) -> None:
        names = {tool.name for tool in (await client.list_tools()).tools}
        assert {"drive", "get_state", "reach"} <= names and "self_destruct" not in names
        assert text(await client.call_tool("self_destruct", {})).startswith("refused by unbound")
        assert (await client.call_tool("get_state", {})).is_error is False
        halt = await client.call_tool("drive", {"command": "halt"})
        assert halt.is_error and "unbound" in text(halt)

        fast = await client.call_tool("drive", {"command": "move", "speed_percent": 500})
        assert fast.is_error and fast.meta["exover/rule"] == "out-of-range"
        assert not (await client.call_tool("drive", {"command": "move", "speed_percent": 50, "seconds": 60})).is_error
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(arrive_when_held, rig)
            assert not (await client.call_tool("reach", {"hand": "l"})).is_error

        await client.call_tool("drive", {"command": "move", "speed_percent": 50, "seconds": 30})
        assert text(await client.call_tool("brake", {})) == "stands"

    rig = played(tmp_path, play, mode)
    said = [name for entry in rig.log() for action in entry.get("actions", ()) for name in action if name in DONE]
    assert said.count("kill") == 1 and said.count("wait") == 2
    ended = [entry["event"] for entry in rig.log() if "report" in entry.get("event", {})]
    assert {"report": "base.move", "instance": 0, "outcome": "ok", "results": {"distance": 1}} in ended
    assert {"report": "base.move", "instance": 0, "outcome": "interrupted"} in ended


DONE = ("launch", "wait", "reject", "kill")


async def arrive_when_held(rig: Rig) -> None:
    await rig.noted("wait", "arm.reach")
    rig.arrive()


async def cancelled(rig: Rig, client: Client, arguments: dict[str, Any], action: str) -> None:
    """Reach out, and cancel that when the log has an action on it."""
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(client.call_tool, "reach", arguments)
        await rig.noted(action, "arm.reach")
        tasks.cancel_scope.cancel()


def test_a_client_cancels_what_runs_and_what_waits(tmp_path: Path) -> None:
    async def play(rig: Rig, client: Client) -> None:
        await client.call_tool("drive", {"command": "move", "speed_percent": 50, "seconds": 60})
        await cancelled(rig, client, {"hand": "l"}, "wait")
        rig.arrive()
        await cancelled(rig, client, {"hand": "r", "seconds": 30}, "launch")
        for _ in range(100):
            found = await client.call_tool("reach", {"hand": "l"})
            if not found.is_error:
                return
            await anyio.sleep(0.05)
        raise AssertionError("the arm never stops")

    rig = played(tmp_path, play)
    events = [entry["event"] for entry in rig.log() if "event" in entry]
    assert {"abort": "arm.reach", "waiting": True} in events and {"abort": "arm.reach", "instance": 0} in events
    assert {"report": "arm.reach", "instance": 0, "outcome": "interrupted"} in events


def test_a_server_that_dies(tmp_path: Path) -> None:
    async def play(rig: Rig, client: Client) -> None:
        await client.call_tool("drive", {"command": "move", "speed_percent": 50, "seconds": 30})
        died = await client.call_tool("grip", {"force": 9})
        assert died.is_error and text(died).startswith("refused by unavailable")
        later = await client.call_tool("reach", {"hand": "l"})
        assert later.is_error and "unavailable" in text(later)

    rig = played(tmp_path, play)
    alarms = [(entry["alarm"], entry.get("request")) for entry in rig.log() if "alarm" in entry]
    assert ("module-gone", "base.move") in alarms and ("module-gone", "arm.grip") in alarms
    assert not [entry for entry in rig.log() if entry.get("event", {}).get("report") == "base.move"]


def test_a_client_that_goes_stops_what_runs(tmp_path: Path) -> None:
    async def play(rig: Rig, client: Client) -> None:
        await client.call_tool("drive", {"command": "move", "speed_percent": 50, "seconds": 30})

    rig = played(tmp_path, play)
    events = [entry["event"] for entry in rig.log() if "event" in entry]
    assert events.index({"abort": "base.move", "instance": 0}) < events.index(
        {"report": "base.move", "instance": 0, "outcome": "interrupted"}
    )


def test_a_server_that_is_not_there(tmp_path: Path) -> None:
    command = Rig(tmp_path).command()[:-1]
    done = subprocess.run([*command, "no-such-server"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "cannot start no-such-server" in done.stderr and not done.stdout
