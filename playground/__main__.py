"""`python -m playground PYODIDE FOLDER`: put the playground together from an unpacked npm package of Pyodide."""

import shutil
import sys
import zipfile
from pathlib import Path

from exover.page.html import put_together

HERE = Path(__file__).parent
ROOT = HERE.parent
PYODIDE = ("pyodide.js", "pyodide.asm.js", "pyodide.asm.wasm", "python_stdlib.zip", "pyodide-lock.json")
KEPT = {".py", ".json", ".lark", ".md", ".html", ".css", ".js"}
LOADS = "worker-src 'self'; connect-src 'self'; "
EXAMPLE = ROOT / "specs" / "rover.exo"


def main(pyodide: Path, folder: Path) -> None:
    """Write the folder; any static server can serve it."""
    (folder / "pyodide").mkdir(parents=True, exist_ok=True)
    for name in PYODIDE:
        shutil.copyfile(pyodide / name, folder / "pyodide" / name)
    with zipfile.ZipFile(folder / "exover.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted((ROOT / "exover").rglob("*")):
            if path.suffix in KEPT and path.is_file() and "docs" not in path.parts:
                archive.write(path, path.relative_to(ROOT))
        for path in sorted((ROOT / "docs").glob("*.md")):
            archive.write(path, Path("exover", "docs", path.name))
    shutil.copyfile(EXAMPLE, folder / "example.exo")
    shutil.copyfile(HERE / "worker.js", folder / "worker.js")
    start = (HERE / "playground.js").read_text("utf-8")
    page = put_together("exover playground", "null", start, "'self' 'wasm-unsafe-eval'", LOADS)
    (folder / "index.html").write_text(page, "utf-8")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
