"""Small specs for commands, and the files that they write."""

from pathlib import Path

SPEC = """spec demo;
poster battery: int in 0 .. 100 = 100 else 0;
module nd { request goto(x: real in 0 .. 9); request stop(); }
mutex drive: nd.stop over nd.goto because "a stop is a stop";
"""


DEAF = SPEC + "forbid deaf: (battery < 9 or battery > 3) and active(nd.goto);\n"
"""No goto is ever launched."""
SHADOWED = SPEC + "mutex again: nd.stop over nd.goto;\n"
"""The second mutex is never the reason of anything."""


def written(folder: Path, spec: str, properties: str) -> Path:
    """Return the file `s.exo` of a spec, beside which its properties stand."""
    (folder / "s.prop").write_text(properties)
    file = folder / "s.exo"
    file.write_text(spec)
    return file


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}
