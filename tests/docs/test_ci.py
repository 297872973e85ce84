"""The commands of the page about gates, run as they stand; the pre-commit hook and the GitHub action."""

import json
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
from contextlib import chdir
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import patch

import pytest

from tests.cli.specs import DEAF, SPEC
from tests.docs.pages import ROOT, places, play
from tests.support.command import Run
from tests.support.compiled import keeping_compiler


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


def variables(specs: str, arguments: str = "") -> dict[str, str]:
    """Return what the action tells its script."""
    return {"SPECS": specs, "ARGUMENTS": arguments, "REPORTS": "out"}


def act(folder: Path, specs: str) -> "subprocess.CompletedProcess[str]":
    """Return what the only step of the action does that runs a script of ours."""
    (script,) = re.findall(r"run: (python .*action\.py.*)$", (ROOT / "action.yml").read_text(), re.MULTILINE)
    inputs = {**variables(specs), "GITHUB_ACTION_PATH": str(ROOT), "CC": str(keeping_compiler())}
    return run(["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", script], folder, **inputs)


def act_here(folder: Path, specs: str, arguments: str = "") -> int:
    """Return the status of that script, which runs in this process, as do the commands that it begins."""

    def begun(command: list[str], check: bool) -> "subprocess.CompletedProcess[str]":
        assert command[:4] == [sys.executable, "-P", "-m", "exover"] and not check
        return Run(folder)(*command[4:])

    main = runpy.run_path(str(ROOT / ".ci" / "action.py"))["main"]
    here = patch.dict(main.__globals__, subprocess=SimpleNamespace(run=begun))
    with chdir(folder), patch.dict(os.environ, variables(specs, arguments)), here:
        status: int = main()
    return status


@pytest.mark.parametrize(
    "specs", ["my specs/good.exo", "'my specs/good.exo'", "my specs/good.exo\n", "\n  my specs/good.exo\n"]
)
def test_the_action_takes_names_with_blanks(repository: Path, specs: str) -> None:
    assert act_here(repository, specs, "--timeout 100 --config 'exover.toml'") == 0
    assert sorted(path.name for path in (repository / "out").iterdir()) == [
        "my specs-good.exo.sarif",
        "my specs-good.exo.xml",
    ]


def test_the_action_keeps_the_first_status_that_is_not_0(repository: Path) -> None:
    (repository / "wrong.exo").write_text("spec wrong")
    assert act_here(repository, "'my specs/good.exo' 'my specs/false.exo' wrong.exo") == 1
    assert act_here(repository, "wrong.exo\nmy specs/false.exo") == 2
    assert act_here(repository, "my specs") == 1


def test_the_action_leaves_only_alerts(repository: Path) -> None:
    (repository / "deaf.exo").write_text(DEAF)
    assert act_here(repository, "deaf.exo") == 1
    (log,) = json.loads((repository / "out" / "deaf.exo.sarif").read_text())["runs"]
    assert {result["kind"] for result in log["results"]} == {"fail"}


def test_the_action_writes_reports_of_its_own_for_each_spec(repository: Path) -> None:
    for name, text in (("a/b-c.exo", DEAF), ("a-b/c.exo", SPEC), ("a-b-c.exo", SPEC)):
        (repository / name).parent.mkdir(exist_ok=True)
        (repository / name).write_text(text)
    assert act_here(repository, "a/b-c.exo a-b/c.exo a-b-c.exo") == 1
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
    assert act_here(repository, "'my specs/good.exo'") == 0
    assert other.read_text() == '{"runs": [{"results": [{}]}]}'
    assert act_here(repository, "wrong.exo") == 2


@pytest.mark.parametrize("name", ["exover/__init__.py", "exover.py", "queue.py", "argparse.py"])
def test_the_action_runs_no_module_of_the_repository(repository: Path, name: str) -> None:
    (repository / name).parent.mkdir(exist_ok=True)
    (repository / name).write_text("raise SystemExit(0)")
    assert act(repository, "'my specs/false.exo'").returncode == 1
    assert "python -m" not in (ROOT / "action.yml").read_text(), "pip would run them, too"


def test_what_the_action_cannot_read(repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for specs in ("", " \n", "'open"):
        assert act_here(repository, specs) == 2
        assert capsys.readouterr().out.count("::error title=exover::") == 1
