"""What mends a mistake by one change of the text."""

import pytest

from exover.editor.analysis import TextAnalysis, analyse_properties, analyse_spec
from exover.editor.fixes import fix, removes
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


DECLARED = "spec e;\nresource film: 3 consumable;\nmodule m { request a() { CLAUSE } }\n"


def analysed(text: str) -> TextAnalysis:
    if text.startswith("for"):
        return analyse_properties(Source("e.prop", text), analyse_spec(Source("e.exo", DECLARED.replace("CLAUSE", ""))))
    return analyse_spec(Source("e.exo", text))


@pytest.mark.parametrize(
    ("written", "mended"),
    [
        ("for e; property p: nevr active(m.a);", "for e; property p: never active(m.a);"),
        ("for e; property p: always // nevr\n active(m.a) active;", None),
        ("spec e; forbid activ(m.a);", "spec e; forbid active(m.a);"),
        ("spec e; mutx m.a, m.b;", "spec e; mutex m.a, m.b;"),
        (DECLARED.replace("CLAUSE", "uses film 3;"), DECLARED.replace("CLAUSE", "consumes film 3;")),
        (DECLARED.replace("CLAUSE", "check used(film) < 3;"), None),
    ],
)
def test_the_word_is_replaced_that_is_meant(written: str, mended: str | None) -> None:
    found = analysed(written)
    changes = [(each, change) for each in found.mistakes if (change := fix(each, found.document))]
    texts = [(each, change, change.applied(found.document)) for each, change in changes]
    kept = [text for each, change, text in texts if removes(change, each, found.document, analysed(text))]
    assert kept == ([mended] if mended else [])
