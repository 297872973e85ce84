"""A text that was changed has the tree that it would have if it were read anew, places included."""

from random import Random

import pytest

from exover.source import Source
from exover.syntax import reparse as module
from exover.syntax.parse import parse
from exover.syntax.reparse import SpecTree, reparse
from tests.support.small import small_spec_of

SPEC = """// what for
spec s;
enum e { a, b }
poster p: int in 0 .. 9 = 0 else 9; // read
module m {
    request a() { check low: p < 5; }
    request b();
}
mutex ab: m.a, m.b by wait because "one";
forbid late: p > 7 and active(m.a);
// the end
"""
PIECES = (
    "",
    ";",
    "}",
    "{",
    "/*",
    "*/",
    "//",
    '"',
    "\n",
    " ",
    "x",
    "p",
    "9",
    "mutex ",
    "m.a, ",
    "forbid q: p > 8;",
    "\0",
    "all",
)


def read(text: str) -> SpecTree:
    source = Source("s.exo", text)
    tree, mistakes = parse(source)
    assert tree is not None, mistakes
    return SpecTree(source, tree)


def same(text: str, before: SpecTree) -> SpecTree:
    """Assert that a text is read as if there were none before; return the newest that could be read."""
    source = Source("s.exo", text)
    found, wanted = reparse(source, before), parse(source)
    assert repr(found) == repr(wanted)  # spans do not count for equality
    return SpecTree(source, found[0]) if found[0] else before


@pytest.mark.parametrize("seed", range(4))
def test_edits_of_a_spec(seed: int) -> None:
    random = Random(seed)
    text = small_spec_of(seed) if seed else SPEC
    before = read(text)
    for _ in range(120):
        start = random.randrange(len(text) + 1)
        end = min(len(text), start + random.choice((0, 0, 1, 3, 40)))
        changed = text[:start] + random.choice(PIECES) + text[end:]
        after = same(changed, before)
        if after is not before:
            text, before = changed, after


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("p < 5", "p < 6"),
        ("p < 5", "p < 15"),
        ("enum e { a, b }", "enum e { a, b };"),
        ("mutex ab", "// mutex ab"),
        ("mutex ab", "/* mutex ab"),
        ("// the end", "group all = m;\n// the end"),
        ("// the end", "forbid more: p > 8; // the end"),
        ("forbid late: p > 7 and active(m.a);\n", ""),
        ("enum e { a, b }\n", ""),
        ("else 9; // read\n", "else 9;"),
        ("spec s;", "spec t;"),
        ("", "\n"),
        (SPEC, "spec s;\n"),
        (SPEC, ""),
    ],
)
def test_changes_at_the_seams(old: str, new: str) -> None:
    same(SPEC.replace(old, new, 1), read(SPEC))


def test_only_what_has_changed_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    parsed: list[str] = []
    items = module.parse_items
    monkeypatch.setattr(module, "parse_items", lambda source: parsed.append(source.text) or items(source))
    monkeypatch.setattr(module, "parse", lambda source: pytest.fail("read whole"))
    reparse(Source("s.exo", SPEC.replace("m.b by", "m.b, m.a by")), read(SPEC))
    (text,) = parsed
    assert text.strip() == 'mutex ab: m.a, m.b, m.a by wait because "one";\nforbid late: p > 7 and active(m.a);'
