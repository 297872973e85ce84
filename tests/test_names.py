"""One name, one notion: no two packages have public classes of one name, and no type is imported under two meanings.

Left out are mirrors: the tree of `exover.syntax` beside the model, the checker of certificates, which shares nothing
with the rest, and what `import exover` offers beside the rest.
"""

import ast
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import exover

ROOT = Path(exover.__file__).parent
MIRRORS = {f"syntax/{name}.py" for name in ("items", "conditions", "properties")} | {"library.py"}
CHECKER = "certificate/"


@cache
def trees() -> dict[str, ast.Module]:
    """Return the modules by their places, mirrors left out."""
    places = {path.relative_to(ROOT).as_posix(): path for path in sorted(ROOT.rglob("*.py"))}
    return {place: ast.parse(path.read_text("utf-8")) for place, path in places.items() if place not in MIRRORS}


def defined(tree: ast.Module) -> Iterator[str]:
    """Yield the names of the types that a module defines: classes and aliases."""
    for node in tree.body:
        match node:
            case ast.ClassDef(name=name):
                yield name
            case ast.Assign(targets=[ast.Name(id=name)]) if name[0].isupper() and not name.isupper():
                yield name


def twice(found: dict[str, set[str]]) -> dict[str, list[str]]:
    return {name: sorted(places) for name, places in found.items() if len(places) > 1}


def test_one_name_one_notion() -> None:
    classes = defaultdict(set)
    for place, tree in trees().items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                classes[node.name].add(place)
    assert not twice(classes)


def test_a_type_that_is_imported_has_one_meaning() -> None:
    there = {
        f"exover.{place.removesuffix('.py').replace('/', '.')}": (place, set(defined(tree)))
        for place, tree in trees().items()
        if not place.startswith(CHECKER)
    }
    imported = defaultdict(set)
    for tree in trees().values():
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module in there:
                place, types = there[node.module]
                for name in types.intersection(each.name for each in node.names):
                    imported[name].add(place)
    assert not twice(imported)


def test_the_mirrors_are_there() -> None:
    assert all((ROOT / place).is_file() for place in MIRRORS)
