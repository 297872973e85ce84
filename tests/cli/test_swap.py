"""`exover swap`: what it proves, names and refuses, and with which status."""

from contextlib import suppress
from pathlib import Path
from time import sleep
from types import SimpleNamespace

import pytest

from exover.limits import TimeUp, interrupted

HEAD = "spec {name}; poster speed: real in 0 .. 2 = 0;"
OLD = "module m { request a(); request b(); request c(v: int in 0 .. 3) instances 2; } mutex ab: m.a, m.b;"


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / f"{name}.exo"
    path.write_text(HEAD.format(name=name) + text)
    return path


@pytest.mark.parametrize(
    ("new", "status", "ended"),
    [
        (OLD, 0, []),
        (OLD.replace("mutex ab: m.a, m.b;", ""), 0, []),
        (OLD + "mutex ac: m.a, m.c;", 0, ["m.a (for ac)"]),
        (OLD + "mutex ac: m.a, m.c; mutex bc: m.b, m.c;", 0, ["m.c (for ac, bc)"]),
        (OLD + "limit few: at most 2 of m.a, m.b, m.c;", 0, ["m.c (for few)"]),
        (OLD + "limit few: at most 3 of m.a, m.b, m.c;", 0, []),
        (OLD.replace("request b();", ""), 0, ["m.b (it is another there, or not there)"]),
        (OLD.replace("0 .. 3", "0 .. 5"), 0, []),
        (OLD.replace("0 .. 3", "1 .. 3"), 0, ["m.c (it is another there, or not there)"]),
        (OLD.replace("instances 2", "instances 1"), 0, ["m.c (it is another there, or not there)"]),
        (OLD + "forbid fast: active(m.b) and speed > 1 by kill m.b;", 0, []),
        (OLD + "forbid slow: speed < 1;", 1, []),
    ],
)  # fmt: skip
def test_requests_that_have_to_end_are_named(new: str, status: int, ended: list[str], run, tmp_path) -> None:
    new = new.replace("mutex ab: m.a, m.b;", "") if "request b" not in new else new
    paths = write(tmp_path, "old", OLD), write(tmp_path, "new", new)
    done = run("swap", *paths, "--out", tmp_path / "map")
    assert done.returncode == status, done.stderr
    found = [line.removeprefix("has to end first: ") for line in done.stdout.splitlines() if "end first" in line]
    assert found == ended
    assert (tmp_path / "map").exists() == (status == 0)


@pytest.mark.parametrize("low", ["used(power) <= 30", "not used(power) > 30", "not (active(m.a) and used(power) > 30)"])
def test_a_rule_that_less_use_breaks_is_not_proved_by_what_may_be_used(low: str, run, tmp_path) -> None:
    """OLD comes to where `a(false)` and `b` are active, which use 1 of the power."""
    shares = "request a(v: bool) { uses power 30 when v; } request b() { uses power 1; }"
    old = f"resource power: 100; module m {{ {shares} }} forbid both: not active(m.a) and active(m.b) by kill m.b;"
    new = f"{old} forbid low: {low} and active(m.b) by kill m.b;"
    done = run("swap", write(tmp_path, "old", old), write(tmp_path, "new", new), "--out", tmp_path / "map")
    assert done.returncode != 0 and "may be broken, whatever has ended: low" in done.stdout


def test_what_starts_anew_is_told(run, tmp_path) -> None:
    """Nothing in OLD compares the speed with 1: a rule about it is asked with what NEW starts with."""
    paths = (
        write(tmp_path, "old", OLD),
        write(tmp_path, "new", OLD + "forbid fast: active(m.b) and speed > 1 by kill m.b;"),
    )
    assert "starts anew: speed\n" in run("swap", *paths, "--out", tmp_path / "map").stdout


def test_a_mistake_and_a_folder_are_refused(run, tmp_path) -> None:
    good, bad = write(tmp_path, "old", OLD), write(tmp_path, "bad", "module")
    assert run("swap", good, bad, "--out", tmp_path / "map").returncode == 2
    assert run("swap", good, good, "--out", f"{tmp_path}/").returncode == 2


def test_ctrl_c_ends_it_and_nothing_is_written(run, tmp_path, monkeypatch) -> None:
    def interrupt(*asked: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("exover.checks.run.spread", interrupt)
    done = run("swap", write(tmp_path, "old", OLD), write(tmp_path, "new", OLD), "--out", tmp_path / "map", "--jobs", 1)
    assert (done.returncode, done.stdout) == (130, "")
    assert not (tmp_path / "map").exists()


def test_no_more_is_asked_when_the_time_is_over(run, tmp_path, monkeypatch) -> None:
    asked: list[int] = []

    def late(old, properties, progress, limits):
        asked.append(len(properties.properties))
        with suppress(TimeUp), interrupted(limits):
            sleep(60)
        return tuple(SimpleNamespace(subject=each.name, verdict="unknown") for each in properties.properties)

    monkeypatch.setattr("exover.cli.swap.property_findings", late)
    paths = write(tmp_path, "old", OLD), write(tmp_path, "new", OLD + "mutex ac: m.a, m.c;")
    done = run("swap", *paths, "--out", tmp_path / "map", "--timeout", "2")
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr == "exover: error: time limit of 2 s: nothing is written\n"
    assert len(asked) == 1 and not (tmp_path / "map").exists()
