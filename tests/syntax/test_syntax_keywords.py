"""Only the reserved words are never names: every keyword is a name wherever a name can stand."""

import pytest

from exover.source import Source
from exover.syntax.grammar import grammar
from exover.syntax.lex import NAME, RESERVED
from exover.syntax.parse import parse
from tests.support.format_spec import format_spec

KEYWORDS = sorted({kind for row in grammar().actions for kind in row if kind.isalpha() and kind not in RESERVED})
TYPES = {"bool", "int", "real"}

EVERYWHERE = """
spec zz;
enum en { zz, other }
const zz = zz;
const c2 = zz;
define zz = zz;
define d2 = zz.zz == zz and zz in {zz, zz} or zz in zz .. zz and zz + zz * zz - zz != zz;
define d3 = not zz implies (zz) and zz.zz;
define d4 = active(zz.zz with zz == self.zz and zz) or past(zz, zz.*) or used(zz) > 1 or level(zz) < 1;
define d5 = last(zz.zz) == ok and zz < 1;
group g1 = zz, zz.zz, zz.*;
poster zz: {zz, other} = zz else zz;
poster p2: int in zz .. zz = zz;
latch zz: when zz until zz, zz.zz;
latch l2: when not zz until zz.*;
resource zz: 5 consumable = 5 by kill zz, zz.zz or wait;
module zz {
    state zz: real in zz .. zz = zz;
    request zz(zz: bool, y: {zz}) returns (zz: bool) fails (zz, zz) instances 2 {
        check zz;
        check zz: zz;
        check l1: zz because "x";
        wait until zz;
        wait zz: until zz;
        wait zz: until zz.zz;
        settle until zz;
        settle zz: until zz;
        fail when zz;
        fail zz: when zz else wait;
        after zz, zz.zz;
        before zz, zz.*;
        interrupts zz.zz, zz.*, self, l2;
        uses zz 3 when zz;
        consumes zz 3;
        produces zz 3 when zz == zz;
        on ok set zz = zz;
        on failed set zz.zz = zz;
        on interrupted forget zz, zz.zz;
        on launch forget zz.*;
    }
}
context zz.zz { check zz; }
mutex zz, zz.zz;
mutex zz: zz, zz.*;
mutex zz over zz else wait;
mutex zz: zz.zz over zz.zz;
limit at most 2 of zz;
limit zz: at most 2 of zz, zz.zz by kill zz or reject;
forbid zz;
forbid zz: zz by kill zz;
forbid zz.zz == zz by reject;
forbid zz: zz in {zz} because "x";
launch zz.zz(zz, zz) when zz;
launch zz: zz.zz() when zz.zz;
"""


def parsed(text: str) -> str:
    spec, reports = parse(Source("t", text))
    assert reports == ()
    assert spec is not None
    return format_spec(spec)


@pytest.mark.parametrize("keyword", KEYWORDS)
def test_a_keyword_is_a_name_everywhere(keyword: str) -> None:
    assert parsed(EVERYWHERE.replace("zz", keyword)) == parsed(EVERYWHERE).replace("zz", keyword)


@pytest.mark.parametrize("keyword", sorted(set(KEYWORDS) - TYPES))
def test_a_keyword_is_the_name_of_an_enum(keyword: str) -> None:
    text = "spec s; enum zz { a } poster p: zz = a; module m { request r(x: zz); }"
    assert parsed(text.replace("zz", keyword)) == parsed(text).replace("zz", keyword)


@pytest.mark.parametrize("keyword", sorted(set(KEYWORDS) - {"all"}))
def test_a_keyword_is_the_name_of_a_group(keyword: str) -> None:
    text = "spec s; group zz = a; context m.r { interrupts zz; interrupts zz, self else wait; }"
    assert parsed(text.replace("zz", keyword)) == parsed(text).replace("zz", keyword)


@pytest.mark.parametrize("word", sorted(RESERVED))
@pytest.mark.parametrize(
    "text",
    [
        "spec zz;",
        "spec s; enum e { zz }",
        "spec s; module zz {}",
        "spec s; module m { request zz(); }",
        "spec s; mutex zz: a, b;",
    ],
)
def test_a_reserved_word_is_no_name(word: str, text: str) -> None:
    spec, reports = parse(Source("t", text.replace("zz", word)))
    assert spec is None
    assert [report.code for report in reports] == ["E110"]


@pytest.mark.parametrize("word", ["spec1", "_true", "trueish", "inn", "notx", "self_", "requestfoo", "IN", "True"])
def test_a_word_that_only_begins_like_a_keyword_is_a_name(word: str) -> None:
    assert parsed(EVERYWHERE.replace("zz", word)) == parsed(EVERYWHERE).replace("zz", word)


def test_keywords_compete_with_names_only_where_the_grammar_lists_them() -> None:
    competing = {
        frozenset(kind for kind in row if kind.isalpha() and kind not in RESERVED)
        for row in grammar().actions
        if NAME in row
    }
    predicates = frozenset({"active", "running", "stopping", "waiting", "past", "last", "used", "level"})
    steps = frozenset({"asked", "launched", "rejected", "killed", "ended"})
    operators = frozenset({"X", "F", "G", "EX", "EF", "EG", "AX", "AF", "AG", "A", "E"})
    term = predicates | steps | operators
    assert competing == {
        frozenset(),
        term,
        term | {"never", "always", "possible", "from", "ctl", "ltl"},
        term | {"possible"},
        term | {"U", "R", "W"},
        frozenset({"until"}),
        frozenset({"when"}),
        frozenset({"at"}),
        frozenset(TYPES),
    }
