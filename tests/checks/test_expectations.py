"""Every spec says in `// expect:` lines what is not `holds` in it; nothing else may be found, and nothing less."""

from functools import cache
from pathlib import Path

import pytest

from exover.checks.finding import Finding
from exover.loop.claim import APPROXIMATE
from exover.model.semantics import Reference
from exover.model.trace import run
from exover.pipeline import build, check, load
from exover.source import Source
from exover.syntax.decode import decode
from tests.support.diagrams import check_by_diagrams
from tests.support.expected import expected

ROOT = Path(__file__).parents[2]
SPECS = sorted((ROOT / "specs").rglob("*.exo"))


@cache
def findings_of(path: Path) -> tuple[Finding, ...]:
    """Return what diagrams find; what all engines find where reals are compared, which diagrams approximate."""
    source = decode(path.name, path.read_bytes())
    assert isinstance(source, Source)
    model = load(source).model
    assert model is not None
    built = build(model)
    found = check_by_diagrams(built.compiled).findings
    return check(built, lambda _: None).findings if any(f.message == APPROXIMATE for f in found) else found


@pytest.mark.parametrize("path", SPECS, ids=[path.stem for path in SPECS])
def test_a_spec_has_the_findings_it_expects(path: Path) -> None:
    found = findings_of(path)
    assert {f"{f.check} {f.subject} {f.verdict}" for f in found if f.verdict != "holds"} == expected(path)


def test_parts_expect_for_the_specs_that_include_them(tmp_path: Path) -> None:
    (tmp_path / "s.exo").write_text('// expect: safety m.a violated\nspec s;\ninclude "p.exo";\n')
    (tmp_path / "p.exo").write_text('// expect: deadlock m.a violated\npart p;\ninclude "q.exo";\n')
    (tmp_path / "q.exo").write_text("part q;\n// expect: lockout m.b unknown\n")
    assert expected(tmp_path / "s.exo") == {
        "safety m.a violated",
        "deadlock m.a violated",
        "lockout m.b unknown",
    }


def test_every_check_that_a_spec_can_violate_is_violated_by_one() -> None:
    violated = {f.check for path in SPECS for f in findings_of(path) if f.verdict == "violated"}
    assert violated == {
        "consistency",
        "safety",
        "completeness",
        "reachability",
        "deadlock",
        "obligation",
        "rule-use",
        "lockout",
        "starvation",
        "redundancy",
        "idle-guard",
    }


@pytest.mark.parametrize("path", SPECS, ids=[path.stem for path in SPECS])
def test_every_trace_is_a_run_of_the_reference(path: Path) -> None:
    source = decode(path.name, path.read_bytes())
    assert isinstance(source, Source)
    model = load(source).model
    assert model is not None
    traces = [f.trace for f in findings_of(path) if f.trace]
    assert traces
    for trace in traces:
        assert run(Reference(model), trace.events, trace.loop_start) == trace
