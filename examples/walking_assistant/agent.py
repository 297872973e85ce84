"""An agent that wants too much: an MCP client that talks to the walking assistant through its gate.

`python agent.py [FILE]` prints what it asks for and what it is told; decisions are logged to FILE.
"""

import asyncio
import sys
from pathlib import Path
from typing import Any

from mcp import Client
from mcp.client.stdio import StdioServerParameters

HERE = Path(__file__).resolve().parent
SPEC = HERE.parents[1] / "specs" / "assistant.exo"


def gate(log: str | None) -> StdioServerParameters:
    """Return what the agent starts in place of the server."""
    options = ["--bind", str(HERE / "assistant.bind.toml"), *(["--log", log] if log else [])]
    server = [sys.executable, str(HERE / "server.py")]
    return StdioServerParameters(
        command=sys.executable, args=["-P", "-m", "exover", "gate", "mcp", str(SPEC), *options, "--", *server]
    )


async def call(client: Client, name: str, **arguments: Any) -> str:
    """Call a tool; tell what was asked and answered, and return the answer."""
    found = await client.call_tool(name, arguments)
    said = " ".join(getattr(part, "text", "") for part in found.content)
    asked = ", ".join(f"{key}={value!r}" for key, value in arguments.items())
    print(f"{name}({asked}): {said}", flush=True)
    return said


async def until(client: Client, where: str, value: object) -> None:
    """Wait until the wheels say so."""
    while (await client.call_tool("look", {})).structured_content["wheels"][where] != value:  # type: ignore[index]
        await asyncio.sleep(0.02)


async def sense(client: Client, **world: Any) -> None:
    """Change the world, and give the gate time to look."""
    await client.call_tool("pretend", world)
    print(f"-- {', '.join(f'{key}: {value}' for key, value in world.items())}", flush=True)
    await asyncio.sleep(0.5)


async def main(log: str | None) -> None:
    """Try one thing after the other."""
    async with Client(gate(log)) as client:
        print("tools:", ", ".join(sorted(tool.name for tool in (await client.list_tools()).tools)))
        while "starting" in await call(client, "stop"):
            await asyncio.sleep(0.1)

        await sense(client, leaning=True)
        await call(client, "wheels", command="go", cm_per_s=80)
        await sense(client, leaning=False)
        await call(client, "wheels", command="go", cm_per_s=80)

        await sense(client, around="crowd")
        await call(client, "grab")
        await sense(client, around="alone")
        grabbing = asyncio.create_task(call(client, "grab"))
        await asyncio.sleep(0.2)
        await sense(client, around="crowd")
        await grabbing
        await call(client, "hand_over")

        cleaning = asyncio.create_task(call(client, "vacuum", where="Hall"))
        await cleaning
        await sense(client, cat=True)
        cleaning = asyncio.create_task(call(client, "vacuum", where="Hall"))
        await asyncio.sleep(0.3)
        print("it waits:", not cleaning.done())
        await sense(client, cat=False)
        await cleaning

        await call(client, "wheels", command="go", cm_per_s=50)
        await until(client, "phase", "rolling")
        await sense(client, slipping=True)
        await until(client, "still", True)
        print("the walker has stopped by itself")
        await call(client, "reboot")


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1] if len(sys.argv) > 1 else None))
