"""The Markdown files of this folder hold specs, properties, and what is found of each: see the first lines of one."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from exover.checks.questions.property import VACUOUS
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.trace import run
from exover.pipeline import build, load, load_properties
from exover.source import Source
from tests.support.diagrams import check_by_diagrams

BLOCK = re.compile(r"^```(exo|prop)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
EXPECTED = re.compile(r"property (\w+).*// (holds|violated|vacuous)(?: (\d+)(?: (\d+))?)?$")


@dataclass(frozen=True)
class Case:
    """A spec, properties of it, and the name of the file with the line at which they stand."""

    name: str
    spec: str
    properties: str


def cases() -> Iterator[Case]:
    for path in sorted(Path(__file__).parent.glob("*.md")):
        text, spec = path.read_text(), ""
        for block in BLOCK.finditer(text):
            if block[1] == "exo":
                spec = block[2]
            else:
                yield Case(f"{path.name}:{text.count(chr(10), 0, block.start()) + 1}", spec, block[2])


@cache
def model_of(spec: str) -> Model:
    model = load(Source("case.exo", spec)).model
    assert model is not None
    return model


@pytest.mark.parametrize("case", tuple(cases()), ids=lambda case: case.name)
def test_what_is_found_is_what_is_written(case: Case) -> None:
    model = model_of(case.spec)
    loaded = load_properties(Source("case.prop", case.properties), model)
    assert loaded.properties is not None, loaded.diagnostics
    lines = dict(enumerate(case.properties.splitlines(), 1))
    findings = check_by_diagrams(build(model).compiled, properties=loaded.properties).findings
    vacuous = {found.subject for found in findings if (found.check, found.verdict) == ("vacuity", "violated")}
    found = [each for each in findings if each.check == "property"]
    assert [each.subject for each in found] == [each.name for each in loaded.properties.properties]
    for finding in found:
        expected = EXPECTED.match(lines[finding.location.line])
        assert expected is not None, lines[finding.location.line]
        name, said, steps, start = expected.groups()
        assert finding.subject == name
        assert finding.verdict == ("violated" if said == "violated" else "holds"), finding
        assert (finding.message == VACUOUS) == (said == "vacuous") == (name in vacuous), finding
        if finding.trace is not None:
            assert run(Reference(model), finding.trace.events, finding.trace.loop_start) == finding.trace
        if steps is not None:
            assert finding.trace is not None, finding
            assert len(finding.trace.moments) == int(steps), finding.trace
            assert finding.trace.loop_start == (None if start is None else int(start)), finding.trace
        elif said == "violated" and finding.trace is None:
            assert finding.message.startswith(("no run", "the formula is false at the start")), finding
