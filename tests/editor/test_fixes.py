"""What mends a mistake by one change of the text."""

import pytest

from exover.editor.analysis import analyse_spec
from exover.editor.fixes import fix
from exover.source import Source

SPEC = "spec e;\nposter p: int in 0 .. 9 = 0;\nmodule m { request a() { check CONDITION; } }\n"


@pytest.mark.parametrize(
    ("written", "mended"),
    [
        ("p <> 1", "p != 1"),
        ("p =< 1", "p <= 1"),
        ("p ≠ 1", "p != 1"),
        ("~(p == 1)", "not(p == 1)"),
        ("p < > 1", None),
        ("p => 1", None),
        ("p == 1 ^ p == 2", None),
        ("p = 1", None),
    ],
)
def test_advice_that_is_one_change_mends_the_text(written: str, mended: str | None) -> None:
    source = Source("e.exo", SPEC.replace("CONDITION", written))
    changes = [found for each in analyse_spec(source).mistakes if (found := fix(each, source))]
    texts = [source.text[: each.span.start] + each.text + source.text[each.span.end :] for each in changes]
    assert texts == ([SPEC.replace("CONDITION", mended)] if mended else [])
