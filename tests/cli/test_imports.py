"""`exover import`: parts that are made of other descriptions, included and checked."""

import os
from pathlib import Path
from shutil import which

import pytest

ROOT = Path(__file__).resolve().parents[2]
ARM = ROOT / "tests" / "imports" / "arm" / "arm.gen"
RULES = """spec robot;

include "arm.exo";

mutex one: arm.home, arm.grasp because "one motion at a time";
context arm.release { check still: not active(arm.home); }
"""
ACTION = "bool fast\n---\nbool done\n---\n"


def test_a_description_is_imported_included_and_checked(run, tmp_path):
    done = run("import", ARM, "--out", "arm.exo")
    assert (done.returncode, done.stdout) == (0, "")
    assert f"exover: warning: {ARM}:44: port out `joint` is left out: a struct\n" in done.stderr
    assert done.stderr.count("exover: warning: ") == done.stderr.count("\n")
    text = (tmp_path / "arm.exo").read_text()
    assert text.startswith(
        "// Made by `exover import` of arm.gen; what it leaves open stands in comments.\npart arm;\n"
    )
    assert run("import", ARM, "--name", "arm").stdout == text
    assert run("fmt", "--check", "arm.exo").returncode == 0
    (tmp_path / "robot.exo").write_text(RULES)
    done = run("check", "robot.exo", "--errors-only")
    assert done.returncode in (0, 1) and done.stderr == ""
    assert "robot.exo: spec robot, 8 requests" in done.stdout
    assert run("check", "arm.exo").returncode == 2


def test_a_spec_of_ros_is_checked(run, tmp_path):
    folder = tmp_path / "dock" / "action"
    folder.mkdir(parents=True)
    (folder / "Dock.action").write_text(ACTION)
    (folder / "Undock.action").write_text(ACTION)
    files = [os.path.join("dock", "action", f"{name}.action") for name in ("Dock", "Undock")]
    done = run("import", "--ros", *files, "--spec", "--out", "docking.exo")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert "\nspec docking;\n" in (tmp_path / "docking.exo").read_text()
    assert run("check", "docking.exo").returncode == 0
    done = run("import", "--ros", *files, "--out", "docking.exo")
    (tmp_path / "robot.exo").write_text('spec robot; include "docking.exo"; mutex dock.dock, dock.undock;')
    done = run("check", "robot.exo")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["none.gen"], "cannot read none.gen"),
        (["-"], "name the file"),
        (["a.txt"], "name one .gen file"),
        (["a.gen", "b.gen"], "name one .gen file"),
        (["bad.gen"], "bad.gen:2:3: unexpected `bogus`"),
        (["--ros", "bad.gen"], "bad.gen: it is no file of ROS"),
        (["good.gen", "--name", "in"], "in is no name"),
        (["good.gen", "--name", "a-b"], "a-b is no name"),
        (["empty.gen", "--spec"], "empty.gen: spec `out` declares no request"),
        (["missing.gen"], "missing.gen: "),
    ],
)
def test_what_cannot_be_imported_is_an_error_and_nothing_is_written(run, tmp_path, arguments, said):
    (tmp_path / "a.txt").write_text("")
    (tmp_path / "b.gen").write_text("")
    (tmp_path / "a.gen").write_text("")
    (tmp_path / "bad.gen").write_text("component c {\n  bogus;\n};")
    (tmp_path / "good.gen").write_text("component c { activity a(); };")
    (tmp_path / "empty.gen").write_text("component c { };")
    (tmp_path / "missing.gen").write_text('#include "/nowhere/x.gen"\ncomponent c { };')
    done = run("import", *arguments, "--out", "out.exo")
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert not (tmp_path / "out.exo").exists()


def test_an_empty_component_is_a_part(run, tmp_path):
    (tmp_path / "empty.gen").write_text("component c { };")
    assert run("import", "empty.gen").stdout.endswith("part empty;\n\nmodule c {}\n")


@pytest.mark.skipif(not any(map(which, ("cpp", "gcc", "clang"))), reason="there is no C preprocessor")
def test_a_file_that_is_included_is_not_written_over(run, tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "b.h").write_text("")
    (tmp_path / "a.gen").write_text('#include "parts/b.h"\ncomponent c { activity a(); };')
    done = run("import", "a.gen", "--out", "parts/b.h")
    assert (done.returncode, (tmp_path / "parts" / "b.h").read_text()) == (2, "")
    assert "parts/b.h cannot be written over: the command reads it" in done.stderr
    assert run("import", "a.gen", "--out", "parts/c.exo").returncode == 0


@pytest.mark.parametrize("name", ["a\nmodule evil { request z(); }", "a\rb", "a\x1b[2Jb", "a\u2028b"])
def test_a_name_with_control_characters_stays_in_its_comment(run, tmp_path, name):
    (tmp_path / f"{name}.gen").write_text("component c { activity a(); };")
    done = run("import", f"{name}.gen", "--name", "a", "--out", "a.exo")
    assert (done.returncode, done.stderr) == (0, "")
    first, second, *_ = (tmp_path / "a.exo").read_text().splitlines()
    assert (first.isprintable(), second) == (True, "part a;")
