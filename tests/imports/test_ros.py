"""Definitions of ROS 2 as parts of specs (docs/imports.md). The definitions were written for these tests."""

from pathlib import Path

import pytest

from exover.imports.part import Imported, UnreadableDescription
from exover.imports.ros import import_ros, named
from exover.pipeline import load
from exover.source import Source
from exover.syntax.layout import formatted
from tests.support.breaking import broken

ACTION = """# where to
bool use_id true
string id "home"
geometry_msgs/PoseStamped pose
float32 seconds 10.0
---
uint16 NONE=0
uint16 LOST=901
bool success
uint16 code   # one of those above
uint64 ticks
---
uint16 state
builtin_interfaces/Time since
"""
SERVICE = "uint8 AUTO=1\nint8 mode\n---\nbool mode\nstring<=8 message\n"
MESSAGE = "std_msgs/Header header\nfloat32 percentage\nbool present\nfloat64[3] cells\nint32[] many\n"


def imported(*files: tuple[str, str], head: str = "part p;") -> Imported:
    return import_ros([Source(name, text) for name, text in files], head)


def test_the_whole_part() -> None:
    found = imported(
        ("a/dock_msgs/action/DockRobot.action", ACTION),
        ("a/dock_msgs/srv/SetMode.srv", SERVICE),
        ("a/power_msgs/msg/BatteryState.msg", MESSAGE),
    )
    assert (
        found.text
        == """part p;

module dock_msgs {
    // DockRobot.action
    // constant of the result: NONE = 0
    // constant of the result: LOST = 901
    // DockRobot.action:3: `id` is left out: a string
    // DockRobot.action:4: `pose` is left out: a message `geometry_msgs/msg/PoseStamped`
    // DockRobot.action:11: `ticks` is taken for `int in 0 .. 9223372036854775807`: exo has no integers above it
    // DockRobot.action:13: `state` is left out: it is feedback, which no request has
    // DockRobot.action:14: `since` is left out: it is feedback, which no request has
    request dock_robot(use_id: bool, seconds: real)
        returns (success: bool, code: int in 0 .. 65535, ticks: int in 0 .. 9223372036854775807);
    // SetMode.srv
    // constant of the request: AUTO = 1
    // SetMode.srv:4: `mode` goes in and comes out: what comes out is left out
    // SetMode.srv:5: `message` is left out: a string
    request set_mode(mode: int in -128 .. 127);
}

module power_msgs {
    // BatteryState.msg
    // BatteryState.msg:1: `battery_state_header` is left out: a message `std_msgs/msg/Header`
    // BatteryState.msg:2: `battery_state_percentage` is taken to be 0 until it is first observed
    poster battery_state_percentage: real = 0;
    // BatteryState.msg:3: `battery_state_present` is taken to be false until it is first observed
    poster battery_state_present: bool = false;
    // BatteryState.msg:4: `battery_state_cells` is left out: an array
    // BatteryState.msg:5: `battery_state_many` is left out: a sequence
}
"""
    )
    assert formatted(Source("p.exo", found.text)) == (found.text, ())
    assert load(Source("p.exo", found.text.replace("part p;", "spec p;"))).diagnostics == ()
    assert all(f"{Path(each.place).name}: {each.text}" in found.text for each in found.remarks)
    assert all(each.place.startswith("a/") for each in found.remarks)


