"""What may be written at a place, and nothing else."""

import pytest

from exover.editor.analysis import analyse_properties, analyse_spec
from exover.editor.completion import proposals
from exover.source import Source

SPEC = """spec e;
enum zone { base, dock }
const most = 3;
poster battery: int in 0 .. 9 = 9;
resource power: 9;
module nd {
    poster speed: int in 0 .. 9 = 0;
    state at: zone = base;
    request goto(z: zone) returns (far: bool);
    request stop();
}
module arm { request move(); }
group all_of = nd.goto, arm.move;
"""
CONSTANTS = {"most", "base", "dock"}
TERMS = {"active", "running", "stopping", "waiting", "past", "last", "used", "level", "true", "false"}
STEPS = {"asked", "launched", "rejected", "killed", "ended"}


def offered(text: str, properties: bool = False, before: str = SPEC) -> set[str]:
    """Return what is proposed at the end of a text behind the spec."""
    spec = analyse_spec(Source("e.exo", before))
    if properties:
        source = Source("e.prop", f"for e;\n{text}")
        found = proposals(analyse_properties(source, spec), len(source.text), "properties", spec)
    else:
        source = Source("e.exo", before + text)
        found = proposals(analyse_spec(source, spec), len(source.text), "file")
    return {each.text for each in found}


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("mutex q: ", {"nd", "arm", "all_of"}),
        ("mutex q: nd.", {"goto", "stop"}),
        ("forbid f: nd.", {"speed", "at"}),
        ("forbid f: active(", {"nd", "arm", "all_of"}),
        ("forbid f: active(nd.", {"goto", "stop"}),
        ("forbid f: active(nd.goto with ", {"z", *CONSTANTS, "true", "false", "not"}),
        ("forbid f: past(nd.goto with (z == dock and ", {"z", "far", *CONSTANTS, "true", "false", "not"}),
        ("forbid f: active(nd.goto with z in {", {"z", *CONSTANTS, "true", "false"}),
        ("forbid f: active(nd.goto with nd.", set()),
        ("forbid f: active(nd.goto with z == dock) and ", {"nd", "battery", *CONSTANTS, "not", *TERMS}),
        ("launch l: ", {"nd", "arm"}),
        ("launch l: nd.goto(", {*CONSTANTS, "true", "false"}),
        ("context nd.goto { check x: ", {"z", "speed", "at", "nd", "battery", *CONSTANTS, "self", "not", *TERMS}),
        ("context nd.goto { check self.", {"z"}),
        ("context nd.goto { uses ", {"power"}),
        ("context nd.goto { on ok set ", {"at"}),
        ("context nd.goto { on ok set at = ", {*CONSTANTS, "true", "false"}),
        ("poster x: ", {"zone", "bool", "int", "real"}),
        ("poster x: int in 0 .. ", {"most"}),
        ("poster ", set()),
    ],
)
def test_names_are_those_that_may_stand(text: str, names: set[str]) -> None:
    assert offered(text) == names


TYPED = """enum colour { red, green }
poster side: { left, right } = left;
context nd.goto { wait until side == left; }
module cam { state lit: colour = red; request look(c: colour, n: int in 0 .. 9) { on ok set lit = green; } }
"""


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("forbid f: active(cam.look with c == ", {"red", "green"}),
        ("forbid f: active(cam.look with n == 3 and c != ", {"red", "green"}),
        ("forbid f: active(cam.look with c in { red, ", {"red", "green"}),
        ("forbid f: active(nd.goto with z == ", {"base", "dock"}),
        ("forbid f: side == ", {"left", "right"}),
        ("forbid f: cam.lit == ", {"red", "green"}),
        ("forbid f: battery == ", {"left", "right", "red", "green", "base", "dock"}),
        ("forbid f: active(cam.look with ", {"left", "right", "red", "green", "base", "dock"}),
        ("context nd.goto { check x: z == ", {"base", "dock"}),
        ("context nd.goto { check x: active(cam.look with c == self.", set()),
        ("context nd.goto { check x: self.z == ", {"base", "dock"}),
        ("context cam.look { on ok set lit = ", {"red", "green"}),
    ],
)
def test_enum_values_are_those_of_the_type_opposite(text: str, values: set[str]) -> None:
    assert offered(text, before=SPEC + TYPED) & {"left", "right", "red", "green", "base", "dock"} == values


def test_steps_stand_in_properties_and_temporal_words_in_formulas() -> None:
    condition = offered("property p: always (", properties=True)
    assert condition == {"nd", "battery", *CONSTANTS, "not", *TERMS, *STEPS}
    assert {"G", "EF", *condition} <= offered("property p: ctl ", properties=True)
    assert "G" not in offered("property p: ", properties=True)
    assert offered("property p: never asked(nd.goto with ", properties=True) == {
        *CONSTANTS,
        "z",
        "true",
        "false",
        "not",
    }


def test_behind_what_cannot_be_read_stand_all_names() -> None:
    assert {"nd", "zone", "battery", "all_of"} <= offered("mutex ) ")
    assert offered("mutex ) nd.") == {"goto", "stop", "speed", "at"}


@pytest.mark.parametrize(
    "before",
    [
        "// all of specs/*.exo, see /* there\n",
        '/* a " and // too */ ',
        '/* a " */ ',
        'module m "see http://a.b and /* " { request r(); }\n',
        'module m "a \\" b" { request r(); }\n',
    ],
)
def test_comments_and_strings_before_a_place_hide_it_only_inside(before: str) -> None:
    assert offered(f"{before}mutex q: nd.") == {"goto", "stop"}
    assert offered(before[:-5]) == set()


@pytest.mark.parametrize("number", ["3", "3e", "3.5", "12x"])
def test_nothing_stands_directly_behind_a_number(number: str) -> None:
    assert offered(f"poster x: int in 0 .. 9 = {number}") == set()
    assert "else" in offered("poster x: int in 0 .. 9 = 3 ")
    assert offered("poster x: int in 0..") == {"most"}
