"""`exover init`: what it writes checks without a finding, and it writes over nothing."""

import json
import re
import shlex
from pathlib import Path

import pytest

from exover.cli.init import spec_name
from tests.support.command import Run

WRITTEN = {"cart.exo", "cart.prop", "cart.events.jsonl", "exover.toml", ".github/workflows/exover.yml"}


def content(folder: Path) -> dict[str, str]:
    return {path.relative_to(folder).as_posix(): path.read_text() for path in folder.rglob("*") if path.is_file()}


def test_what_it_writes_holds_and_nothing_is_odd(run: Run, tmp_path: Path) -> None:
    ended = run("init", "cart")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert set(content(tmp_path / "cart")) == WRITTEN
    assert ended.stdout.split("\n\n")[0].splitlines() == [f"cart/{name}" for name in sorted(WRITTEN, key=order)]
    (command,) = re.findall(r"^next: (exover .*)$", ended.stdout, re.MULTILINE)
    checked = run(*shlex.split(command)[1:], "--format", "json")
    assert (checked.returncode, checked.stderr) == (0, "")
    findings = json.loads(checked.stdout)["findings"]
    assert [finding for finding in findings if finding["verdict"] != "holds"] == []
    assert len([finding for finding in findings if finding["check"] == "property"]) == 4
    assert run("fmt", "--check").returncode == 0


@pytest.mark.parametrize("folder", ["-dash", "a b é", "it's"])
def test_what_to_do_next_can_be_done(folder: str, run: Run) -> None:
    ended = run("init", "--", folder)
    (command,) = re.findall(r"^next: (exover .*)$", ended.stdout, re.MULTILINE)
    checked = run(*shlex.split(command)[1:])
    assert (checked.returncode, checked.stderr) == (0, "")


def order(name: str) -> int:
    return [".exo", ".prop", ".jsonl", ".toml", ".yml"].index(Path(name).suffix)


def test_every_command_of_the_ci_file_passes(run: Run, tmp_path: Path) -> None:
    run("init", "cart")
    text = (tmp_path / "cart" / ".github" / "workflows" / "exover.yml").read_text()
    commands = re.findall(r"- run: exover (.*)$", text, re.MULTILINE)
    assert len(commands) == 2
    for command in commands:
        ended = run(*shlex.split(command), cwd=tmp_path / "cart")
        assert (ended.returncode, ended.stderr) == (0, ""), command


def test_the_events_show_every_kind_of_answer(run: Run, tmp_path: Path) -> None:
    run("init", "cart")
    ended = run("simulate", "cart/cart.exo", "--events", "cart/cart.events.jsonl")
    said = {kind for line in ended.stdout.splitlines() for action in json.loads(line)["actions"] for kind in action}
    assert {"launch", "wait", "reject", "kill"} <= said and "invalid" not in said


def test_the_waiver_that_is_commented_out_is_one(run: Run, tmp_path: Path) -> None:
    run("init", "cart")
    path = tmp_path / "cart" / "exover.toml"
    path.write_text(path.read_text().partition("#\n# [[waiver]]")[0] + uncommented(path.read_text()))
    ended = run("check", "cart/cart.exo")
    assert ended.returncode == 0 and "no such finding of cart is open" in ended.stderr


def uncommented(text: str) -> str:
    return "".join(line.removeprefix("# ") for line in text[text.index("# [[waiver]]") :].splitlines(keepends=True))


def test_a_link_that_leads_to_itself_is_refused(run: Run, tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to("loop")
    ended = run("init", "loop", cwd=tmp_path)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert "exover: error: cannot write loop" in ended.stderr


def test_it_takes_the_folder_it_is_in(run: Run, tmp_path: Path) -> None:
    (tmp_path / "cart").mkdir()
    ended = run("init", cwd=tmp_path / "cart")
    assert ended.returncode == 0 and set(content(tmp_path / "cart")) == WRITTEN


@pytest.mark.parametrize("name", sorted(WRITTEN))
def test_it_writes_over_nothing(name: str, run: Run, tmp_path: Path) -> None:
    path = tmp_path / "cart" / name
    path.parent.mkdir(parents=True)
    path.write_text("mine")
    ended = run("init", "cart")
    assert ended.returncode == 2 and f"there is already cart/{name}" in ended.stderr
    assert content(tmp_path / "cart") == {name: "mine"}


@pytest.mark.parametrize(
    ("folder", "name"),
    [
        ("cart", "cart"),
        ("my-robot 2", "my_robot_2"),
        ("2wheels", "robot"),
        ("true", "robot"),
        ("Kühlgerät", "Kuhlgerat"),
        ("-", "robot"),
    ],
)
def test_a_spec_is_called_as_its_folder(folder: str, name: str, run: Run, tmp_path: Path) -> None:
    assert spec_name(tmp_path / folder) == name
    assert run("init", f"./{folder}").returncode == 0
    events = f"./{folder}/{name}.events.jsonl"
    assert run("simulate", f"./{folder}/{name}.exo", "--events", events).returncode == 0
