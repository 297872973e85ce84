"""The cache of `exover check`, and `--watch`: what is printed again, what is asked anew, and what comes of damage."""

import json
import os
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from time import monotonic, sleep

import pytest

from exover.cli import check
from exover.cli.report_cache import PROGRAMS
from exover.engines.aig.abc import prover
from exover.engines.compiler import COMPILERS
from exover.engines.smv import program as nusmv
from tests.cli.specs import written
from tests.support.command import COMMAND, environment

SPEC = "spec s;\nmodule m { request a(); request b(); }\nmutex ab: m.a, m.b;\n"
PROPERTIES = "for s;\nproperty apart: never (active(m.a) and active(m.b));\n"


pytestmark = pytest.mark.usefixtures("cached")


@pytest.fixture
def decided(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """By command whose report was not printed before a line."""
    found: list[str] = []
    decide = check.decide
    monkeypatch.setattr(
        check, "decide", lambda model, *rest, **asked: found.append(model.name) or decide(model, *rest, **asked)
    )
    return found


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    return written(tmp_path, SPEC, PROPERTIES)


def kept(spec: Path) -> list[Path]:
    """Return the files of whole reports."""
    files = (spec.parent / ".exover_cache").glob("*.json")
    return sorted(file for file in files if not file.name.startswith("answers-"))


@pytest.mark.parametrize("form", ["text", "json", "sarif", "junit", "github"])
def test_an_unchanged_spec_is_reported_in_the_same_bytes(form: str, run, spec: Path, decided: list[str]) -> None:
    first = run("check", spec, "--format", form)
    again = run("check", spec, "--format", form, "--jobs", "1")
    fresh = run("check", spec, "--format", form, "--no-cache")
    assert decided == ["s", "s"]
    assert first.stdout
    assert (first.stdout, first.returncode) == (again.stdout, again.returncode) == (fresh.stdout, fresh.returncode)


def test_a_report_calls_the_spec_as_the_command_does(run, spec: Path, decided: list[str]) -> None:
    for name in ("s.exo", "./s.exo", f"..//{spec.parent.name}/./s.exo"):
        assert run("check", name, cwd=spec.parent).stdout.startswith(f"{name}: spec s, ")
    assert len(decided) == 3


def test_all_programs_that_are_looked_for_are_among_those_that_a_report_depends_on() -> None:
    assert set(PROGRAMS) == {*prover.NAMES, *nusmv.NAMES, *COMPILERS}


def test_another_compiler_is_asked_anew(run, spec: Path, decided: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    compiler = spec.parent / "cc"
    for text in ("exec cc", "exec cc ", "exec cc "):
        compiler.write_text(f'#!/bin/sh\n{text} "$@"\n')
        compiler.chmod(0o755)
        os.utime(compiler, ns=(len(text), len(text)))
        monkeypatch.setenv("CC", str(compiler))
        assert run("check", spec).returncode == 0
    assert decided == ["s", "s"]
    monkeypatch.setenv("CC", f"{compiler} -O1")
    assert run("check", spec).returncode == 0 and len(decided) == 3


def test_what_is_violated_keeps_its_status(run, spec: Path, decided: list[str]) -> None:
    spec.write_text(SPEC.replace("mutex ab: m.a, m.b;", ""))
    first, again = run("check", spec), run("check", spec)
    assert decided == ["s"]
    assert first.returncode == again.returncode == 1
    assert first.stdout == again.stdout


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("s.exo", SPEC.replace("m.b;", "m.b by wait;")),
        ("s.exo", f"\n{SPEC}"),
        ("s.prop", PROPERTIES.replace("never (active(m.a)", "never (waiting(m.a)")),
        ("s.prop", None),
        ("exover.toml", '[check]\nskip = ["note"]\n'),
        ("properties/t.prop", "for t; property p: possible (active(m.a));"),
    ],
)
def test_a_change_is_asked_anew(name: str, text: str | None, run, spec: Path, decided: list[str]) -> None:
    run("check", spec)
    file = spec.parent / name
    file.parent.mkdir(exist_ok=True)
    file.unlink() if text is None else file.write_text(text)
    assert run("check", spec).stdout == run("check", spec, "--no-cache").stdout
    assert len(decided) == 3


def test_a_change_of_what_is_included_is_asked_anew(run, spec: Path, decided: list[str]) -> None:
    spec.write_text('spec s;\ninclude "parts/m.exo";\n')
    part = spec.parent / "parts" / "m.exo"
    part.parent.mkdir()
    for text in (SPEC, SPEC.replace("mutex ab: m.a, m.b;", "")):
        part.write_text(text.replace("spec s", "part m"))
        assert run("check", spec).stdout == run("check", spec).stdout
    assert decided == ["s", "s"]


@pytest.fixture
def linked(tmp_path: Path) -> Path:
    """A spec that is named by a link from another folder of its repository."""
    for folder in (".git", "a", "b"):
        (tmp_path / folder).mkdir()
    (tmp_path / "b" / "s.exo").write_text('spec s;\ninclude "m.exo";\n')
    (tmp_path / "a" / "s.exo").symlink_to("../b/s.exo")
    (tmp_path / "a" / "m.exo").write_text(SPEC.replace("spec s", "part m"))
    return tmp_path / "a" / "s.exo"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_that_is_included_is_not_waited_for(run, spec: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def read(file: Path) -> bytes:
        assert file.is_file()
        return reads(file)

    reads = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", read)
    os.mkfifo(spec.parent / "part.exo")
    spec.write_text(SPEC.replace("module", 'include "part.exo"; module'))
    done = run("check", spec)
    assert done.returncode == 2 and "error[E005]" in done.stderr and "it is no regular file" in done.stderr


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("exover.toml", '[check]\nonly = ["safety"]\n'),
        ("s.prop", PROPERTIES),
        ("m.exo", SPEC.replace("spec s", "part m").replace("mutex ab: m.a, m.b;", "")),
    ],
)
def test_what_belongs_to_a_linked_spec_is_beside_the_link(
    name: str, text: str, run, linked: Path, decided: list[str]
) -> None:
    first = run("check", linked)
    (linked.parent / name).write_text(text)
    assert first.stdout != run("check", linked).stdout == run("check", linked, "--no-cache").stdout
    assert len(decided) == 3


