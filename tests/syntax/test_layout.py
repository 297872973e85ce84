"""The canonical layout: tokens and comments stay, laying out again changes nothing, and neither does the meaning."""

from pathlib import Path
from random import Random

import pytest

from exover.model.canonical import digest
from exover.ocrd.compile import compile_model
from exover.ocrd.packing import pack
from exover.pipeline import load
from exover.places import is_part
from exover.source import Source
from exover.syntax.grammar import Start
from exover.syntax.layout import WIDTH, formatted, laid_out, start_of
from exover.syntax.lex import END, tokens
from tests.support.generate import random_spec
from tests.support.scene import Size
from tests.support.small import VARIED, small_spec_of

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("specs", "properties", "tests")
FILES = sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.suffix in (".exo", ".prop"))
SAMPLE = (Path(__file__).with_name("sample.exo")).read_text("utf-8")


def words(text: str, start: Start) -> list[str]:
    return [token.text for token in tokens(text, [], start == "properties")]


def settled(text: str, start: Start = "file") -> str:
    """Return the layout of a text, which keeps its tokens and is its own layout."""
    found = laid_out(text, start)
    assert words(found, start) == words(text, start)
    assert laid_out(found, start) == found
    assert not any(line != line.rstrip() for line in found.split("\n"))
    return found


def tables(text: str) -> tuple[bytes, bytes]:
    model = load(Source("s.exo", text)).model
    assert model is not None
    return digest(model), pack(compile_model(model, digest(model)).tables)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_specs_and_properties_of_the_project(path: Path) -> None:
    source = Source(path.name, path.read_text("utf-8"))
    found, mistakes = formatted(source)
    assert found is not None and not mistakes
    assert settled(source.text, start_of(source)) == found
    if path.suffix == ".exo" and path.name != "sample.exo" and not is_part(str(path)):
        models = [load(Source(path.name, text)).model for text in (source.text, found)]
        assert models[0] is not None and models[1] is not None
        assert digest(models[0]) == digest(models[1])


@pytest.mark.parametrize("seed", VARIED)
def test_random_specs_mean_the_same_and_give_the_same_bytes(seed: int) -> None:
    small = small_spec_of(seed)
    assert tables(settled(small)) == tables(small)
    settled(random_spec(seed, Size()))


@pytest.mark.parametrize("seed", (1, 6, 8, 10, 21))
def test_blanks_make_no_difference(seed: int) -> None:
    random = Random(seed)
    text = random_spec(seed, Size())
    words = [token.text for token in tokens(text, []) if token.kind != END]
    one, other = ("".join(word + random.choice((" ", "\n", "\t", " \r\n ")) for word in words) for _ in range(2))
    assert settled(one) == settled(other)


@pytest.mark.parametrize("seed", range(40))
def test_comments_anywhere_are_kept_in_order(seed: int) -> None:
    random = Random(seed)
    text = random_spec(seed, Size(requests=3, rules=3)) if seed % 2 else SAMPLE
    pieces: list[str] = []
    comments: list[str] = []
    for token in tokens(text, []):
        while random.random() < 0.15:
            comments.append(random.choice((f"// line {len(comments)}", f"/* block {len(comments)} */", "/* a\n  b */")))
            pieces += [random.choice(("", " ", "\n", "\n\n")), comments[-1], "\n" * comments[-1].startswith("//")]
        pieces += [random.choice((" ", "\n", "\n\n\n")), token.text]
    mixed = "".join(pieces)
    found = settled(mixed)
    places = [found.index(comment) for comment in comments if not comment.startswith("/* a")]
    assert places == sorted(places)
    assert sum(map(found.count, ("//", "/*"))) >= len(comments)


def test_the_layout_as_it_is() -> None:
    text = """/* head */ spec it; // its name
enum zone {base,dock}
module m{}
module nd "drives"{ // of the rover

  // where to
  request goto(x:real in -50..50)returns(dist:real in 0..200)fails(blocked,lost)instances 2{check x-1>-2*x or not(hot);


  uses power 3;}request stop();
  // the end of nd
}
mutex nd.goto // why
 ,nd.stop because "x"; forbid not(active(nd.goto with x==1)and zone in{base,dock});
context nd.stop{interrupts all;}
launch nd.goto(-1)when level(film)<3;// later
"""
    assert (
        settled(text)
        == """/* head */
spec it; // its name

enum zone { base, dock }

module m {}

module nd "drives" { // of the rover
    // where to
    request goto(x: real in -50 .. 50) returns (dist: real in 0 .. 200) fails (blocked, lost)
            instances 2 {
        check x - 1 > -2 * x or not (hot);

        uses power 3;
    }
    request stop();
    // the end of nd
}

mutex nd.goto // why
    , nd.stop because "x";
forbid not (active(nd.goto with x == 1) and zone in {base, dock});

context nd.stop {
    interrupts all;
}

launch nd.goto(-1) when level(film) < 3; // later
"""
    )


def test_properties_as_they_are() -> None:
    text = """for s; define d=active(m.a)or past(m.b);
property p "the text of it":always(asked(m.a)implies not rejected(m.a)and not active(m.b)and not past(m.b));
property q:ltl G(waiting(m.a)->F(active(m.a)|!waiting(m.a)));property r:ctl A[!active(m.a)U past(m.b)];
assume fair reports; // they come
"""
    assert (
        settled(text, "properties")
        == """for s;

define d = active(m.a) or past(m.b);
property p "the text of it":
    always (asked(m.a) implies not rejected(m.a) and not active(m.b) and not past(m.b));
property q: ltl G (waiting(m.a) -> F (active(m.a) | !waiting(m.a)));
property r: ctl A [ !active(m.a) U past(m.b) ];
assume fair reports; // they come
"""
    )


def test_lines_are_broken_where_they_can_be() -> None:
    names = ", ".join(f"m.request_{number}" for number in range(40))
    conditions = " and ".join(f"(hot_{number} or cold_{number})" for number in range(30))
    found = settled(f'spec s; mutex {names} by wait because "they share one tool"; forbid {conditions};')
    assert all(len(line) <= WIDTH for line in found.split("\n"))
    assert found.count("\n") > 10


def test_text_with_mistakes_is_not_laid_out() -> None:
    found, mistakes = formatted(Source("s.exo", "spec s; mutex a b;"))
    assert found is None and [mistake.code for mistake in mistakes] == ["E106"]


def test_what_a_text_is() -> None:
    assert start_of(Source("a.prop", "spec s;")) == "properties"
    assert start_of(Source("a.exo", "for s;")) == "file"
    assert start_of(Source("standard input", "// for\nfor s;")) == "properties"
    assert start_of(Source("standard input", "")) == "file"


def test_comments_inside_a_statement_stay_where_they_are() -> None:
    text = "spec s; mutex m.a,\n// own line\nm.b/* behind */,m.c// last\n;forbid a/* x */or b\n/* own */ or c;"
    assert (
        settled(text)
        == """spec s;

mutex m.a,
    // own line
    m.b /* behind */, m.c // last
    ;
forbid a /* x */ or b
    /* own */ or c;
"""
    )


def test_comments_on_one_line_stay_on_it() -> None:
    text = "/* a */ /* b */ // c\nspec s;\n/* d\n   e */ /* f */ mutex m.a, m.b; /* g */ /* h */\n/* i *//* j */"
    assert (
        settled(text)
        == """/* a */ /* b */ // c
spec s;

/* d
   e */ /* f */
mutex m.a, m.b; /* g */ /* h */
/* i */ /* j */
"""
    )
