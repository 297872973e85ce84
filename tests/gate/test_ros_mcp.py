"""ros-mcp (https://github.com/robotmcp/ros-mcp-server) as the server: its tools are generic, its robot is not there.

Left out unless `ros-mcp` is on PATH, or $ROS_MCP is its path, as in `make ros-mcp`: it wants versions of MCP of its
own.
"""

import json
import os
import shutil
import sys
from pathlib import Path

import anyio
import pytest

ROS_MCP = os.environ.get("ROS_MCP") or shutil.which("ros-mcp")
pytestmark = pytest.mark.skipif(ROS_MCP is None, reason="ros-mcp is not installed: `make ros-mcp` does it")
SPEC = """spec turtle;
module turtle { request clear(); }
module motion { request go(x: real in 0 .. 11); }
mutex still: motion.go, turtle.clear because "the canvas is cleared while the turtle stands";
"""
REPORT = 'report = { status = "success", ok = [true], failed = [false] }'
BIND = f"""[gate]
spec = "turtle"
pass = ["get_*"]
start = "idle"

[request."turtle.clear"]
tool = "call_service"
when = {{ service_name = "/clear" }}
{REPORT}

[request."motion.go"]
tool = "send_action_goal"
when = {{ action_name = "/go" }}
arguments = {{ x = "goal.x" }}
{REPORT}
"""


def test_generic_tools_are_told_apart_by_their_arguments(tmp_path: Path) -> None:
    from mcp import Client
    from mcp.client.stdio import StdioServerParameters

    assert ROS_MCP is not None
    (tmp_path / "turtle.exo").write_text(SPEC)
    (tmp_path / "turtle.bind.toml").write_text(BIND)
    options = ["--bind", str(tmp_path / "turtle.bind.toml"), "--log", str(tmp_path / "log"), "--unchecked"]
    args = [
        "-m",
        "exover",
        "gate",
        "mcp",
        str(tmp_path / "turtle.exo"),
        *options,
        "--",
        ROS_MCP,
        "--transport",
        "stdio",
    ]
    clear = {"service_name": "/clear", "service_type": "std_srvs/srv/Empty", "request": {}}
    go = {"action_name": "/go", "action_type": "turtle/action/Go"}

    async def play() -> None:
        with anyio.fail_after(120):
            async with Client(StdioServerParameters(command=sys.executable, args=args)) as client:
                names = {tool.name for tool in (await client.list_tools()).tools}
                assert {"call_service", "send_action_goal", "get_topics"} <= names and "subscribe_once" not in names
                for name, arguments, rule in (
                    ("call_service", {**clear, "service_name": "/kill"}, "unbound"),
                    ("send_action_goal", {**go, "goal": {"x": 12}}, "out-of-range"),
                    ("send_action_goal", {**go, "goal": {}}, "unreadable"),
                ):
                    refused = await client.call_tool(name, arguments)
                    assert refused.is_error and refused.meta and refused.meta["exover/rule"] == rule
                answered = await client.call_tool("call_service", clear)
                assert "Connection refused" in answered.content[0].text  # type: ignore[union-attr]

    anyio.run(play)
    events = [json.loads(line).get("event") for line in (tmp_path / "log").read_text().splitlines()]
    assert {"report": "turtle.clear", "instance": 0, "outcome": "failed"} in events
