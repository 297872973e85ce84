"""A cart as an MCP server, made with the official SDK: what the tests of the gate stand in front of."""

import asyncio
import os
import time
from pathlib import Path
from typing import Any

from mcp.server import MCPServer

server = MCPServer("cart")
base: dict[str, Any] = {"phase": "halted", "metres": 0.0, "speed_mm": 0.0}
clock = {"until": 0.0}
ARRIVE = Path("arrive")
"""The file that ends a drive before its time."""


@server.tool()
async def drive(command: str, speed_percent: float = 0.0, seconds: float = 0.3) -> dict[str, Any]:
    """Begin to drive, or halt."""
    if command == "halt":
        base.update(phase="halted", speed_mm=0.0)
        return {"halted": True}
    clock["until"] = time.monotonic() + seconds
    base.update(phase="moving", speed_mm=speed_percent * 10)
    return {"accepted": True}


@server.tool()
async def get_state() -> dict[str, Any]:
    """Tell what the cart does."""
    if base["phase"] == "moving" and (time.monotonic() >= clock["until"] or ARRIVE.exists()):
        ARRIVE.unlink(missing_ok=True)
        base.update(phase="arrived", metres=base["metres"] + 1, speed_mm=0.0)
    return {"base": dict(base), "paint": 3}


@server.tool()
async def brake() -> str:
    """Brake."""
    return "stands"


@server.tool()
async def release() -> str:
    """Give up to brake."""
    return "released"


@server.tool()
async def reach(hand: str, seconds: float = 0.05) -> dict[str, Any]:
    """Reach out."""
    await asyncio.sleep(seconds)
    return {"reached": hand}


@server.tool()
async def stow() -> str:
    """Stop the arm."""
    return "stowed"


@server.tool()
async def grip(force: int) -> str:
    """Grip, or die of it."""
    if force == 9:
        os._exit(3)
    return f"gripped with {force}"


@server.tool()
async def self_destruct() -> str:
    """What nobody has bound."""
    return "boom"


if __name__ == "__main__":
    server.run()
