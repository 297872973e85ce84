"""`exover check` and `exover emit` as processes: statuses, reports, and bytes that are the same every time."""

import json
import struct

import pytest

from tests.cli.specs import DEAF, SHADOWED, SPEC, files
from tests.support.command import environment

FAR = "poster low: int in 0 .. 100000 = 0;\n"


def test_a_spec_that_holds(run, spec):
    done = run("check", "demo.exo")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("demo.exo: spec demo, 2 requests, 1 rule\n")
    assert "\ndemo: holds: all of " in done.stdout
    report = json.loads(run("check", "demo.exo", "--format", "json").stdout)
    assert (report["file"], report["spec"], report["verdict"]) == ("demo.exo", "demo", "holds")
    assert report["model"]["requests"] == 2
    assert report["model"]["state_bits"] > 0
    assert min(report["tables"][key] for key in ("nodes", "depth", "bytes", "ram_bytes")) > 0
    assert {finding["verdict"] for finding in report["findings"]} == {"holds"}
    assert all(finding["location"]["file"] == "demo.exo" for finding in report["findings"])


def test_a_spec_that_does_not(run, spec):
    spec.write_text(DEAF)
    done = run("check", spec)
    assert (done.returncode, done.stderr) == (1, "")
    assert f"\n  nd.goto violated at {spec}:3:21: " in done.stdout
    report = json.loads(run("check", spec, "--format", "json").stdout)
    assert report["verdict"] == "violated"
    bad = [f for f in report["findings"] if (f["verdict"], f["severity"]) == ("violated", "error")]
    assert ("reachability", "nd.goto") in [(f["check"], f["subject"]) for f in bad]


def test_warnings_count_when_they_are_denied(run, spec):
    spec.write_text(SHADOWED)
    plain = run("check", spec)
    assert plain.returncode == 0, plain.stdout
    assert "rule-use: 1 warning, " in plain.stdout
    assert "\ndemo: holds: 1 warning" in plain.stdout
    denied = run("check", spec, "--deny", "warnings")
    assert denied.returncode == 1
    assert "\ndemo: violated: 1 warning" in denied.stdout


def test_reports_are_the_same_bytes_every_time(run, spec):
    spec.write_text(DEAF)
    for form in ("text", "json"):
        runs = [run("check", spec, "--format", form, env=environment(PYTHONHASHSEED=seed)) for seed in ("1", "2")]
        assert [done.returncode for done in runs] == [1, 1]
        assert runs[0].stdout == runs[1].stdout


def test_timings_are_there_when_asked(run, spec):
    report = json.loads(run("check", spec, "--format", "json", "--timings").stdout)
    assert all(finding["seconds"] >= 0 for finding in report["findings"])
    assert " s\n" in run("check", spec, "--timings").stdout


def test_states_are_counted_when_that_is_asked(run, spec):
    plain = json.loads(run("check", spec, "--format", "json").stdout)
    counted = json.loads(run("check", spec, "--format", "json", "--count").stdout)
    number = counted["model"].pop("states")
    assert counted == plain
    assert list(counted["model"]) == ["requests", "rules", "state_bits"]
    # Nothing reads the battery. Nobody active, or either request running or stopping, or a stop clears away a goto.
    assert number == 6
    assert f"\nstates: {number} reachable\ntables: " in run("check", spec, "--count").stdout
    assert "\nstates:" not in run("check", spec).stdout


def test_states_that_cannot_be_counted_are_unknown(run, spec):
    spec.write_text(SPEC.replace("request stop();", "request stop() { check battery + low < 9; }") + FAR)
    done = run("check", spec, "--count")
    assert "\nstates: unknown, " in done.stdout
    assert json.loads(run("check", spec, "--count", "--format", "json").stdout)["model"]["states"] is None


def test_a_wrong_spec_prints_no_report(run, spec):
    spec.write_text("spec demo")
    for form in ("text", "json"):
        done = run("check", spec, "--format", form)
        assert (done.returncode, done.stdout) == (2, "")
        assert "error[E107]" in done.stderr


# ---- emit ----


@pytest.mark.parametrize("target", ["c", "bin", "json", "dot"])
def test_targets(run, spec, tmp_path, target):
    done = run("emit", spec, "--target", target, "--out", "a/b")
    assert (done.returncode, done.stderr) == (0, "")
    written = files(tmp_path / "a" / "b")
    assert done.stdout.splitlines() == [
        f"a/b/{name}" for name in dict.fromkeys(line[4:] for line in done.stdout.split())
    ]
    assert sorted(written) == sorted(line[4:] for line in done.stdout.split())
    assert all(written.values())


