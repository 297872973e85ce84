"""The commands of the page about gates, run as they stand; the pre-commit hook and the GitHub action."""

import json
import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.cli.specs import DEAF, SPEC
from tests.docs.pages import ROOT, places, play


def test_the_page_about_gates_runs(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "specs", tmp_path / "specs")
    played = list(play(ROOT / "docs" / "ci.md", tmp_path))
    assert sum(block.language == "sh" for block in played) >= 5
    assert {path.suffix for path in (tmp_path / "reports").iterdir()} == {".sarif", ".xml", ".json"}


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """Two specs in a folder with a blank in its name, one with a false property; a configuration at the root."""
    folder = tmp_path / "my specs"
    (folder / "properties").mkdir(parents=True)
    (tmp_path / ".git").mkdir()
    (folder / "good.exo").write_text(SPEC.replace("spec demo", "spec good"))
    (folder / "false.exo").write_text(SPEC.replace("spec demo", "spec false_one"))
    (folder / "properties" / "false.prop").write_text("for false_one; property p: never active(nd.goto);\n")
    (tmp_path / "exover.toml").write_text("")
    return tmp_path


def run(command: list[str], folder: Path, **variables: str) -> "subprocess.CompletedProcess[str]":
    environment = {**os.environ, "PATH": places(), **variables}
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )


# ---- pre-commit ----


def hook(key: str) -> str:
    found = re.search(rf"^  {key}: (.*)$", (ROOT / ".pre-commit-hooks.yaml").read_text(), re.MULTILINE)
    assert found
    return found[1]


def commit(folder: Path, *changed: str) -> "subprocess.CompletedProcess[str]":
    """Return what the hook does with changed files, as pre-commit calls it."""
    seen = [name for name in changed if re.search(hook("files"), name)]
    assert seen, "the hook would not run"
    return run([*shlex.split(hook("entry")), *seen], folder)


@pytest.mark.parametrize(
    ("changed", "status", "checked"),
    [
        (("my specs/good.exo", "README.md"), 0, {"good"}),
        (("my specs/false.exo",), 1, {"false_one"}),
        (("my specs/properties/false.prop",), 1, {"false_one"}),
        (("exover.toml",), 1, {"good", "false_one"}),
        (("my specs/good.exo", "my specs/properties/false.prop", "exover.toml"), 1, {"good", "false_one"}),
    ],
)
def test_the_hook_checks_what_a_changed_file_belongs_to(
    repository: Path, changed: tuple[str, ...], status: int, checked: set[str]
) -> None:
    done = commit(repository, *changed)
    assert done.returncode == status, done
    assert set(re.findall(r"^(\w+): (?:holds|violated)", done.stdout, re.MULTILINE)) == checked


# ---- the GitHub action ----


def act(folder: Path, specs: str, arguments: str = "") -> "subprocess.CompletedProcess[str]":
    """Return what the only step of the action does that runs a script of ours."""
    (script,) = re.findall(r"run: (python .*action\.py.*)$", (ROOT / "action.yml").read_text(), re.MULTILINE)
    inputs = {"SPECS": specs, "ARGUMENTS": arguments, "REPORTS": "out", "GITHUB_ACTION_PATH": str(ROOT)}
    return run(["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", script], folder, **inputs)


@pytest.mark.parametrize(
    "specs", ["my specs/good.exo", "'my specs/good.exo'", "my specs/good.exo\n", "\n  my specs/good.exo\n"]
)
def test_the_action_takes_names_with_blanks(repository: Path, specs: str) -> None:
    done = act(repository, specs, "--timeout 100 --config 'exover.toml'")
    assert done.returncode == 0, done
    assert sorted(path.name for path in (repository / "out").iterdir()) == [
        "my specs-good.exo.sarif",
        "my specs-good.exo.xml",
    ]


def test_the_action_keeps_the_first_status_that_is_not_0(repository: Path) -> None:
    (repository / "wrong.exo").write_text("spec wrong")
    assert act(repository, "'my specs/good.exo' 'my specs/false.exo' wrong.exo").returncode == 1
    assert act(repository, "wrong.exo\nmy specs/false.exo").returncode == 2
    assert act(repository, "my specs").returncode == 1


def test_the_action_leaves_only_alerts(repository: Path) -> None:
    (repository / "deaf.exo").write_text(DEAF)
    assert act(repository, "deaf.exo").returncode == 1
    (log,) = json.loads((repository / "out" / "deaf.exo.sarif").read_text())["runs"]
    assert {result["kind"] for result in log["results"]} == {"fail"}


def test_the_action_writes_reports_of_its_own_for_each_spec(repository: Path) -> None:
    for name, text in (("a/b-c.exo", DEAF), ("a-b/c.exo", SPEC), ("a-b-c.exo", SPEC)):
        (repository / name).parent.mkdir(exist_ok=True)
        (repository / name).write_text(text)
    assert act(repository, "a/b-c.exo a-b/c.exo a-b-c.exo").returncode == 1
    logs = {path.name: json.loads(path.read_text()) for path in (repository / "out").glob("*.sarif")}
    alerts = {name: len(log["runs"][0]["results"]) for name, log in logs.items()}
    assert {name: found > 0 for name, found in alerts.items()} == {
        "a-b-c.exo.sarif": True,
        "a-b-c.exo-2.sarif": False,
        "a-b-c.exo-3.sarif": False,
    }


def test_the_action_leaves_logs_of_other_tools_as_they_are(repository: Path) -> None:
    (repository / "out").mkdir()
    other = repository / "out" / "other.sarif"
    other.write_text('{"runs": [{"results": [{}]}]}')
    (repository / "out" / "wrong.exo.sarif").write_text("{}")
    (repository / "wrong.exo").write_text("spec wrong")
    assert act(repository, "'my specs/good.exo'").returncode == 0
    assert other.read_text() == '{"runs": [{"results": [{}]}]}'
    assert act(repository, "wrong.exo").returncode == 2


@pytest.mark.parametrize("name", ["exover/__init__.py", "exover.py", "queue.py", "argparse.py"])
def test_the_action_runs_no_module_of_the_repository(repository: Path, name: str) -> None:
    (repository / name).parent.mkdir(exist_ok=True)
    (repository / name).write_text("raise SystemExit(0)")
    assert act(repository, "'my specs/false.exo'").returncode == 1
    assert "python -m" not in (ROOT / "action.yml").read_text(), "pip would run them, too"


def test_what_the_action_cannot_read(repository: Path) -> None:
    for specs in ("", " \n", "'open"):
        done = act(repository, specs)
        assert (done.returncode, done.stdout.count("::error title=exover::")) == (2, 1)
