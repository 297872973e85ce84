"""What events cost at most, printed on request, and the limits on it that make `exover check` a gate."""

import json
from time import sleep

import pytest

TIME_OVER = ("--timeout", "0.000001")


def test_bounds_are_printed_only_on_request(run, spec):
    plain, bounded = run("check", spec), run("check", spec, "--bounds")
    assert (plain.returncode, bounded.returncode, bounded.stderr) == (0, 0, "")
    added = [line for line in bounded.stdout.splitlines() if line not in plain.stdout.splitlines()]
    assert [line.split(":")[0] for line in added] == ["bounds", "stack"]
    assert "tests (ask nd.stop)" in added[0] and ", by " in added[0] and "arm-none-eabi-gcc" in added[1]


def test_bounds_in_json_stand_behind_the_other_keys(run, spec):
    plain = json.loads(run("check", spec, "--format", "json").stdout)["tables"]
    bounded = json.loads(run("check", spec, "--format", "json", "--bounds").stdout)["tables"]
    assert list(plain) == ["nodes", "depth", "bytes", "ram_bytes", "sha256"]
    assert list(bounded) == [*plain, "bounds"]
    bounds = bounded["bounds"]
    assert list(bounds) == ["tests", "answers", "passes", "stack_bytes", "stack_target", "events", "method"]
    for key in ("tests", "answers", "passes"):
        assert bounds[key] == max(event[key] for event in bounds["events"]) > 0
    subjects = ["ask nd.goto", "report nd.goto", "abort nd.goto", "abort nd.goto waiting", "observe battery"]
    assert set(subjects) <= {event["event"] for event in bounds["events"]}


@pytest.mark.parametrize("options", [("--bounds",), ("--max-tests", "1000")])
def test_the_time_limit_is_for_bounds_too(run, spec, options, monkeypatch):
    def endless(compiled):
        while True:
            sleep(60)

    monkeypatch.setattr("exover.engines.aig.costs.tightened", endless)
    done = run("check", spec, "--only", "safety", "--timeout", "5", *options)
    assert (done.returncode, done.stderr) == (0, "")
    assert ("by the longest paths of the tables" in done.stdout) is ("--bounds" in options)


@pytest.mark.parametrize("option", ["--max-tests", "--max-rom", "--max-ram"])
def test_a_limit_that_is_exceeded_is_status_1(run, spec, option):
    tables = json.loads(run("check", spec, "--format", "json", "--bounds").stdout)["tables"]
    figure = {"--max-tests": tables["bounds"]["tests"], "--max-rom": tables["bytes"], "--max-ram": tables["ram_bytes"]}
    kept = run("check", spec, option, figure[option])
    assert (kept.returncode, kept.stderr) == (0, "")
    broken = run("check", spec, option, figure[option] - 1)
    assert broken.returncode == 1 and broken.stdout == kept.stdout
    (line,) = broken.stderr.splitlines()
    assert line.startswith(f"exover: error: {spec}: ") and f" {figure[option]} " in line
    assert line.endswith(f"but {option} is {figure[option] - 1}")


def test_all_limits_are_told(run, spec):
    done = run("check", spec, "--max-tests", 0, "--max-rom", 0, "--max-ram", 0)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 3


def test_without_tables_nothing_is_exceeded(run, spec):
    done = run("check", spec, "--max-rom", 0, *TIME_OVER)
    assert done.returncode == 3 and "--max-rom" not in done.stderr


@pytest.mark.parametrize("wrong", ["-1", "x", "1.5", "", "1" * 30, "\u00b2"])
def test_a_limit_is_a_number(run, spec, wrong):
    done = run("check", spec, f"--max-ram={wrong}")
    assert done.returncode == 2 and "is no natural number" in done.stderr
