"""`exover diff`: what it shows, names and refuses, and with which status."""

import json
import os
import subprocess
from pathlib import Path

import jsonschema
import pytest

import exover.cli.check
import exover.cli.diff
from exover.engines.aig.comparison import Comparison
from exover.limits import TimeUp
from tests.support.launches import LINKED, chain

HEAD = """spec lift;
module cabin { request go(v: real in 0 .. 2) { check slow: v <= 1; } request brake(); }
module door { request open(); }
poster load: int in 0 .. 500 = 0;
"""
SCHEMA = Path(__file__).parents[1] / "report" / "sarif-schema-2.1.0.json"
RULES = "mutex drive: cabin.brake over cabin.go; mutex closed: cabin.go, door.open by wait;"
OLD = HEAD + RULES


def told(run, folder: Path, old: str, new: str, *options: str) -> dict:
    """Return what the command says as JSON."""
    (folder / "old.exo").write_text(old)
    (folder / "new.exo").write_text(new)
    done = run("diff", folder / "old.exo", folder / "new.exo", "--format", "json", *options)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def shown(found: dict) -> set[tuple]:
    return {(each["request"], each["change"], each["weaker"], len(each["trace"])) for each in found["changes"]}


def test_what_goes_on_waiting_is_told_where_no_answer_says_so(run, tmp_path: Path) -> None:
    told(run, tmp_path, OLD, OLD.replace("mutex drive: cabin.brake over cabin.go;", ""))
    text = run("diff", tmp_path / "old.exo", tmp_path / "new.exo").stdout
    assert "       NEW: launch cabin.brake()\n       NEW: cabin.go goes on waiting\n" in text
    assert text.count("goes on waiting") == 1


@pytest.mark.parametrize(
    ("edit", "changes"),
    [
        (("", ""), set()),
        (("mutex drive", "mutex stop"), set()),
        (("v <= 1", "v <= 1.5"), {("cabin.go", "newly launched", True, 1), ("cabin.go", "newly waiting", False, 2)}),
        (("v <= 1", "v <= 0.5"), {("cabin.go", "newly rejected", False, 1)}),
        (("door.open by wait", "door.open"), {("cabin.go", "newly rejected", False, 2),
                                              ("door.open", "newly rejected", False, 2)}),
        (("mutex drive: cabin.brake over cabin.go;", ""), {("cabin.brake", "newly launched", True, 2),
                                                           ("cabin.go", "newly launched", True, 2),
                                                           ("cabin.go", "no longer killed", False, 2),
                                                           ("cabin.go", "newly waiting", False, 3)}),
        (("by wait;", "by wait; launch hold: cabin.brake() when load > 450;"),
         {("cabin.brake", "newly launched", False, 1), ("cabin.brake", "newly waiting", False, 2),
          ("cabin.go", "newly killed", False, 2), ("cabin.go", "newly rejected", False, 3)}),
    ],
)  # fmt: skip
def test_changes_are_shown_by_shortest_runs(edit: tuple[str, str], changes: set, run, tmp_path: Path) -> None:
    found = told(run, tmp_path, OLD, OLD.replace(*edit) if edit[0] else OLD)
    assert shown(found) == changes
    assert found["verdict"] == ("changed" if changes else "same")
    assert not found["unknown"]


def test_what_one_version_alone_has_counts_by_what_it_does_to_others(run, tmp_path: Path) -> None:
    new = OLD.replace("request open();", "request open(); request hold();") + "mutex held: door.hold, door.open;"
    found = told(run, tmp_path, OLD, new)
    assert shown(found) == {("door.open", "newly rejected", False, 2)}
    assert found["only_new"] == ["door.hold"]
    first, last = found["changes"][0]["trace"]
    assert (first["old"], last["old"][0]["launch"]) == (None, "door.open")


def test_a_renamed_request_is_the_same(run, tmp_path: Path) -> None:
    new = OLD.replace("door.open", "door.slide").replace("request open", "request slide")
    assert told(run, tmp_path, OLD, new, "--rename", "door.open=door.slide")["verdict"] == "same"
    found = told(run, tmp_path, OLD, new)
    assert (found["only_old"], found["only_new"]) == (["door.open"], ["door.slide"])
    assert {each["request"] for each in found["changes"]} == {"cabin.go"}


