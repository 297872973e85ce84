"""Findings on a terminal as they fall, Ctrl-C, and the memory that processes may take."""

import io
import json
import os
import pty
import re
import signal
import subprocess
import sys
from collections import Counter
from itertools import count
from pathlib import Path

import pytest

from exover.checks.finding import Finding
from exover.cli import check as check_module
from exover.cli.arguments import parser
from exover.cli.live import Live
from exover.cli.main import main
from exover.diagnostics import Severity
from exover.loop.claim import Verdict
from exover.model.model import Location
from tests.cli.processes import ENDLESS, await_begun, gone
from tests.cli.specs import DEAF
from tests.support.command import COMMAND, environment
from tests.support.compiled import keeping_compiler
from tests.support.memory import more_than_now

needs_linux = pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up in /proc")


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def finding(severity: Severity, subject: str, verdict: Verdict) -> Finding:
    return Finding("check", subject, severity, verdict, "bdd", "", "", Location("demo.exo", 1, 1))


# ---- on a terminal ----


def test_what_is_written_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    terminal, spec = Terminal(), tmp_path / "s.exo"
    spec.write_text("spec s; module m { request a(); }")
    monkeypatch.setattr("sys.stderr", terminal)
    assert main(["emit", str(spec), "--unchecked", "--target", "smt2,dot", "--out", str(tmp_path)]) == 0
    shown = terminal.getvalue()
    assert shown.index("writing smt2") < shown.index("writing dot")
    assert shown.endswith("\x1b[K")


def lines(terminal: Terminal) -> list[str]:
    """Return what is to be seen on the terminal."""
    shown = (line.rpartition("\x1b[K")[2] for line in terminal.getvalue().split("\n"))
    return [line for line in shown if line]


def test_errors_come_first_and_what_holds_is_only_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    with Live() as live:
        live("tables")
        live.asks(Counter(error=2, warning=1, note=1))
        live.finds(finding("warning", "w", "violated"))
        assert lines(terminal) == ["1 of 4 answered, 0 s"]
        live.finds(finding("error", "good", "holds"))
        live.finds(finding("error", "bad", "violated"))
        told = ["violated: check bad", "warning: check w"]
        assert lines(terminal) == [*told, "3 of 4 answered, 0 s"]
        live("note idle")
        assert lines(terminal) == [*told, "3 of 4 answered, 0 s"]
        live.finds(finding("note", "n", "unknown"))
        told.append("unknown: check n")
        live("replay")
        assert lines(terminal) == [*told, "replay"]
    assert lines(terminal) == told
    assert terminal.getvalue().endswith("\x1b[K")


def test_what_was_held_is_shown_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    with Live() as live:
        live.asks(Counter(error=1, note=1))
        live.finds(finding("note", "n", "violated"))
        live.finish()
    assert lines(terminal) == ["note: check n"]


def test_elsewhere_nothing_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr("sys.stderr", stream)
    with Live() as live:
        live.asks(Counter(error=1))
        live.finds(finding("error", "bad", "violated"))
        live.finish()
    assert stream.getvalue() == ""


@needs_linux
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_command_on_a_terminal(run, spec, tmp_path, jobs):
    spec.write_text(DEAF)
    ours, theirs = pty.openpty()
    command, env = [*COMMAND, "check", "demo.exo", "--jobs", jobs], environment(CC=str(keeping_compiler()))
    with subprocess.Popen(command, cwd=tmp_path, env=env, stdout=subprocess.PIPE, stderr=theirs) as process:
        os.close(theirs)
        assert process.stdout is not None
        printed = process.stdout.read().decode()
        shown = b""
        while True:
            try:
                shown += os.read(ours, 4096)
            except OSError:
                break
    os.close(ours)
    assert printed == run("check", "demo.exo").stdout
    assert b"violated: reachability nd.goto\r\n" in shown
    assert re.search(rb"\d+ of \d+ answered, \d+ s", shown)
    assert shown.endswith(b"\x1b[K")


# ---- Ctrl-C ----


@needs_linux
@pytest.mark.parametrize("options", [("--jobs", "1"), ("--jobs", "2"), ("--jobs", "2", "--timeout", "60")])
def test_ctrl_c_prints_what_is_known(spec, tmp_path, options):
    command = [sys.executable, "-c", ENDLESS, "check", "demo.exo", "--format", "json", "--engine", "bdd", *options]
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, start_new_session=True
    ) as process:
        await_begun(tmp_path, int(options[1]))
        assert not (tmp_path / f"begun-{process.pid}").exists(), "what an engine does not hear the command does"
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the command and its processes
        printed, _ = process.communicate(timeout=20)
        assert process.returncode == 130
        assert gone(process.pid)
    report = json.loads(printed)
    assert report["verdict"] == "unknown"
    assert {f["message"] for f in report["findings"] if f["check"] == "endless"} == {"interrupted"}


