"""A spec in one text, split at random places into parts that include each other."""

import os
from collections.abc import Callable
from random import Random

from exover.source import Source
from exover.syntax.parse import parse

Files = dict[str, str]
ROOT = "spec.exo"


def split(text: str, seed: int) -> Files:
    """Return a spec as files, `spec.exo` first; joined where they are included they are the items of the text."""
    random = Random(seed)
    spec, mistakes = parse(Source(ROOT, text))
    assert spec is not None, mistakes
    items = [text[item.span.start : item.span.end] for item in spec.items]
    files: Files = {}
    _write(files, random, ROOT, f"spec {spec.name.text};", items)
    return files


def _write(files: Files, random: Random, name: str, head: str, items: list[str]) -> None:
    """Write a file with these items, some of them in parts, and some parts included again where they stood already."""
    lines = [head]
    files[name] = ""
    start = 0
    while start < len(items):
        count = random.randint(1, 3)
        chosen = items[start : start + count]
        start += count
        if random.random() < 0.5:
            lines += chosen
            continue
        part = f"{random.choice(('', 'sub/', 'sub/deep/'))}p{len(files)}.exo"
        path = os.path.relpath(part, os.path.dirname(name) or ".").replace(os.sep, "/")
        _write(files, random, part, f"// a part\npart p /* ; */ ; // {len(files)}", chosen)
        lines += [f'include "{path}";'] * random.randint(1, 2)
    files[name] = "\n".join(lines) + random.choice(("", "\n", " // the end"))


def reader(files: Files) -> Callable[[str, int], bytes]:
    """Return what reads these files, by their names relative to that of the spec."""

    def read(path: str, most: int) -> bytes:
        if path not in files:
            raise FileNotFoundError(2, "No such file or directory", path)
        return files[path].encode()[:most]

    return read
