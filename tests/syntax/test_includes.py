"""Several files as one text (docs/language.md section 10)."""

from functools import cache

import pytest

from exover.model.canonical import digest
from exover.pipeline import Loaded, build, load
from exover.source import Source
from exover.syntax import includes
from exover.syntax.includes import gather, one_text, original
from exover.syntax.parse import parse
from tests.support.constructs import seldom
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.format_spec import format_spec
from tests.support.generate import random_spec
from tests.support.scene import Size
from tests.support.splitting import ROOT, Files, reader, split

SMALL = Size(requests=3, modules=2, readings=2, resources=1, rules=3, clauses=2, depth=1, instances=1)


MANY = range(40)
SEEDS = (1, 6, 10, 12, 16, 21, 28, 32, 35)
"""Random specs of which three have each construct of the many, or as many as there are."""


@cache
def random_files(seed: int) -> tuple[str, Files]:
    """Return a random spec in one text, and split."""
    text = random_spec(seed, Size())
    return text, split(text, seed)


def loaded(files: Files) -> Loaded:
    return load(Source(ROOT, files[ROOT]), reader(files))


def told(files: Files) -> list[str]:
    """Return what is wrong, as `CODE FILE:LINE:COLUMN`."""
    found = loaded(files)
    places = [(each.code, found.source.place(each.span.start)) for each in found.diagnostics if each.span]
    assert len(places) == len(found.diagnostics)
    return [f"{code} {file}:{line}:{column}" for code, (file, line, column) in places]


def message(files: Files) -> str:
    (found,) = loaded(files).diagnostics
    return f"{found.message} ({found.label})" if found.label else found.message


WORLD = "part w; module m { request a(); request b(); }"


@pytest.mark.parametrize("seed", SEEDS)
def test_a_split_spec_is_the_one_text(seed: int) -> None:
    text, files = random_files(seed)
    whole, one = gather(Source(ROOT, files[ROOT]), reader(files)), load(Source(ROOT, text))
    assert whole.spec is not None and whole.mistakes == ()
    assert format_spec(whole.spec) == format_spec(parse(Source(ROOT, text))[0])
    several = loaded(files)
    assert several.model == one.model
    assert digest(several.model) == digest(one.model)
    assert build(several.model).data == build(one.model).data


def test_some_specs_are_split_into_many_files() -> None:
    assert max(len(random_files(seed)[1]) for seed in SEEDS) > 20


def test_few_have_every_construct() -> None:
    models = {seed: model_of(random_spec(seed, Size())) for seed in MANY}
    assert not seldom([(models[seed],) for seed in SEEDS], [(model,) for model in models.values()], 3)


@pytest.mark.parametrize("seed", (0, 3))
def test_the_findings_of_a_split_spec_are_those_of_the_one_text(seed: int) -> None:
    text = random_spec(seed, SMALL)
    files = split(text, seed)
    one, several = (
        check_by_diagrams(build(each.model).compiled).findings for each in (load(Source(ROOT, text)), loaded(files))
    )
    assert [(f.check, f.subject, f.verdict, f.message) for f in one] == [
        (f.check, f.subject, f.verdict, f.message) for f in several
    ]
    places = [(text, f.location.line) for f in one], [(files[f.location.file], f.location.line) for f in several]
    assert [_line(*place) for place in places[0]] == [_line(*place) for place in places[1]]


def _line(text: str, line: int) -> str:
    """Return a line of a text without the comment that ends a file of the split, "" for the line 0 of no place."""
    return ["", *text.split("\n")][line].removesuffix(" // the end")


@pytest.mark.parametrize("seed", range(20))
def test_the_one_text_reads_as_the_files_do_and_leads_back_to_them(seed: int) -> None:
    _, files = random_files(seed)
    whole = gather(Source(ROOT, files[ROOT]), reader(files))
    text = one_text(whole)
    spec, mistakes = parse(Source(ROOT, text))
    assert mistakes == ()
    assert spec == whole.spec
    for here, there in zip(spec.items, whole.spec.items, strict=True):
        assert original(whole, here.span.start) == there.span.start


