"""Answers to single questions in the cache: what is asked after an edit, and what comes of damage on disk."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import exover
from exover.checks.schedule.tasks import TaskRunner
from exover.cli import answer_cache, report_cache
from exover.cli.answer_cache import AnswerFiles
from tests.cli.specs import written

SPEC = """spec s;
module m { request a(); request b(); request c(); }
mutex ab: m.a, m.b by wait;
"""
PROPERTIES = "for s;\nproperty apart: never (active(m.a) and active(m.b));\nproperty free: never active(m.c);\n"
MORE = "property more: possible (active(m.a));\n"
ALONE = ("--abc", "none")
"""Without a program that may be found or not."""
Asked = list[tuple[str, str]]


@pytest.fixture(autouse=True)
def _one_program(cached: None, monkeypatch: pytest.MonkeyPatch) -> None:
    _, *rest = report_cache.program()  # which others may change meanwhile: packages that are installed, a page
    for module in (answer_cache, report_cache):
        monkeypatch.setattr(module, "program", lambda: [exover.__version__, *rest])


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Asked:
    """The questions that are put to engines."""
    found: Asked = []
    agenda = TaskRunner.agenda

    def noted(runner: TaskRunner, seconds: float | None) -> Any:
        found.extend((question.check, question.subject) for _, question in runner.questions)
        return agenda(runner, seconds)

    monkeypatch.setattr(TaskRunner, "agenda", noted)
    return found


@pytest.fixture
def check(run: Any, spec: Path, asked: Asked) -> Callable[..., Any]:
    """Return what checks a spec that has been checked before."""
    run("check", spec, *ALONE)
    assert len(asked) > 20
    asked.clear()
    return lambda *options: run("check", spec, *ALONE, *options)


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    return written(tmp_path, SPEC, PROPERTIES)


def answers(folder: Path) -> Path:
    found = sorted((folder / ".exover_cache").glob("answers-*.json"))
    assert len(found) == 1, sorted(folder.rglob("*"))
    return found[0]


@pytest.mark.parametrize("form", ["text", "json", "sarif", "junit", "github"])
def test_a_comment_moves_what_is_told_and_asks_nothing(form: str, check: Any, spec: Path, asked: Asked) -> None:
    spec.write_text(f"// what for\n\n{SPEC}")
    warm = check("--format", form)
    assert asked == []
    fresh = check("--format", form, "--no-cache")
    assert (warm.stdout, warm.stderr, warm.returncode) == (fresh.stdout, fresh.stderr, fresh.returncode)
    assert warm.returncode == 1
    assert asked


def test_a_reason_is_told_as_it_is_now(check: Any, spec: Path, asked: Asked) -> None:
    spec.write_text(SPEC.replace("by wait", 'by wait because "one arm"'))
    assert "one arm" in check("--format", "json").stdout
    assert asked == []


def test_one_more_property_is_asked_alone(check: Any, spec: Path, asked: Asked) -> None:
    (spec.parent / "s.prop").write_text(PROPERTIES + MORE)
    warm = check("--format", "json")
    assert asked == [("property", "more")]
    assert warm.stdout == check("--format", "json", "--no-cache").stdout


@pytest.mark.parametrize("option", [["--timeout", "60"], ["--timings"], ["--memory", "4000"], ["--certificate", "c"]])
def test_what_measures_or_is_evidence_asks_everything(option: list[str], run: Any, spec: Path) -> None:
    run("check", spec)
    before = answers(spec.parent).read_bytes()
    answers(spec.parent).write_text("damaged")
    run("check", spec, *option)
    assert answers(spec.parent).read_text() == "damaged" != before


@pytest.mark.parametrize("option", [["--output", "json=o.json"], ["--bounds"], ["--count"], ["--deny", "warnings"]])
def test_other_options_use_answers(option: list[str], check: Any, asked: Asked) -> None:
    check(*option)
    assert asked == []


def test_several_specs_use_answers(run: Any, spec: Path, asked: Asked) -> None:
    (spec.parent / "t.exo").write_text(SPEC.replace("spec s", "spec t"))
    first = run("check", spec.parent, *ALONE)
    asked.clear()
    assert run("check", spec.parent, *ALONE).stdout == first.stdout
    assert asked == []


@pytest.mark.parametrize("damage", ["", "{}", "[]", "null", "half", "forged", "answers"])
def test_a_damaged_file_is_none(damage: str, check: Any, spec: Path, asked: Asked) -> None:
    file = answers(spec.parent)
    whole = file.read_text()
    forged = whole.replace('"violated"', '"holds"')
    shape = json.dumps({**json.loads(whole), "answers": []})
    file.write_text({"half": whole[: len(whole) // 2], "forged": forged, "answers": shape}.get(damage, damage))
    spec.write_text(f"// moved\n{SPEC}")
    assert check().stdout == check("--no-cache").stdout
    assert len(asked) > 40
    assert json.loads(answers(spec.parent).read_text())["answers"].keys() == json.loads(whole)["answers"].keys()


def test_another_program_asks_anew(check: Any, spec: Path, asked: Asked, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("exover.__version__", "0.0.1")
    check()
    assert len(asked) > 20


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="whoever may write everywhere is not kept from it")
def test_a_folder_that_cannot_be_written_is_read(check: Any, spec: Path, asked: Asked) -> None:
    (spec.parent / "s.prop").write_text(PROPERTIES + MORE)
    (spec.parent / ".exover_cache").chmod(0o500)
    assert check().returncode == check().returncode == 1
    assert asked == [("property", "more")] * 2


def test_what_others_keep_meanwhile_stays(tmp_path: Path) -> None:
    mine, other = AnswerFiles(tmp_path / "c", "who"), AnswerFiles(tmp_path / "c", "who")
    assert mine.find("loop") == other.find("loop") == {}
    mine.keep("loop", {"a": {"verdict": "holds"}})
    other.keep("loop", {"b": {"verdict": "holds"}})
    assert AnswerFiles(tmp_path / "c", "who").find("loop").keys() == {"a", "b"}
    assert AnswerFiles(tmp_path / "c", "another").find("loop") == {}


def test_answers_that_were_not_used_last_are_dropped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(answer_cache, "MOST", 3)
    files = AnswerFiles(tmp_path / "c", "who")
    for names in ("ab", "cd", "ae"):
        files.keep("loop", {name: {} for name in names})
    assert list(AnswerFiles(tmp_path / "c", "who").find("loop")) == ["d", "a", "e"]


@pytest.mark.parametrize("limit", [("MOST_FILES", 3), ("MOST_BYTES", 35)])
def test_the_oldest_files_are_dropped(limit: tuple[str, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_cache, *limit)
    folder = tmp_path / "c"
    folder.mkdir()
    for number in range(5):
        (folder / f"{number}.json").write_text("x" * 10)
        os.utime(folder / f"{number}.json", (number, number))
    (folder / "old.tmp").touch()
    os.utime(folder / "old.tmp", (0, 0))
    (folder / "new.tmp").touch()
    report_cache.write(folder / "5.json", "x" * 10)
    assert sorted(file.name for file in folder.iterdir()) == ["3.json", "4.json", "5.json", "new.tmp"]
