"""The examples do what their pages say."""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from exover.gate.reading import read_binding
from exover.model.semantics import Reference
from exover.model.wire import action_json
from exover.model.wire_reading import read_entries
from exover.pipeline import load
from exover.source import Source

ROOT = Path(__file__).resolve().parents[2]
ASSISTANT = ROOT / "examples" / "walking_assistant"
DOCKING = ROOT / "examples" / "nav2_docking"


def test_the_walking_assistant_is_bound_without_a_word() -> None:
    model = load(Source("assistant.exo", (ROOT / "specs" / "assistant.exo").read_text("utf-8"))).model
    assert model is not None
    binding, told = read_binding(Source("b", (ASSISTANT / "assistant.bind.toml").read_text("utf-8")), model)
    assert binding is not None and not told and len(binding.requests) == len(model.requests)


def test_an_agent_drives_the_walking_assistant(tmp_path: Path) -> None:
    pytest.importorskip("mcp")
    log = tmp_path / "log.jsonl"
    command = [sys.executable, str(ASSISTANT / "agent.py"), str(log)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    due = re.search(r"```text\n(.*?)```", (ASSISTANT / "README.md").read_text("utf-8"), re.DOTALL)
    printed = [line for line in done.stdout.splitlines() if "refused by starting" not in line]
    assert due and printed == due[1].splitlines(), done.stderr
    entries = [json.loads(line) for line in log.read_text("utf-8").splitlines()]
    actions = [action for entry in entries for action in entry.get("actions", ())]
    assert {"launch": "base.stop", "instance": 0, "args": {}, "launch_rule": "catch"} in actions
    assert {entry["alarm"] for entry in entries if "alarm" in entry} <= {"blind"}  # where the machine is busy


def test_nav2_docks_and_drives_one_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("cyclonedds", reason="the extra exover[ros2] is not installed")
    from tests.gate.ros_peers import LOOPBACK

    monkeypatch.setenv("CYCLONEDDS_URI", LOOPBACK)
    log = tmp_path / "log.jsonl"
    command = [sys.executable, str(DOCKING / "mission.py"), str(log)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    due = re.search(r"```text\n(.*?)```", (DOCKING / "README.md").read_text("utf-8"), re.DOTALL)
    assert due and done.stdout == due[1], done.stderr
    assert mission(log) == mission(DOCKING / "decisions.jsonl")


def mission(log: Path) -> list[dict[str, Any]]:
    """Return the decisions of a mission, without their times; what came before is how long the gate needed to start."""
    entries = [json.loads(line) for line in log.read_text("utf-8").splitlines()]
    first = next(at for at, each in enumerate(entries) if each.get("event", {}).get("args", {}).get("x") == 3)
    return [{key: value for key, value in each.items() if key != "time"} for each in entries[first:]]


def test_the_recorded_mission_is_what_the_rules_say() -> None:
    model = load(Source("nav2_docking.exo", (DOCKING / "nav2_docking.exo").read_text("utf-8"))).model
    assert model is not None
    state = Reference(model)
    now = state.start()
    for entry in map(json.loads, (DOCKING / "decisions.jsonl").read_text("utf-8").splitlines()):
        if "event" in entry:
            now, actions = state.step(now, read_entries(model, entry["event"]))  # type: ignore[arg-type]
            assert [action_json(model, each) for each in actions] == entry["actions"]