def test_values_that_one_version_alone_takes_are_told_and_left_out(run, tmp_path: Path) -> None:
    found = told(run, tmp_path, OLD, OLD.replace("0 .. 2", "0 .. 3").replace("0 .. 500", "0 .. 600"))
    assert found["verdict"] == "same"
    assert len(found["notes"]) == 2


def test_another_value_for_broken_readings_is_a_change(run, tmp_path: Path) -> None:
    rule = "forbid heavy: active(cabin.go) and load > 400 by kill cabin.go;"
    old, new = (OLD.replace("500 = 0;", f"500 = 0 else {value};") + rule for value in (0, 500))
    found = told(run, tmp_path, old, new)
    assert ("cabin.go", "newly killed", False, 2) in shown(found)
    killed = next(each for each in found["changes"] if each["change"] == "newly killed")
    assert killed["trace"][-1]["new"][0] == {"invalid": "out-of-range", "detail": "taken as 500"}


def test_what_a_request_leaves_behind_counts_where_it_is_read(run, tmp_path: Path) -> None:
    head = "spec s; module m { state up: bool = false; request b() { check up; } request a()"
    old, new = (head + f" {{ on ok set up = {value}; }} }}" for value in ("true", "false"))
    assert shown(told(run, tmp_path, old, new)) == {("m.b", "newly rejected", False, 3)}
    assert shown(told(run, tmp_path, new, old)) == {("m.b", "newly launched", True, 3)}


def test_properties_of_both_are_compared(run, tmp_path: Path) -> None:
    (tmp_path / "lift.prop").write_text("for lift; property apart: never (active(cabin.go) and active(door.open));")
    found = told(run, tmp_path, OLD, HEAD + "mutex drive: cabin.brake over cabin.go;")
    assert found["properties"] == [{"property": "apart", "old": "holds", "new": "violated"}]


def test_properties_are_those_that_are_named(run, tmp_path: Path) -> None:
    one, other = tmp_path / "one.prop", tmp_path / "other.prop"
    one.write_text("for lift; property apart: never (active(cabin.go) and active(door.open));")
    other.write_text("for lift; property apart: never (active(cabin.go) and active(cabin.brake));")
    new = HEAD + "mutex drive: cabin.brake over cabin.go;"
    (tmp_path / "old.exo").write_text(OLD)
    (tmp_path / "new.exo").write_text(new)
    refused = run("diff", tmp_path / "old.exo", tmp_path / "new.exo")
    assert refused.returncode == 2 and "name one with --properties" in refused.stderr
    broken = [{"property": "apart", "old": "holds", "new": "violated"}]
    both = told(run, tmp_path, OLD, new, "--properties", str(one))
    assert both["properties"] == broken
    assert not any("otherwise" in note for note in both["notes"])
    each = told(run, tmp_path, OLD, new, "--properties", str(one), "--old-properties", str(other))
    assert each["properties"] == broken
    assert "NEW states otherwise the properties apart" in each["notes"]
    assert each["old"]["properties"].endswith("other.prop") and each["new"]["properties"].endswith("one.prop")