SLOW = """
import sys, time
from exover.cli import check
from exover.cli.main import main

def build(model):
    print("here", file=sys.stderr, flush=True)
    time.sleep(60)

check.build = build
sys.exit(main(sys.argv[1:]))
"""
"""The command that takes long to make tables."""


@needs_linux
def test_ctrl_c_while_tables_are_made(spec, tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", SLOW, "check", "demo.exo"],
        cwd=tmp_path,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        assert process.stderr is not None
        assert process.stderr.readline() == b"here\n"
        process.send_signal(signal.SIGINT)
        printed, _ = process.communicate(timeout=20)
    assert process.returncode == 130
    assert "tables: none, the command ended before they were made" in printed.decode()
    assert "unknown" in printed.decode().splitlines()[-1]


# ---- jobs and memory ----


def test_jobs_are_the_cores_that_we_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: set(range(3)), raising=False)
    assert parser().parse_args(["check", "demo.exo"]).jobs == 3
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: set(range(64)), raising=False)
    assert parser().parse_args(["check", "demo.exo"]).jobs == 8
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 5)
    assert parser().parse_args(["emit", "demo.exo", "--target", "c", "--out", "."]).jobs == 5


HUNGRY = """
import sys
from exover.checks.schedule import plan
from exover.checks.questions import safety
from exover.checks.questions.question import Check, requests
from exover.cli.main import main

def decide(context, question):
    bytearray(2 << 30)
    raise AssertionError

plan.CHECKS = (Check("hungry", "error", "it ends", requests, decide, safety.claim), *plan.CHECKS)
sys.exit(main(sys.argv[1:]))
"""
"""The command with a check that wants 2 GiB."""


@needs_linux
@pytest.mark.parametrize("options", [("--jobs", "1"), ("--jobs", "2", "--timeout", "60")])
def test_what_takes_too_much_memory_is_unknown(spec, tmp_path, options):
    command = [sys.executable, "-c", HUNGRY, "check", "demo.exo", "--format", "json", "--engine", "bdd"]
    done = subprocess.run(
        [*command, "--memory", "1500", *options],
        cwd=tmp_path, env=environment(), capture_output=True, timeout=100, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (3, b"")
    found = json.loads(done.stdout)["findings"]
    assert {f["message"] for f in found if f["check"] == "hungry"} == {"memory limit of 1500 MiB"}
    assert {f["verdict"] for f in found if f["check"] == "safety"} == {"holds"}


@needs_linux
@pytest.mark.parametrize("engine", ["bdd", "z3"])
@pytest.mark.parametrize("memory", ["1", "120", "300"])
def test_engines_that_get_too_little_memory_are_no_fault(run, spec, engine, memory):
    done = run("check", "demo.exo", "--engine", engine, "--memory", memory, "--format", "json", timeout=100)
    assert done.returncode in (0, 3), done.stderr
    unknown = {f["message"] for f in json.loads(done.stdout)["findings"] if f["verdict"] == "unknown"}
    assert all(message.startswith(f"memory limit of {memory} MiB") for message in unknown) or done.returncode == 0
    assert unknown or memory != "1"


@pytest.fixture
def insatiable(monkeypatch):
    """Let tables take more memory than there is."""
    monkeypatch.setattr(check_module, "build", lambda model: bytearray(1 << 62))


def test_tables_that_take_too_much_memory_leave_all_unknown(spec, insatiable, capsys):
    assert main(["check", str(spec), "--no-cache"]) == 3
    told = capsys.readouterr()
    assert told.err == ""
    assert "not enough memory" in told.out
    assert "internal fault" not in told.out


@needs_linux
@pytest.mark.parametrize(("command", "said"), [("check", "out"), ("emit", "err")])
def test_tables_are_made_within_the_memory_that_is_given(spec, monkeypatch, capsys, tmp_path, command, said):
    monkeypatch.setattr(check_module, "build", lambda model: [bytearray(1 << 20) for _ in count()])
    memory = more_than_now(100)
    options = ["--no-cache"] if command == "check" else ["--target", "bin", "--out", str(tmp_path / "out")]
    assert main([command, str(spec), "--memory", str(memory), *options]) == 3
    told = capsys.readouterr()
    assert f"memory limit of {memory} MiB" in getattr(told, said)
    assert not (tmp_path / "out").exists()


def test_a_command_without_memory_says_so(spec, monkeypatch, capsys):
    monkeypatch.setattr("exover.cli.fmt.run", lambda arguments: bytearray(1 << 62))
    assert main(["fmt", str(spec)]) == 3
    assert capsys.readouterr().err == "exover: error: not enough memory: nothing more is known\n"


def test_memory_that_is_no_number_is_refused(run, spec):
    done = run("check", "demo.exo", "--memory", "much")
    assert (done.returncode, done.stdout) == (2, "")
    assert "'much' is no number of MiB" in done.stderr


def test_a_report_does_not_depend_on_who_watches(run, spec, tmp_path: Path):
    assert run("check", "demo.exo", "--jobs", "1").stdout == run("check", "demo.exo", "--jobs", "2").stdout
