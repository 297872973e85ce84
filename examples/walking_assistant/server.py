"""A walking assistant as an MCP server: wheels, an arm, a vacuum cleaner, and a small world to try them in."""

import asyncio
from typing import Any

from mcp.server import MCPServer

server = MCPServer("walking assistant")
wheels: dict[str, Any] = {"phase": "braked", "cm_per_s": 0.0, "still": True}
world: dict[str, Any] = {"leaning": False, "slipping": False, "around": "alone", "cat": {"near": False}}
off = asyncio.Event()
open_hand = asyncio.Event()


@server.tool()
async def look() -> dict[str, Any]:
    """Tell what the walker senses."""
    return {**world, "wheels": wheels}


@server.tool()
async def pretend(leaning: bool = False, slipping: bool = False, around: str = "alone", cat: bool = False) -> str:
    """Let the person lean or slip, people come, the cat appear; let what is not named be over."""
    world.update(leaning=leaning, slipping=slipping, around=around, cat={"near": cat})
    return "so it is"


@server.tool(name="wheels")
async def turn_wheels(command: str, cm_per_s: float = 0.0) -> str:
    """Go, or brake."""
    if command == "go":
        wheels.update(phase="rolling", cm_per_s=cm_per_s, still=False)
        return "rolling"
    return await brake()


@server.tool()
async def stop() -> str:
    """Brake, and return when the wheels stand still."""
    return await brake()


async def brake() -> str:
    await asyncio.sleep(0.05)
    wheels.update(phase="braked", cm_per_s=0.0, still=True)
    return "the wheels stand still"


@server.tool()
async def grab() -> str:
    """Take the cup, which takes a while."""
    open_hand.clear()
    await asyncio.wait([asyncio.create_task(open_hand.wait())], timeout=3)
    return "let go" if open_hand.is_set() else "the cup is in the hand"


@server.tool()
async def hand_over() -> str:
    """Hand over what is in the hand."""
    return "here you are"


@server.tool()
async def let_go() -> str:
    """Open the hand."""
    open_hand.set()
    return "the hand is open"


@server.tool()
async def vacuum(where: str) -> str:
    """Clean a room: Kitchen, Hall or Living room."""
    off.clear()
    await asyncio.wait([asyncio.create_task(off.wait())], timeout=0.2)
    return f"{where}: half done" if off.is_set() else f"{where}: clean"


@server.tool()
async def vacuum_off() -> str:
    """Switch the vacuum cleaner off."""
    off.set()
    return "off"


@server.tool()
async def reboot() -> str:
    """Something that no agent should do: it is not bound."""
    return "bye"


if __name__ == "__main__":
    server.run()
