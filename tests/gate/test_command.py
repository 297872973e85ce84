"""`exover gate` as a command: its statuses, and what it says."""

import sys
from pathlib import Path

import pytest

from tests.gate import yard
from tests.gate.carts import BIND, SPEC
from tests.gate.yard import INTERFACES
from tests.support.command import Ended, Run

UNSAFE = """spec s;
module m { request a(); request b(); }
poster p: bool = false;
forbid both: p and active(m.a) because "not while p";
"""
UNSAFE_BIND = """[gate]
spec = "s"
start = "idle"
[request."m.a"]
tool = "a"
"""


def files(folder: Path, spec: str = SPEC, bind: str = BIND) -> tuple[str, ...]:
    (folder / "s.exo").write_text(spec)
    (folder / "s.bind.toml").write_text(bind)
    return str(folder / "s.exo"), "--bind", str(folder / "s.bind.toml")


def run(*words: str) -> Ended:
    """Run a command that ends before a gate does anything."""
    return Run(Path.cwd())(*words)


def test_a_binding_is_checked(tmp_path: Path) -> None:
    done = run("gate", "check", *files(tmp_path))
    assert done.returncode == 0 and done.stdout.endswith("4 of 4 requests, 2 of 2 posters, 1 watch\n")


def test_a_mistake_ends_with_status_2(tmp_path: Path) -> None:
    done = run("gate", "check", *files(tmp_path, bind=BIND.replace("base.stop", "base.stpo")))
    assert done.returncode == 2 and "did you mean `base.stop`?" in done.stderr and not done.stdout
    assert "has a mistake" in done.stderr


def test_a_binding_that_is_not_there(tmp_path: Path) -> None:
    spec = files(tmp_path)[0]
    done = run("gate", "check", spec, "--bind", str(tmp_path / "none.toml"))
    assert done.returncode == 2 and "cannot read" in done.stderr


def test_what_is_not_safe_is_not_run(tmp_path: Path) -> None:
    words = ("gate", "mcp", *files(tmp_path, UNSAFE, UNSAFE_BIND), "--", sys.executable, "-c", "")
    done = Run(Path.cwd()).apart(*words)
    assert done.returncode == 1 and "completeness both: violated" in done.stderr and "--unchecked" in done.stderr


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            'tool = "brake"\ncancel = { tool = "release", ends = true }',
            'action = "/brake"\ntype = "a_msgs/action/Brake"',
            "base.stop is bound to a ROS 2 action",
        )
    ],
)
def test_what_another_protocol_has_is_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    done = run("gate", "mcp", *files(tmp_path, bind=BIND.replace(old, new)), "--", "true")
    assert done.returncode == 2 and said in done.stderr


@pytest.mark.parametrize(
    ("old", "new", "options", "said"),
    [
        ("", "", (), "base.drive: the type yard_msgs/action/Drive is found nowhere"),
        ('inner = "/gated/drive"', "", ("--interfaces", str(INTERFACES)), "`/drive` is the outer name as well"),
        ("", "", ("--interfaces", str(INTERFACES), "--interfaces", "nosuch"), "--interfaces: nosuch is no folder"),
        ("", "", ("--interfaces", str(INTERFACES), "--decisions", "a b"), "--decisions: `a b` is no name of ROS 2"),
        ("", "", ("--domain", "233"), "'233' is no DDS domain"),
    ],
)
def test_what_ros2_cannot_serve_ends_with_status_2(
    tmp_path: Path, old: str, new: str, options: tuple[str, ...], said: str
) -> None:
    pytest.importorskip("cyclonedds", reason="the extra exover[ros2] is not installed")
    pytest.importorskip("rosbags", reason="the extra exover[ros2] is not installed")
    spec, *bind = files(tmp_path, yard.SPEC, yard.BIND.replace(old, new, 1))
    ended = run("gate", "ros2", spec, *bind, *options)
    assert ended.returncode == 2 and said in ended.stderr and "Traceback" not in ended.stderr


def test_without_the_extra_it_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("exover.cli.gate.find_spec", lambda name: None)
    spec, *bind = files(tmp_path, yard.SPEC, yard.BIND)
    ended = Run(Path.cwd())("gate", "ros2", spec, *bind)
    assert ended.returncode == 2 and "pip install 'exover[ros2]'" in ended.stderr


def test_a_log_that_cannot_be_written_is_refused_before_anything_starts(tmp_path: Path) -> None:
    done = run("gate", "mcp", *files(tmp_path), "--unchecked", "--log", str(tmp_path / "no" / "log"), "--", "true")
    assert done.returncode == 2 and "cannot write" in done.stderr