def test_a_file_of_no_package_is_told() -> None:
    found = imported(("Go.srv", "---\n"))
    assert "module ros {" in found.text and "request go();" in found.text
    assert [each.text for each in found.remarks] == ["the package is not known, and the module is called `ros`"]


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("NavigateToPose", "navigate_to_pose"),
        ("SetIMURate", "set_imu_rate"),
        ("Go2", "go2"),
        ("3D", "_3_d"),
        ("a-b", "a_b"),
    ],
)
def test_names(text: str, name: str) -> None:
    assert named(text) == name


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("x/srv/A.srv", "bool a\n", "x/srv/A.srv: it has 0 lines `---`, and .srv has 1"),
        ("x/srv/A.srv", "---\n---\n", "x/srv/A.srv: it has 2 lines `---`"),
        ("x/action/A.action", "---\n", "x/action/A.action: it has 1 line `---`, and .action has 2"),
        ("x/msg/A.msg", "bool a\nbool a\n", "x/msg/A.msg"),
        ("x/msg/A.msg", "bool 3x\n", "x/msg/A.msg:1: this is no definition of ROS"),
        (
            "x/srv/A.srv",
            "bool a\n---\n?\n",
            "x/srv/A.srv:3: this is no definition of ROS: `?` is no field and no constant",
        ),
        (
            "x/msg/A.msg",
            "bool a\n# x\n\nint8 b\nint8 c # d\n\nint8!\nint8 e",
            "x/msg/A.msg:7: this is no definition of ROS: `int8!` is",
        ),
        ("x/msg/A.msg", "bool x\na b c d\n", "x/msg/A.msg:2: this is no definition of ROS: `c d` is no value of `a`"),
        ("x/msg/A.msg", "int32 b c # d\n", "x/msg/A.msg:1: this is no definition of ROS"),
        ("x/msg/A.msg", "bool b 2\n", "x/msg/A.msg:1: this is no definition of ROS"),
        ("x/msg/A.msg", "float64 b 1 2\n", "x/msg/A.msg:1: this is no definition of ROS"),
        ("x/msg/A.idl", "", "x/msg/A.idl: it is no file of ROS"),
    ],
)
def test_what_is_no_definition_is_refused(name: str, text: str, said: str) -> None:
    with pytest.raises(UnreadableDescription) as raised:
        imported((name, text))
    assert str(raised.value).startswith(said)


def test_a_field_is_told_where_it_stands_and_not_where_a_comment_names_it() -> None:
    found = imported(
        ("x/msg/A.msg", '# mode is one of\nstring MODE="the mode "\nstring other "a mode"\n  string mode # mode\n')
    )
    assert [str(each) for each in found.remarks] == [
        "x/msg/A.msg:3: `a_other` is left out: a string",
        "x/msg/A.msg:4: `a_mode` is left out: a string",
    ]


def test_lines_may_end_as_on_windows() -> None:
    unix = imported(("p/action/A.action", ACTION))
    windows = imported(("p/action/A.action", ACTION.replace("\n", "\r\n")))
    assert windows == unix


def test_default_values_are_passed_over() -> None:
    text = """bool a True # yes
int8 b -0x10
uint8 c 3
float32 d -1.5e-3
float64 e 2
string f "x # y"
string g no quotes
string<=9 h 'x'
int32[] i [1, 2]
string[<=2] j ["a", "b"]
"""
    found = imported(("p/srv/A.srv", f"{text}---\n"))
    assert "request a(a: bool, b: int in -128 .. 127, c: int in 0 .. 255, d: real, e: real);" in found.text


def test_a_type_without_a_package_is_told_as_it_is_written() -> None:
    found = imported(("p/srv/A.srv", "wstring w\nPose pose\ng/Pose far\n---\n"))
    assert [each.text for each in found.remarks] == [
        "`w` is left out: a wstring",
        "`pose` is left out: a message `Pose`",
        "`far` is left out: a message `g/msg/Pose`",
    ]


def test_a_word_of_exo_may_go_in_and_come_out() -> None:
    found = imported(("p/srv/A.srv", "int8 with\n---\nint8 with\n"))
    assert "request a(with_: int in -128 .. 127);" in found.text
    assert [each.text for each in found.remarks] == [
        "`with` is a word of exo, and is called `with_`",
        "`with_` goes in and comes out: what comes out is left out",
    ]


def test_two_definitions_of_one_name_are_refused() -> None:
    with pytest.raises(UnreadableDescription, match="declared twice"):
        imported(("p/srv/A.srv", "---\n"), ("p/action/A.action", "---\n---\n"))


@pytest.mark.parametrize("seed", range(60))
def test_whatever_is_given_is_read_or_refused(seed: int) -> None:
    text = broken(ACTION + SERVICE.replace("---", "") + MESSAGE, seed)
    for name in ("p/action/A.action", "p/srv/A.srv", "p/msg/A.msg"):
        try:
            imported((name, text if name.endswith("action") else text.replace("---", "")))
        except UnreadableDescription as reason:
            assert str(reason).startswith(name)