def test_several_targets_are_proved_once_and_written_together(run, spec, tmp_path):
    every = ("c", "rust", "bin", "json", "dot", "smt2", "smv", "aiger")
    for target in every:
        assert run("emit", spec, "--target", target, "--out", "alone").returncode == 0
    done = run("emit", spec, "--target", "c,rust,bin,json", "--target", "dot,smt2,smv,aiger,c", "--out", "all")
    assert (done.returncode, done.stderr) == (0, "")
    trees = [
        {path.relative_to(tmp_path / out): path.read_bytes() for path in (tmp_path / out).rglob("*") if path.is_file()}
        for out in ("alone", "all")
    ]
    assert trees[0] == trees[1]
    assert sorted(done.stdout.splitlines()) == sorted(f"all/{path}" for path in trees[1])
    spec.write_text(DEAF)
    done = run("emit", spec, "--target", "smv,bin", "--out", "none")
    assert (done.returncode, done.stderr.count("nothing is emitted")) == (1, 1)
    assert not (tmp_path / "none").exists()
    assert run("emit", spec, "--target", "smv,bin", "--out", "none", "--unchecked").returncode == 0
    assert sorted(files(tmp_path / "none")) == ["demo.bin", "demo.fair.smv", "demo.smv"]


def test_a_target_that_is_none(run, spec):
    done = run("emit", spec, "--target", "c,rsut", "--out", "x")
    assert done.returncode == 2
    assert "invalid choice: 'rsut' (choose from" in done.stderr
    assert "did you mean `rust`?" in done.stderr


def test_emitted_files_are_the_same_bytes_every_time(run, spec, tmp_path):
    for out in ("1", "2"):
        arguments = ("emit", spec, "--target", "c", "--out", out, "--unchecked")
        assert run(*arguments, env=environment(PYTHONHASHSEED=out)).returncode == 0
    assert files(tmp_path / "1") == files(tmp_path / "2") != {}


def test_the_bytes_are_those_that_were_checked(run, spec, tmp_path):
    from hashlib import sha256

    report = json.loads(run("check", spec, "--format", "json").stdout)
    run("emit", spec, "--target", "bin", "--out", "out")
    (data,) = files(tmp_path / "out").values()
    assert sha256(data).hexdigest() == report["tables"]["sha256"]
    assert len(data) == report["tables"]["bytes"]


def test_nothing_is_emitted_that_does_not_hold(run, spec, tmp_path):
    spec.write_text(DEAF)
    done = run("emit", spec, "--target", "bin", "--out", "out")
    assert (done.returncode, done.stdout) == (1, "")
    assert "reachability" in done.stderr
    assert "exover: error: nothing is emitted" in done.stderr
    assert not (tmp_path / "out").exists()


def test_unchecked_tables_say_so(run, spec, tmp_path):
    flags = []
    for out, options in (("checked", ()), ("unchecked", ("--unchecked",))):
        assert run("emit", spec, "--target", "bin", "--out", out, *options).returncode == 0
        (data,) = files(tmp_path / out).values()
        flags.append(struct.unpack_from("<I", data, 8)[0])
    assert flags == [0, 1]
    spec.write_text(DEAF)
    assert run("emit", spec, "--target", "c", "--out", "c", "--unchecked").returncode == 0


def test_a_folder_that_cannot_be_written(run, spec, tmp_path):
    (tmp_path / "taken").write_text(SPEC)
    for out, told in (
        ("taken", "cannot write taken: Not a directory"),
        ("demo.exo", "demo.exo cannot be written over: the command reads it"),
    ):
        done = run("emit", spec, "--target", "bin", "--out", out)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == f"exover: error: {told}\n"
    assert spec.read_text() == (tmp_path / "taken").read_text() == SPEC


def test_a_property_that_ranges_decide_is_warned_of(run, spec):
    file = spec.with_suffix(".prop")
    file.write_text("for demo;\nassume always battery <= 100;\nproperty p: never battery > 100;\n")
    done = run("check", spec, "--only", "property")
    assert done.returncode == 0
    assert done.stderr.splitlines() == [
        f"exover: warning: {file}:3:10: in property `p`, `battery > 100` is false whatever happens: "
        "battery lies in 0 .. 100",
        f"exover: warning: {file}:2:1: in an assumption, `battery <= 100` is true whatever happens: "
        "battery lies in 0 .. 100",
    ]


