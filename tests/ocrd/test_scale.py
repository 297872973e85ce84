"""Specs that grow: their tables grow as the rules do, deep diagrams are built, and small ones decide rightly."""

from collections.abc import Callable

import pytest

from benchmarks import families
from exover import pipeline
from exover.ocrd import forest, forms, roots
from exover.raised import TablesTooLarge
from exover.source import Source
from tests.support.engines import disagreement, model_of
from tests.support.events import Stream

ALL = (
    families.mutexes,
    families.priorities,
    families.stop,
    families.crowd,
    families.limit,
    families.limit_all,
    families.power,
    families.contexts,
)
LINEAR = (families.mutexes, families.stop, families.crowd, families.limit, families.contexts)
COMPILED = (families.priorities, families.power)
"""Those that the compiled C is asked about, too."""
Family = Callable[[int], str]


def nodes(text: str) -> int:
    model = pipeline.load(Source("family.exo", text)).model
    assert model is not None
    return pipeline.build(model).compiled.figures.nodes


@pytest.mark.parametrize("family", ALL, ids=lambda family: family.__name__)
def test_the_tables_of_every_family_answer_as_the_reference_does(family: Family) -> None:
    text = family(6)
    found = disagreement(text, tuple(Stream(model_of(text), 0).lines(200)), native=family in COMPILED)
    assert found is None, f"\n{found}"


@pytest.mark.parametrize("family", LINEAR, ids=lambda family: family.__name__)
def test_nodes_are_linear_in_the_rules(family: Family) -> None:
    """Twice as many rules again add as many nodes, but for what a random spec is better or worse off."""
    small, middle, large = (nodes(family(size)) for size in (16, 32, 48))
    assert abs((large - middle) - (middle - small)) <= small // 20


@pytest.mark.parametrize(("family", "per_request"), [(families.stop, 8), (families.crowd, 4)])
def test_diagrams_of_hundreds_of_levels_are_built(family: Family, per_request: int) -> None:
    assert nodes(family(300)) <= per_request * 302


CASES = """spec s;
poster b: int in 0 .. 9 = 0;
module m { request r(x: int in 0 .. 9) instances 3; }
%s
"""


@pytest.mark.parametrize(
    ("rules", "name", "place"),
    [
        ("context m.r { fail when x > b; fail when x + b > 12; }", "m.r", "random.exo:3:20"),
        ("launch l: m.r(4) when b in {1, 3, 5, 7} or b == 9;", "l", "random.exo:4:1"),
        ("latch t: when b in {1, 3, 5, 7} or b == 9 until m.r;", "t", "random.exo:4:7"),
    ],
)
def test_what_tells_too_many_cases_apart_is_refused_at_its_place(
    rules: str, name: str, place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = model_of(CASES % rules)
    pipeline.build(model)
    monkeypatch.setattr(roots, "MOST_NODES", 10)
    with pytest.raises(TablesTooLarge) as refused:
        pipeline.build(model)
    assert str(refused.value).startswith(f"{place}: the tables for `{name}` tell too many cases apart")


def test_what_is_too_much_together_is_refused_where_it_becomes_so(monkeypatch: pytest.MonkeyPatch) -> None:
    requests = " ".join(f"request r{n}(); request s{n}();" for n in range(9))
    rules = "\n".join(f"mutex one{n}: m.r{n}, m.s{n};" for n in range(9))
    model = model_of(f"spec s; module m {{ {requests} }}\n{rules}\n")
    assert pipeline.build(model).compiled.figures.nodes > 20
    monkeypatch.setattr(roots, "MOST_NODES", 20)
    with pytest.raises(TablesTooLarge, match="with those of what stands before it"):
        pipeline.build(model)


def test_a_wide_node_counts_as_the_tests_that_it_becomes(monkeypatch: pytest.MonkeyPatch) -> None:
    values = ", ".join(map(str, range(1, 40, 2)))
    latch = f"latch t: when b in {{{values}}} until m.r;"
    model = model_of(f"spec s; poster b: int in 0 .. 99 = 0; module m {{ request r(); }}\n{latch}")
    pipeline.build(model)
    monkeypatch.setattr(roots, "MOST_NODES", 100)
    with pytest.raises(TablesTooLarge, match="the tables for `t` tell too many cases apart"):
        pipeline.build(model)


@pytest.mark.parametrize("rule", ["limit at most 3 of m.*;", "resource p: 50; context m.r0 { uses p 2; }"])
def test_a_sum_over_all_requests_is_bounded_once(rule: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each request asks for the sum: what bounds it then is what bounds the few terms of which something is known."""

    def terms(count: int) -> int:
        clause = " { uses p 2; }" if "uses" in rule else ";"
        requests = "".join(f"request r{n}(){clause if n else ';'}" for n in range(count))
        model, seen = model_of(f"spec s; module m {{ {requests} }}\n{rule}"), [0]

        def counted(added: tuple[tuple[int, int], ...], ranges: dict[int, forms.Range]) -> forms.Range:
            seen[0] += len(added)
            return forms.span(added, ranges)

        monkeypatch.setattr(forest, "span", counted)
        pipeline.build(model)
        return seen[0]

    assert terms(80) < 3 * terms(40)
