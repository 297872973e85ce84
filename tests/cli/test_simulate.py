"""`exover simulate` as a process: answers as they come, whatever the events are."""

import json
import resource
import signal
import subprocess

import pytest

from exover.model.wire_reading import MAX_LINE
from tests.cli.specs import SPEC
from tests.support.command import COMMAND, environment
from tests.support.sleeping import await_sleep

STOP = '{"ask": "nd.stop"}\n'


def test_answers_and_statuses(run, spec):
    events = '{"ask": "nd.goto", "args": {"x": 1}}\n\n  \r\n{"ask": "nd.stop"}\r\nno event\n'
    events += '{"report": "nd.goto", "outcome": "ok"}'
    done = run("simulate", spec, "--events", "-", input=events)
    assert (done.returncode, done.stderr) == (0, "")
    why = '"rule": "drive", "because": "a stop is a stop"'
    lines = done.stdout.splitlines()
    assert lines[0] == '{"step": 1, "actions": [{"launch": "nd.goto", "instance": 0, "args": {"x": 1}}]}'
    assert (
        lines[1]
        == f'{{"step": 2, "actions": [{{"kill": "nd.goto", "instance": 0, {why}}}, {{"wait": "nd.stop", {why}}}]}}'
    )
    assert json.loads(lines[2])["actions"][0]["invalid"] == "bad-event"
    assert lines[3] == '{"step": 4, "actions": [{"launch": "nd.stop", "instance": 0, "args": {}}]}'
    assert len(lines) == 4


def test_events_of_a_file_and_of_standard_input_are_the_same(run, spec):
    (spec.parent / "e.jsonl").write_text(STOP * 3)
    from_file = run("simulate", spec, "--events", "e.jsonl")
    assert from_file.stdout == run("simulate", spec, input=STOP * 3).stdout
    assert from_file.stdout.count("\n") == 3


def test_a_stream_without_an_event_is_no_stream_of_events(run, spec):
    for events in ("", "\n", SPEC, "[1]\n{}\n"):
        done = run("simulate", spec, input=events)
        assert done.returncode == 2
        assert done.stderr.startswith("exover: error: no line of <stdin> is an event: ")
        assert (
            done.stdout.count('"bad-event"')
            == done.stdout.count("\n")
            == sum(map(bool, map(str.strip, events.split("\n"))))
        )
    invalid = '{"ask": "nd.fly"}\n'
    assert run("simulate", spec, input=invalid).returncode == 0
    assert run("simulate", spec, input=SPEC + invalid).returncode == 0


def test_broken_lines_of_any_size(run, spec):
    long = "x" * 3_000_000
    nested = "[" * 900_000
    done = run("simulate", spec, input=f"{long}\n{nested}\n\x00\n{STOP}{long}")
    codes = [next(iter(json.loads(line)["actions"][0].values())) for line in done.stdout.splitlines()]
    assert codes == ["bad-event", "bad-event", "bad-event", "nd.stop", "bad-event"]
    assert done.returncode == 0


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_the_end_of_a_line_is_no_part_of_its_length(run, spec, end):
    stop = STOP.rstrip("\n")
    fits, long = (stop + " " * (MAX_LINE - len(stop) + more) for more in (0, 1))
    done = run("simulate", spec, input=f"{fits}{end}{long}{end}{STOP}{long}{end}{fits}")
    codes = [next(iter(json.loads(line)["actions"][0].values())) for line in done.stdout.splitlines()]
    assert codes == ["nd.stop", "bad-event", "nd.stop", "bad-event", "nd.stop"]


def test_engines_print_the_same_lines(run, spec):
    events = '{"ask": "nd.goto", "args": {"x": 0.30}}\n' + STOP + '{"observe": "battery", "value": 1e9}\n{"ask": 1}\n'
    done = [run("simulate", spec, "--engine", name, input=events) for name in ("reference", "tables", "c")]
    assert [(each.returncode, each.stderr) for each in done] == [(0, "")] * 3
    assert done[0].stdout == done[1].stdout == done[2].stdout
    assert done[0].stdout.count("\n") == 4


def test_no_c_compiler(run, spec):
    for changes in ({"PATH": "/nowhere"}, *({"CC": command} for command in ("no-such-compiler", "false", "true"))):
        done = run("simulate", spec, "--engine", "c", input=STOP, env=environment(**changes))
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.startswith("exover: error: ")
        assert "C compiler" in done.stderr


@pytest.mark.parametrize(("variable", "engine"), [("CC", "c"), ("RUSTC", "rust")])
def test_a_compiler_with_a_quote_that_is_not_closed(run, spec, variable, engine):
    broken = environment(**{variable: "'"})
    done = run("simulate", spec, "--engine", engine, input=STOP, env=broken)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"exover: error: ${variable} is no command, no closing quotation: '\n"
    assert run("doctor", env=broken).returncode == 0
    assert run("check", spec, env=broken).returncode == 0


def test_a_temporary_folder_that_is_full(run, spec):
    def small_files() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))

    done = run("simulate", spec, "--engine", "c", input=STOP, preexec_fn=small_files)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("exover: error: ")
    assert "File too large" in done.stderr


@pytest.fixture
def coprocess(spec):
    command = [*COMMAND, "simulate", str(spec)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment()
    ) as process:
        yield process
        process.kill()


def test_a_coprocess_answers_each_event_at_once(coprocess):
    for step in range(1, 4):
        coprocess.stdin.write(STOP.encode())
        coprocess.stdin.flush()
        assert json.loads(coprocess.stdout.readline())["step"] == step


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_it_quietly(coprocess, number, status):
    coprocess.stdin.write(STOP.encode())
    coprocess.stdin.flush()
    coprocess.stdout.readline()
    await_sleep(coprocess.pid)
    coprocess.send_signal(number)
    assert coprocess.wait(10) == status
    assert coprocess.stderr.read() == b""