def test_a_part_that_is_included_again_adds_nothing() -> None:
    files = {ROOT: 'spec s; include "w.exo"; include "./w.exo"; include "x/../w.exo";', "w.exo": WORLD}
    assert told(files) == []
    assert [request.name for request in loaded(files).model.requests] == ["m.a", "m.b"]


def test_the_order_is_that_of_the_first_include() -> None:
    files = {
        ROOT: 'spec s; module z { request a(); } include "x.exo"; include "y.exo"; module e { request a(); }',
        "x.exo": 'part x; module x { request a(); } include "y.exo"; module w { request a(); }',
        "y.exo": "part y; module y { request a(); }",
    }
    assert [request.name for request in loaded(files).model.requests] == ["z.a", "x.a", "y.a", "w.a", "e.a"]


def test_names_that_number_rules_count_through_the_files() -> None:
    files = {
        ROOT: 'spec s; include "w.exo"; include "r.exo"; mutex m.a, m.b;',
        "w.exo": WORLD,
        "r.exo": "part r; mutex m.a, m.b;",
    }
    model = loaded(files).model
    assert [(rule.name, rule.location.file) for rule in model.rules if rule.name.startswith("mutex")] == [
        ("mutex.1", "r.exo"),
        ("mutex.2", ROOT),
    ]


def test_places_name_their_files() -> None:
    files = {
        ROOT: 'spec s;\ninclude "a/w.exo";\nmutex m.a, m.c;',
        "a/w.exo": 'part w;\ninclude "../r.exo";\nmodule m { request a(); request b(); }',
        "r.exo": "part r;\n\n  forbid active(m.x);",
    }
    assert told(files) == ["E203 spec.exo:3:12", "E203 r.exo:3:17"]


def test_a_name_that_is_declared_twice_is_one_error_with_both_places() -> None:
    files = {ROOT: 'spec s;\ninclude "w.exo";\nmodule m { request c(); }', "w.exo": "\n" + WORLD}
    assert told(files) == ["E210 spec.exo:3:8"]
    assert "first declared at w.exo:2:16" in message(files)
    rules = {ROOT: 'spec s; include "w.exo"; mutex r: m.a, m.b;', "w.exo": WORLD + "\nmutex r: m.a, m.b;"}
    assert told(rules) == ["E211 spec.exo:1:32"]
    assert "the first stands at w.exo:2:7" in message(rules)
    unknown = {ROOT: 'spec s; include "w.exo"; mutex m.a, m.x;', "w.exo": WORLD + "\nmutex m.a, m.x;"}
    assert "used again on line w.exo:2" in message(unknown)


def test_syntax_mistakes_of_all_files_are_told() -> None:
    files = {ROOT: 'spec s;\ninclude "a.exo";\ninclude "b.exo";', "a.exo": "part a;\nmutex;", "b.exo": "part b\n"}
    assert told(files) == ["E106 a.exo:2:6", "E107 b.exo:1:7"]


@pytest.mark.parametrize(
    ("path", "code"),
    [
        ("", "E008"),
        ("w.exo/", "E008"),
        ("/w.exo", "E008"),
        ("C:/w.exo", "E008"),
        ("c:w.exo", "E008"),
        ("a\\\\w.exo", "E008"),
        ("w\\n.exo", "E008"),
        ("none.exo", "E005"),
        ("spec.exo", "E007"),
        ("other.exo", "E006"),
        ("bytes.exo", "E005"),
    ],
)
def test_what_cannot_be_included_is_an_error_at_the_include(path: str, code: str) -> None:
    files = {
        ROOT: f'spec s;\nmodule m {{ request a(); }}\n  include "{path}";',
        "w.exo": WORLD,
        "other.exo": "spec o;",
        "bytes.exo": "part b;\0",
    }
    assert told(files) == [f"{code} spec.exo:3:3"]


@pytest.mark.parametrize("space", ["\u00a0", "\u200d", "\u3000", "\ue000"])
def test_a_path_may_have_any_character_but_those_for_control(space: str) -> None:
    assert told({ROOT: f'spec s; include "w{space}.exo";', f"w{space}.exo": WORLD}) == []