@pytest.mark.parametrize(
    ("assumed", "warned"),
    [
        ("assume fair reports; assume never ended(nd.goto)", True),
        ("assume fair reports; assume never (ended(nd.goto) or battery == 1)", True),
        ("assume fair reports; assume always (not ended(nd.goto) or battery == 1)", False),
        ("assume fair reports; assume always ended(nd.goto)", False),
        ("assume never ended(nd.goto)", False),
    ],
)
def test_a_request_that_never_ends_beside_fair_reports_is_warned_of(run, spec, assumed, warned):
    file = spec.with_suffix(".prop")
    file.write_text(f"for demo;\n{assumed.replace('; ', ';' + chr(10))};\nproperty p: never active(nd.goto);\n")
    told = f"exover: warning: {file}:3:1: `never ended(nd.goto)` and `assume fair reports` leave no run on which "
    assert (told in run("check", spec, "--only", "property").stderr) == warned


def test_a_request_that_never_ends_with_some_arguments_beside_fair_reports_is_warned_of(run, tmp_path):
    spec = tmp_path / "s.exo"
    spec.write_text("spec s; module m { request a(x: int in 0 .. 9); request b(); } mutex m.a, m.b;")
    file = spec.with_suffix(".prop")
    file.write_text("for s;\nassume fair reports;\nassume never ended(m.a with x > 5);\n")
    told = (
        "`never ended(m.a with x > 5)` and `assume fair reports` leave no run on which m.a is active with x > 5: if it"
    )
    assert f"exover: warning: {file}:3:1: {told}" in run("check", spec, "--only", "property").stderr


@pytest.mark.parametrize(
    ("assumed", "reads"),
    [
        ("always depth <= 220", ["depth` is broken: then it reads 250"]),
        ("never (depth > 220 or lamp)", ["depth` is broken: then it reads 250", "lamp` is broken: then it reads true"]),
        ("always (depth <= 220 or depth == 250)", []),
        ("never (depth > 220 and lamp)", []),
        ("never (depth > 220 and active(m.a))", []),
        ("never (asked(m.a) and depth > 220)", []),
        ("never depth > rail", []),
        ("always rail < 9", []),
        ("never (depth > 220 or storm)", ["depth` is broken: then it reads 250"]),
    ],
)
def test_an_assumption_under_which_no_sensor_breaks_is_warned_of(run, tmp_path, assumed, reads):
    spec = tmp_path / "s.exo"
    spec.write_text("""spec s; poster depth: int in 0 .. 250 = 0 else 250; poster lamp: bool = false else true;
poster rail: int in 0 .. 300 = 300; latch storm: when rail < 9 until m.a;
module m { request a(); request b(); } mutex m.a, m.b;""")
    file = spec.with_suffix(".prop")
    file.write_text(f"for s;\nassume {assumed};\n")
    said = f"exover: warning: {file}:2:1: the assumption leaves no run on which `"
    lines = run("check", spec, "--only", "consistency").stderr.splitlines()
    assert [each.removeprefix(said) for each in lines if "leaves no run" in each] == reads


def test_a_condition_that_never_changes_is_warned_of_unless_a_finding_tells_of_it(run, tmp_path):
    spec = tmp_path / "arm.exo"
    spec.write_text("""spec arm; poster wind: int in 0 .. 60 = 0;
latch storm: when wind > 99 until m.clean;
module m { state holds: {nothing, brush, knife} = nothing;
    request clean(side: {root, cap}) { on ok set holds = brush; }
    request weld(side: {root, cap}) { check cleaned: past(m.clean with side == side); fail when m.holds == knife; }
    request tack(side: {root, cap}) { check cleaned: past(m.clean with side == side) and wind in 0 .. 9; } }
""")
    done = run("check", spec)
    meant = "`side == side` is true whatever happens: both sides are the same; did you mean `self.side`?"
    assert done.stderr.splitlines() == [
        f"exover: warning: {spec}:2:7: in latch `storm`, `wind > 99` is false whatever happens: wind lies in 0 .. 60",
        f"exover: warning: {spec}:5:39: in `m.weld.cleaned`, {meant}",
    ]
    assert "`m.holds == knife` is false whatever happens: m.holds is nothing or brush" in done.stdout
    assert run("check", spec, "--only", "safety").stderr == ""