def test_a_part_with_two_names_is_asked_anew_by_what_it_includes_under_the_first(
    run, linked: Path, decided: list[str]
) -> None:
    root = linked.parents[1]
    linked.unlink()
    linked.write_text('spec s;\ninclude "l.exo";\ninclude "../b/p.exo";\n')
    (root / "a" / "l.exo").write_text('part l;\ninclude "p.exo";\n')
    (root / "b" / "p.exo").write_text('part p;\ninclude "m.exo";\n')
    (root / "b" / "m.exo").write_text("part m;\n")
    (root / "a" / "p.exo").symlink_to("../b/p.exo")
    first = run("check", linked)
    (root / "a" / "m.exo").write_text(SPEC.replace("spec s", "part m").replace("mutex ab: m.a, m.b;", ""))
    assert first.stdout != run("check", linked).stdout == run("check", linked, "--no-cache").stdout


@pytest.mark.parametrize(
    "options",
    [["--only", "safety"], ["--deny", "warnings"], ["--engine", "bdd"], ["--format", "json"], ["--abc", "none"]],
)
def test_other_options_are_other_reports(options: list[str], run, spec: Path, decided: list[str]) -> None:
    run("check", spec)
    run("check", spec, *options)
    assert len(decided) == len(kept(spec)) == 2


@pytest.mark.parametrize("options", [["--timings"], ["--timeout", "60"], ["--count"], ["--output", "json=out.json"]])
def test_what_measures_limits_or_writes_is_never_from_the_cache(options, run, spec: Path, decided: list[str]) -> None:
    run("check", spec, *options)
    run("check", spec, *options)
    assert len(decided) == 2
    assert not kept(spec)


def test_another_version_asks_anew(run, spec: Path, decided: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    run("check", spec)
    monkeypatch.setattr("exover.__version__", "0.0.1")
    run("check", spec)
    assert len(decided) == 2


@pytest.mark.parametrize("damage", ["", "{}", "[]", "null", "half", "forged"])
def test_a_damaged_entry_is_none(damage: str, run, spec: Path, decided: list[str]) -> None:
    first = run("check", spec)
    (file,) = kept(spec)
    whole = file.read_text()
    forged = json.dumps({**json.loads(whole), "text": "s: holds\n"})
    file.write_text({"half": whole[: len(whole) // 2], "forged": forged}.get(damage, damage))
    assert run("check", spec).stdout == first.stdout
    assert len(decided) == 2
    assert file.read_text() == whole


def test_what_is_unknown_is_not_kept(run, spec: Path, decided: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "exover.checks.schedule.tasks.TaskRunner.task", lambda *parts: (_ for _ in ()).throw(MemoryError)
    )
    run("check", spec, "--jobs", "2")
    assert not kept(spec)


def test_a_folder_that_cannot_be_written_does_not_matter(run, spec: Path, decided: list[str]) -> None:
    (spec.parent / ".exover_cache").write_text("in the way")
    assert run("check", spec).returncode == run("check", spec).returncode == 0
    assert len(decided) == 2


def test_the_folder_stands_at_the_root_of_the_repository_and_ignores_itself(run, tmp_path: Path) -> None:
    (tmp_path / ".git").mkdir()
    (tmp_path / "specs").mkdir()
    (tmp_path / "specs" / "s.exo").write_text(SPEC)
    run("check", tmp_path / "specs" / "s.exo")
    assert (tmp_path / ".exover_cache" / ".gitignore").read_text() == "*\n"
    assert not (tmp_path / "specs" / ".exover_cache").exists()


@pytest.fixture
def watching(spec: Path) -> Iterator[subprocess.Popen[str]]:
    with open(spec.parent / "out", "w") as out, open(spec.parent / "err", "w") as err:
        words = [*COMMAND, "check", "--watch", str(spec), "--only", "safety"]
        process = subprocess.Popen(words, stdout=out, stderr=err, env=environment(), cwd=spec.parent, text=True)
        yield process
        process.kill()
        process.wait()


def told(file: Path, text: str, times: int = 1) -> None:
    """Wait until a file says something so many times."""
    end = monotonic() + 60
    while file.read_text().count(text) < times:
        assert monotonic() < end, file.read_text()
        sleep(0.05)


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is no signal there")
def test_a_change_is_checked_while_watched(watching: subprocess.Popen[str], spec: Path) -> None:
    out, err = spec.parent / "out", spec.parent / "err"
    told(err, "waiting for changes")
    told(out, "s: holds")
    spec.write_text(SPEC.replace("mutex", "mutx"))
    told(err, "waiting for changes", 2)
    assert "error" in err.read_text()
    spec.write_text(SPEC.replace("mutex ab", "mutex apart"))
    told(err, "waiting for changes", 3)
    told(out, "s: holds", 2)
    spec.write_text("// moved\n" + SPEC.replace("mutex ab", "mutex apart"))
    told(err, "waiting for changes", 4)
    told(err, "note: 1 of 1 answers come from the cache")
    watching.send_signal(signal.SIGINT)
    assert watching.wait(30) == 130