@pytest.mark.parametrize("text", ["", "module n { request b(); }", "for n;"])
def test_what_is_included_begins_as_a_part(text: str) -> None:
    (mistake,) = loaded({ROOT: 'spec s; include "w.exo"; include "n.exo";', "w.exo": WORLD, "n.exo": text}).diagnostics
    assert "`part NAME;`" in mistake.help and "`spec NAME;`" not in mistake.message + mistake.help


def test_a_text_without_a_place_includes_nothing() -> None:
    (mistake,) = load(Source("<text>", 'spec s; module m { request a(); } include "w.exo";')).diagnostics
    assert (mistake.code, mistake.span.start) == ("E005", 34)


def test_a_part_is_no_spec() -> None:
    assert told({ROOT: WORLD}) == ["E009 spec.exo:1:6"]


def test_a_circle_is_shown() -> None:
    files = {
        ROOT: 'spec s; include "a.exo";',
        "a.exo": 'part a; include "b.exo";',
        "b.exo": 'part b;\ninclude "x/../a.exo";',
    }
    assert told(files) == ["E007 b.exo:2:1"]
    assert message(files) == "`a.exo` includes itself (a.exo -> b.exo -> a.exo)"


def test_includes_are_nested_only_so_deep() -> None:
    def chain(length: int) -> Files:
        parts = {f"p{each}.exo": f'part p; include "p{each + 1}.exo";' for each in range(length)}
        return {ROOT: 'spec s; include "p0.exo"; module m { request a(); }', **parts, f"p{length}.exo": "part p;"}

    assert told(chain(63)) == []
    assert told(chain(64)) == ["E007 p63.exo:1:9"]


def test_tokens_count_together(monkeypatch: pytest.MonkeyPatch) -> None:
    files = {ROOT: 'spec s; include "w.exo";', "w.exo": WORLD}
    monkeypatch.setattr("exover.syntax.parse.MAX_TOKENS", 23)
    assert told(files) == []
    monkeypatch.setattr("exover.syntax.parse.MAX_TOKENS", 22)
    assert told(files) == ["E003 w.exo:1:46"]


def test_sizes_count_together(monkeypatch: pytest.MonkeyPatch) -> None:
    files = {ROOT: 'spec s; include "w.exo";', "w.exo": WORLD}
    monkeypatch.setattr(includes, "MAX_BYTES", len(files[ROOT]) + len(WORLD))
    assert told(files) == []
    monkeypatch.setattr(includes, "MAX_BYTES", len(files[ROOT]) + len(WORLD) - 1)
    assert told(files) == ["E003 spec.exo:1:9"]


def test_include_and_part_are_names_elsewhere() -> None:
    text = (
        "spec part; module include { request part(include: bool); request include(); } mutex include.part, include.*;"
    )
    assert {each.code for each in load(Source(ROOT, text)).diagnostics} == {"E409"}
    files = {ROOT: 'spec include; include "w.exo";', "w.exo": "part part; module part { request include(); }"}
    assert told(files) == []


@pytest.mark.parametrize("text", ['module m { include "w.exo"; }', "include w;", 'include "w.exo"', "include;"])
def test_an_include_is_a_statement_of_the_top_level(text: str) -> None:
    assert {each.split()[0] for each in told({ROOT: f"spec s; {text}"})} <= {"E106", "E107"}
    assert told({ROOT: f"spec s; {text}"})


def test_nothing_is_lost_of_offsets_at_the_ends_of_files() -> None:
    files = {ROOT: 'spec s; include "w.exo"', "w.exo": WORLD}
    assert told(files) == ["E107 spec.exo:1:24"]
    files = {ROOT: 'spec s; include "w.exo"; include "v.exo";', "w.exo": "part w; mutex m.a", "v.exo": "mutex"}
    assert told(files) == ["E107 w.exo:1:18", "E106 v.exo:1:1", "E106 v.exo:1:6"]