def test_old_has_half_of_the_time(run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """However long its properties take."""
    (tmp_path / "lift.prop").write_text("for lift; property apart: never (active(cabin.go) and active(door.open));")
    shares: list[float] = []
    findings = exover.cli.diff.property_findings

    def noted(built, properties, progress, limits, engines):
        shares.append(limits.left)
        return findings(built, properties, progress, limits, engines)

    monkeypatch.setattr(exover.cli.diff, "property_findings", noted)
    told(run, tmp_path, OLD, OLD, "--timeout", "600", "--jobs", "1")
    assert 250 < shares[0] < 301 < 500 < shares[1]


def test_assumptions_rule_differences_out(run, tmp_path: Path) -> None:
    (tmp_path / "lift.prop").write_text("for lift; assume never (asked(door.open));")
    assert told(run, tmp_path, OLD, OLD.replace("door.open by wait", "door.open"))["verdict"] == "same"


def test_what_is_assumed_is_asked_of_steps_that_are_settled(run, tmp_path: Path) -> None:
    """Each launch needs a pass of its own; at the end of the step all are active, and within it not."""
    (tmp_path / "s.prop").write_text(f"for s; {LINKED}")
    old = f"spec s; module n {{ request further(); }} {chain(4)} "
    assert shown(told(run, tmp_path, old, old + "launch l5: n.further() when active(m.r4);")) == {
        ("n.further", "newly launched", False, 1)
    }


@pytest.mark.parametrize(
    ("new", "status"), [(OLD, 0), (OLD.replace("<= 1", "<= 0.9"), 0), (OLD.replace("<= 1", "<= 1.1"), 1), (HEAD, 1)]
)
def test_a_weaker_spec_is_denied(new: str, status: int, run, tmp_path: Path) -> None:
    (tmp_path / "old.exo").write_text(OLD)
    (tmp_path / "new.exo").write_text(new)
    done = run("diff", tmp_path / "old.exo", tmp_path / "new.exo", "--deny-weaker")
    assert done.returncode == status, done.stdout


@pytest.mark.parametrize("form", ["text", "markdown"])
@pytest.mark.parametrize("new", [OLD.replace("0 .. 2", "0 .. 3"), OLD + "module other { request work(); }"])
def test_what_one_version_alone_takes_is_not_said_to_be_unchanged(new: str, form: str, run, tmp_path: Path) -> None:
    (tmp_path / "old.exo").write_text(OLD)
    for text, within in ((new, " within what is compared"), (OLD, "")):
        (tmp_path / "new.exo").write_text(text)
        done = run("diff", tmp_path / "old.exo", tmp_path / "new.exo", "--format", form)
        assert f"no change of behaviour{within}: proved for every run" in done.stdout
        (tmp_path / "new.exo").write_text(text.replace("<= 1", "<= 0.9"))
        done = run("diff", tmp_path / "old.exo", tmp_path / "new.exo", "--format", form)
        assert f"NEW launches nothing that OLD refuses or lets wait{within and f',{within}'}" in done.stdout


def test_the_notes_stand_in_every_format(run, tmp_path: Path) -> None:
    (tmp_path / "old.exo").write_text(OLD)
    (tmp_path / "new.exo").write_text(OLD + "module other { request work(); }")
    for form in ("text", "markdown", "json", "sarif"):
        done = run("diff", tmp_path / "old.exo", tmp_path / "new.exo", "--format", form)
        assert "NEW alone has other.work" in done.stdout


@pytest.mark.parametrize(
    ("new", "options", "message"),
    [
        (OLD.replace("v: real in 0 .. 2", "v: bool").replace("v <= 1", "v"), (), "the parameter v, real in 0 .. 2 in"),
        (OLD.replace("open()", "open(far: bool)"), (), "door.open has the parameter far in NEW alone"),
        (
            OLD.replace("load: int in 0 .. 500 = 0", "load: int in 600 .. 900 = 600"),
            (),
            "load is int in 0 .. 500",
        ),
        ("spec other; module m { request a(); }", (), "no request in common"),
        ("spec other; module m { request a() }", (), "old.exo"),
        (OLD, ("--rename", "door.opn=door.open"), "OLD has no request door.opn; did you mean `door.open`?"),
        (OLD, ("--rename", "door.open=cabin.go"), "OLD has a cabin.go of its own"),
        (OLD, ("--rename", "door.open"), "is no OLD=NEW"),
        (OLD, ("--against", "HEAD"), "is in no git repository"),
    ],
)
def test_what_cannot_be_compared_is_refused(new: str, options: tuple, message: str, run, tmp_path: Path) -> None:
    (tmp_path / "old.exo").write_text(OLD)
    (tmp_path / "new.exo").write_text(new)
    done = run("diff", tmp_path / "old.exo", tmp_path / "new.exo", *options)
    assert done.returncode == 2
    assert message in done.stderr or message == "old.exo"
    assert not done.stdout


def git(folder: Path, *words: str) -> None:
    who = {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_SYSTEM": os.devnull}
    names = ["-c", "user.name=a", "-c", "user.email=a@example.com"]
    subprocess.run(["git", "-C", folder, *names, *words], check=True, capture_output=True, env={**os.environ, **who})


def test_statuses_of_one_version_alone_are_told(run, tmp_path: Path) -> None:
    """A report with such a status is invalid in the other version: it is no event of both."""
    old = "spec s; module m { request a() fails (lost, stuck); request b() fails (x); request c() fails (y); }"
    new = old.replace("lost, stuck", "stuck, lost").replace("(y)", "(y, z)").replace("(x)", "(w)")
    found = told(run, tmp_path, old, new)
    assert found["verdict"] == "same"
    assert found["notes"] == [
        "statuses of m.b: (x) in OLD, (w) in NEW, compared on none",
        "statuses of m.c: (y) in OLD, (y, z) in NEW, compared on (y)",
    ]


def test_a_spec_is_compared_with_itself_at_a_revision(run, tmp_path: Path) -> None:
    spec, prop = tmp_path / "specs" / "lift.exo", tmp_path / "properties" / "lift.prop"
    for file, text in ((spec, OLD), (prop, "for lift; property apart: possible (active(cabin.go));")):
        file.parent.mkdir()
        file.write_text(text)
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-qm", "first")
    assert "no change of behaviour" in run("diff", spec, "--against", "HEAD").stdout
    spec.write_text(OLD.replace("v <= 1", "v <= 0.5"))
    prop.unlink()
    done = run("diff", spec, "--against", "HEAD", "--format", "json", cwd=spec.parent)
    found = json.loads(done.stdout)
    assert found["old"] == {"spec": "lift", "file": "HEAD:specs/lift.exo", "properties": "HEAD:properties/lift.prop"}
    assert ("cabin.go", "newly rejected", False, 1) in shown(found)
    for revision, message in (("nowhere", "no revision nowhere"), ("--help", "no revision --help")):
        done = run("diff", spec, f"--against={revision}")
        assert (done.returncode, done.stdout) == (2, "")
        assert message in done.stderr
    spec.write_text(spec.read_text().replace("spec lift;", 'spec lift; include "../part.exo";'))
    (tmp_path / "part.exo").write_text("part p; module p { request q(); }")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-qm", "second")
    (tmp_path / "part.exo").write_text("part p; module p { request q(); request r(); } mutex qr: p.q, p.r;")
    assert "NEW alone has p.r" in run("diff", spec, "--against", "HEAD").stdout
    other = tmp_path / "specs" / "other.exo"
    other.write_text(OLD)
    assert "HEAD has no file specs/other.exo" in run("diff", other, "--against", "HEAD").stderr
    prop.write_text("for lift; property apart: never (active(cabin.go));")
    found = json.loads(run("diff", spec, "--against", "HEAD", "--old-properties", prop, "--format", "json").stdout)
    assert found["old"]["properties"] == str(prop)


def repository(folder: Path, **files: str) -> None:
    """Make a repository of one commit with these files."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    git(folder, "init", "-q")
    git(folder, "add", ".")
    git(folder, "commit", "-qm", "first")


PART = "part p; module p { request q(); request r(); }"


@pytest.mark.parametrize("folder", ["", "specs/"])
def test_parts_are_those_of_a_revision_with_a_slash(run, tmp_path: Path, folder: str) -> None:
    strict = f"{PART} mutex qr: p.q, p.r;"
    spec = 'spec s; include "p.exo"; include "./p.exo";'
    repository(tmp_path, **{f"{folder}s.exo": spec, f"{folder}p.exo": strict})
    git(tmp_path, "update-ref", "refs/remotes/origin/main", "HEAD")
    for name in ("p.exo", "origin/p.exo", "origin/specs/p.exo"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(PART)
    (tmp_path / folder / "p.exo").write_text(PART)
    assert run("diff", f"{folder}s.exo", "--against", "origin/main", "--deny-weaker").returncode == 1


def test_no_part_of_a_revision_is_outside_of_it(run, tmp_path: Path) -> None:
    repository(tmp_path, **{"specs/s.exo": 'spec s; include "../../p.exo";', "p.exo": PART})
    done = run("diff", "specs/s.exo", "--against", "HEAD")
    assert done.returncode == 2
    assert "cannot read `HEAD:../p.exo`" in done.stderr


@pytest.mark.parametrize(("spec", "part"), [("s.exo", "parts/p.exo"), ("specs/s.exo", "../parts/p.exo")])
def test_mistakes_of_a_revision_are_named_as_git_names_its_files(run, tmp_path: Path, spec: str, part: str) -> None:
    wrong = f'{PART} include "../parts/p.exo"; limit none: at most 1 of p.t;'
    repository(tmp_path, **{spec: f'spec s; include "{part}"; mutex one: p.q, p.none;', "parts/p.exo": wrong})
    said = run("diff", spec, "--against", "HEAD").stderr
    assert "`HEAD:parts/p.exo` includes itself" in said
    assert " --> HEAD:parts/p.exo:1:" in said
    (tmp_path / "parts" / "p.exo").write_text(f"{PART} limit none: at most 1 of p.t;")
    git(tmp_path, "commit", "-qam", "second")
    said = run("diff", spec, "--against", "HEAD").stderr
    assert f" --> HEAD:{spec}:1:" in said
    assert " --> HEAD:parts/p.exo:1:" in said
    assert f"error: HEAD:{spec} has mistakes" in said


def test_the_repository_is_that_of_the_spec_in_a_hook_too(run, tmp_path: Path) -> None:
    repository(tmp_path, **{"specs/lift.exo": OLD, "lift.exo": OLD.replace("v <= 1", "v <= 0.5")})
    (tmp_path / "specs" / "lift.exo").write_text(OLD.replace("v <= 1", "v <= 0.5"))
    hook = {**os.environ, "GIT_DIR": str(tmp_path / ".git")}
    done = run("diff", "specs/lift.exo", "--against", "HEAD", env=hook)
    assert "changed:" in done.stdout, done


def test_links_lead_to_files_at_a_revision(run, tmp_path: Path) -> None:
    spec, link = tmp_path / "specs" / "lift.exo", tmp_path / "specs" / "lift.prop"
    for file, text in (
        (spec, OLD),
        (tmp_path / "shared" / "some", "for lift; property apart: possible active(cabin.go);"),
    ):
        file.parent.mkdir()
        file.write_text(text)
    (tmp_path / "properties").mkdir()
    (tmp_path / "properties" / "again.prop").symlink_to(Path("..", "shared", "some"))
    link.symlink_to(Path("..", "shared", "some"))
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-qm", "first")
    for target in ("nowhere", "lift.prop"):
        done = run("diff", spec, "--against", "HEAD", "--format", "json")
        assert json.loads(done.stdout)["old"]["properties"] == "HEAD:specs/lift.prop"
        link.unlink()
        link.symlink_to(target)
        git(tmp_path, "add", ".")
        git(tmp_path, "commit", "-qm", f"to {target}")
        link.unlink()
        done = run("diff", spec, "--against", "HEAD")
        assert (done.returncode, done.stdout) == (2, "")
        assert "HEAD:specs/lift.prop is a link that leads to no file of HEAD" in done.stderr
        git(tmp_path, "reset", "-q", "--hard", "HEAD~")


def test_a_spec_that_is_a_link_has_the_properties_beside_it_at_a_revision(run, tmp_path: Path) -> None:
    for file, text in {
        "shared/lift.exo": OLD,
        "cabin/lift.prop": "for lift; property a: possible active(cabin.go);",
    }.items():
        (tmp_path / file).parent.mkdir()
        (tmp_path / file).write_text(text)
    (tmp_path / "cabin" / "lift.exo").symlink_to(Path("..", "shared", "lift.exo"))
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-qm", "first")
    found = json.loads(run("diff", "cabin/lift.exo", "--against", "HEAD", "--format", "json").stdout)
    assert found["old"]["properties"] == "HEAD:cabin/lift.prop" and found["properties"] == []


def test_nothing_is_known_when_the_time_is_over(run, tmp_path: Path) -> None:
    (tmp_path / "old.exo").write_text(OLD)
    done = run.apart("diff", tmp_path / "old.exo", tmp_path / "old.exo", "--timeout", "0.001")
    assert (done.returncode, done.stdout) == (3, "")
    assert "time limit" in done.stderr


def test_what_was_found_before_the_time_was_over_is_told(run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def late(comparison: Comparison) -> None:
        raise TimeUp

    monkeypatch.setattr(Comparison, "_prove", late)
    (tmp_path / "old.exo").write_text(OLD)
    (tmp_path / "new.exo").write_text(OLD.replace("v <= 1", "v <= 0.5"))
    done = run("diff", tmp_path / "old.exo", tmp_path / "new.exo", "--timeout", "600", "--format", "json")
    found = json.loads(done.stdout)
    assert (done.returncode, found["verdict"]) == (3, "changed")
    assert {(each["request"], each["change"]) for each in found["changes"]} == {("cabin.go", "newly rejected")}
    assert not any(each["shortest"] for each in found["changes"])
    assert {each["reason"] for each in found["unknown"]} == {"time limit of 600 s"}
    text = run("diff", tmp_path / "old.exo", tmp_path / "new.exo", "--timeout", "600").stdout
    _, _, unknown = text.partition("\nunknown, time limit of 600 s:\n  ")
    lines = unknown.partition("\n\n")[0].split("\n  ")
    assert lines[0] == "cabin.go newly launched, where OLD refuses it or lets it wait"
    assert len(lines) == len(set(lines)) == len(found["unknown"])


def test_what_costs_too_much_is_unknown_and_what_may_help_is_told(
    run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("exover.engines.aig.comparison.BUDGET", 0)
    monkeypatch.setattr("exover.engines.aig.comparison.ROUNDS", 0)
    (tmp_path / "old.exo").write_text(OLD)
    (tmp_path / "new.exo").write_text(OLD.replace("v <= 1", "v <= 0.5"))
    done = run("diff", tmp_path / "old.exo", tmp_path / "new.exo", "--abc", "none")
    assert done.returncode == 3
    assert "\nunknown, no answer after 0 propagations; with ABC more is answered: see `exover doctor`:\n" in done.stdout


def test_ctrl_c_ends_it(run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*asked: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("exover.checks.run.spread", interrupt)
    (tmp_path / "old.exo").write_text(OLD)
    (tmp_path / "lift.prop").write_text("for lift; property p: possible active(cabin.go);")
    done = run("diff", tmp_path / "old.exo", tmp_path / "old.exo", "--jobs", "1")
    assert (done.returncode, done.stdout) == (130, "")


@pytest.mark.parametrize("verb", ["diff", "report"])
def test_what_cannot_be_written_is_told_before_anything_is_looked_for(
    verb: str, run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("check", "diff"):
        monkeypatch.setattr(f"exover.cli.{module}.build", lambda *_: pytest.fail("the tables were made"))
    (tmp_path / "old.exo").write_text(OLD)
    (tmp_path / "file").touch()
    specs = [tmp_path / "old.exo"] * (1 + (verb == "diff"))
    for out, why in (("file/x", "Not a directory"), (".", "it is a directory"), ("x/", "is a folder")):
        done = run(verb, *specs, "--out", out)
        assert (done.returncode, done.stdout) == (2, "")
        assert why in done.stderr


def test_a_comment_has_no_markup_of_the_spec(run, tmp_path: Path) -> None:
    (tmp_path / "old.exo").write_text(OLD)
    (tmp_path / "new.exo").write_text(OLD.replace("v <= 1", 'v <= 0.5 because "```</details>"'))
    done = run("diff", tmp_path / "old.exo", tmp_path / "new.exo", "--format", "markdown", "--out", tmp_path / "c.md")
    assert (done.returncode, done.stdout) == (0, "")
    text = (tmp_path / "c.md").read_text()
    assert "cabin.go newly rejected" in text
    assert text.count("```") == 2 * text.count("<details>")


def test_markdown_is_escaped_where_it_is_read_alone(run, tmp_path: Path) -> None:
    named = OLD.replace("cabin", "cabin_1")
    (tmp_path / "old.exo").write_text(named)
    (tmp_path / "new.exo").write_text(named.replace("v <= 1", "v <= 0.5") + "poster low_1: bool = false;")
    text = run("diff", tmp_path / "old.exo", tmp_path / "new.exo", "--format", "markdown").stdout
    assert "<summary>cabin_1.go newly rejected" in text
    assert "> NEW alone has low\\_1:" in text


def test_sarif_is_valid(run, tmp_path: Path) -> None:
    (tmp_path / "old.exo").write_text(OLD)
    (tmp_path / "new.exo").write_text(HEAD)
    done = run("diff", tmp_path / "old.exo", tmp_path / "new.exo", "--format", "sarif")
    log = json.loads(done.stdout)
    jsonschema.validate(log, json.loads(SCHEMA.read_text()))
    assert {each["ruleId"] for each in log["runs"][0]["results"]} >= {"exover/diff/weaker"}
