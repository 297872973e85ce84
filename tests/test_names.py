"""One name, one notion: no two packages have public classes of one name.

Left out are mirrors: the tree of `exover.syntax` beside the model, and what `import exover` offers beside the rest.
"""

import ast
from collections import defaultdict
from pathlib import Path

import exover

ROOT = Path(exover.__file__).parent
MIRRORS = {f"syntax/{name}.py" for name in ("items", "conditions", "properties")} | {"library.py"}


def classes() -> dict[str, list[str]]:
    """Return by name the modules that have a public class of it."""
    found = defaultdict(list)
    for path in sorted(ROOT.rglob("*.py")):
        place = path.relative_to(ROOT).as_posix()
        if place in MIRRORS:
            continue
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                found[node.name].append(place)
    return dict(found)


def test_one_name_one_notion() -> None:
    twice = {name: places for name, places in classes().items() if len(places) > 1}
    assert not twice


def test_the_mirrors_are_there() -> None:
    assert all((ROOT / place).is_file() for place in MIRRORS)
