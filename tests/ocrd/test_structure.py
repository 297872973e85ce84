"""Tables that were forged, with right checksums: each is refused, or runs to an end and raises nothing else."""

import random
from collections.abc import Iterator
from dataclasses import fields, replace
from pathlib import Path

import pytest

import exover
from benchmarks import families
from exover.ocrd.packing import SECTIONS, decode, pack
from exover.ocrd.structure import verify
from exover.ocrd.tables import Tables
from tests.support.engines import model_of
from tests.support.events import Stream
from tests.support.small import compiled, small_spec_of

KINDS = dict(SECTIONS)
SPECS = sorted((Path(__file__).parents[2] / "specs").glob("*.exo"))


@pytest.mark.parametrize("number", range(12))
def test_tables_that_were_made_are_sound(number: int) -> None:
    made = compiled(model_of(small_spec_of(number)))
    verify(made.tables, made.model)


@pytest.mark.parametrize("text", [families.power(6), families.contexts(6), families.stop(6), families.limit_all(6)])
def test_tables_of_families_are_sound(text: str) -> None:
    made = compiled(model_of(text))
    verify(made.tables, made.model)


@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_tables_of_the_specs_are_sound(path: Path) -> None:
    made = compiled(model_of(path.read_text(encoding="utf-8")))
    verify(made.tables, made.model)


def forged(tables: Tables, rng: random.Random) -> Iterator[Tables]:
    """Yield tables of which one number is another one."""
    while True:
        section = rng.choice([name for name in KINDS if getattr(tables, name)] + ["sums", "lists"])
        rows = list(getattr(tables, section))
        if not rows:
            continue
        at = rng.randrange(len(rows))
        wrong = rng.choice((-9, -3, -2, -1, 0, 1, 2, at, len(rows), rng.randrange(40), 30_000))
        if section == "lists":
            rows[at] = wrong
        elif section == "sums":
            rows[at] = (wrong, rows[at][1])
        else:
            rows[at] = replace(rows[at], **{rng.choice(fields(KINDS[section])).name: wrong})
        yield replace(tables, **{section: tuple(rows)})


@pytest.mark.parametrize("number", range(8))
def test_forged_tables_raise_one_error(number: int) -> None:
    spec = exover.loads(small_spec_of(number))
    good = exover.compile(spec)
    lines = tuple(Stream(spec.model, 0).lines(60))
    rng, refused = random.Random(number), 0
    for _, tables in zip(range(150), forged(decode(good.data), rng), strict=False):
        try:
            exover.simulate(exover.load_tables(pack(tables), spec), lines)
        except exover.TablesError:
            refused += 1
    assert refused > 30


def test_what_is_forged_is_named() -> None:
    spec = exover.loads("spec s; module m { request a(); request b(); } mutex one: m.a, m.b;")
    tables = decode(exover.compile(spec).data)
    node = replace(tables.nodes[0], low=0)
    circle = pack(replace(tables, nodes=(node, *tables.nodes[1:])))
    with pytest.raises(exover.TablesError, match="record 0 of the section nodes cannot be of this spec"):
        exover.load_tables(circle, spec)
