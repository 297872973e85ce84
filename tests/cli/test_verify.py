"""`exover check --certificate` and `exover verify` as processes."""

import json
import os
import shutil
from shutil import which

import pytest

from exover.cli.main import main
from exover.limits import TimeUp
from tests.cli.specs import SPEC
from tests.support.command import Run


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return a folder with a certificate of a spec, and its tables."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "demo.exo").write_text(SPEC)
    done = Run(folder)("check", "demo.exo", "--certificate", "demo.cert")
    assert (done.returncode, done.stderr) == (0, "")
    assert Run(folder)("emit", "demo.exo", "--target", "bin", "--out", "out").returncode == 0
    return folder


@pytest.fixture
def certified(made, spec, tmp_path):
    """Return a spec beside which its certificate is, and its tables."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    return spec


def test_a_certificate_is_written_and_verified(run, certified, tmp_path):
    found = json.loads((tmp_path / "demo.cert").read_text())
    assert found["spec"] == "demo"
    done = run("verify", "demo.cert", "--spec", certified)
    assert (done.returncode, done.stdout) == (2, "")
    assert "demo.cert is a certificate, which needs the tables that it is about: add --table TABLE" in done.stderr
    done = run("verify", "demo.cert", "--table", "out/demo.bin")
    assert (done.returncode, done.stderr) == (0, "")
    assert "demo.cert: " in done.stdout
    assert "--spec tells" in done.stdout
    done = run("verify", "demo.cert", "--table", "out/demo.bin", "--spec", certified)
    assert (done.returncode, done.stderr) == (0, "")
    assert "its claims are those of the spec" in done.stdout
    assert "\ntables" not in done.stdout


def changed(file, change):
    """Write a certificate anew of which each finding has been changed."""
    found = json.loads(file.read_text())
    for each in found["findings"]:
        change(each)
    file.write_text(json.dumps(found))


def test_what_the_spec_proves_of_the_tables_is_what_the_certificate_says(run, certified, tmp_path):
    changed(tmp_path / "demo.cert", lambda each: each["check"] == "tables" and each.update(verdict="unknown"))
    done = run("verify", "demo.cert", "--table", "out/demo.bin", "--spec", certified)
    assert done.returncode == 0
    assert "\ntables" in done.stdout
    changed(tmp_path / "demo.cert", lambda each: each["check"] == "tables" and each.update(verdict="violated"))
    done = run("verify", "demo.cert", "--table", "out/demo.bin", "--spec", certified)
    assert done.returncode == 1
    assert "demo.cert is refused: tables " in done.stderr
    assert "it says violated, and it is proved that it holds" in done.stderr


def test_what_a_certificate_says_does_not_control_a_terminal(run, certified, tmp_path):
    changed(tmp_path / "demo.cert", lambda each: each.update(proof={"kind": "none", "reason": "\x1b[2Jtrust me"}))
    done = run("verify", "demo.cert", "--table", "out/demo.bin")
    assert done.returncode == 0 and "no proof: \ufffd[2Jtrust me\n" in done.stdout


def test_strict_asks_for_the_proof_of_what_holds(run, certified, tmp_path):
    verify = ("verify", "demo.cert", "--table", "out/demo.bin")
    done = run(*verify, "--spec", certified, "--strict")
    assert (done.returncode, done.stderr) == (0, "")
    done = run(*verify, "--strict")
    assert done.returncode == 1
    assert "demo.cert says without proof that these hold: tables " in done.stderr
    none = {"kind": "none", "reason": "lost"}
    changed(tmp_path / "demo.cert", lambda each: each.update(proof=none))
    assert run(*verify, "--spec", certified).returncode == 0
    done = run(*verify, "--spec", certified, "--strict")
    assert done.returncode == 1
    assert "safety " in done.stderr
    assert "rule-use " not in done.stderr
    assert "tables " not in done.stderr


def test_a_certificate_for_which_there_is_no_time_is_not_written(spec, tmp_path, monkeypatch, capsys):
    def too_slow(*_):
        raise TimeUp

    monkeypatch.setattr("exover.cli.check.certify", too_slow)
    file = tmp_path / "demo.cert"
    assert main(["check", str(spec), "--certificate", str(file), "--timeout", "60"]) == 3
    assert f"{file} is not written" in capsys.readouterr().err
    assert not file.exists()


def test_a_certificate_of_another_table_is_refused(run, certified, tmp_path):
    certified.write_text(certified.read_text().replace("battery", "charge"))
    assert run("emit", certified, "--target", "bin", "--out", "out").returncode == 0
    done = run("verify", "demo.cert", "--table", "out/demo.bin")
    assert done.returncode == 1
    assert done.stderr == "exover: error: demo.cert is refused: the certificate is about another table\n"


def test_what_cannot_be_read_is_the_users_mistake(run, spec, tmp_path):
    assert run("emit", spec, "--target", "bin", "--out", "out").returncode == 0
    (tmp_path / "bad.cert").write_text("{")
    for arguments, said in (
        (("bad.cert", "--table", "out/demo.bin"), "bad.cert cannot be read as a certificate: it is not JSON"),
        (("gone.cert", "--table", "out/demo.bin"), "cannot read gone.cert"),
        (("bad.cert", "--table", "gone.bin"), "cannot read gone.bin"),
        (("out/demo.bin",), "add --table TABLE"),
        (("gone.c", "--spec", "demo.exo"), "cannot read gone.c"),
        (("out/demo.bin", "--spec", "gone.exo"), "cannot read gone.exo"),
    ):
        done = run("verify", *arguments)
        assert done.returncode == 2, done.stdout
        assert said in done.stderr


def test_bytes_and_c_sources_are_the_rules(run, spec, tmp_path):
    for target in ("bin", "c"):
        assert run("emit", spec, "--target", target, "--out", "out").returncode == 0
    for file in ("out/demo.bin", "out/demo_tables.c"):
        done = run("verify", file, "--spec", spec)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout == f"{file}: in every state and for all arguments it decides as {spec} says\n"
    source = tmp_path / "out" / "demo_tables.c"
    source.write_text(source.read_text().replace("    -1, 0, -1, 0,\n", "    -2, 0, -1, 0,\n", 1))
    done = run("verify", "out/demo_tables.c", "--spec", spec)
    assert done.returncode == 1
    assert "out/demo_tables.c: " in done.stdout
    source.write_text("const exover_tables demo_tables = oh;\n")
    done = run("verify", "out/demo_tables.c", "--spec", spec)
    assert done.returncode == 2
    assert "cannot compile out/demo_tables.c" in done.stderr


@pytest.mark.skipif(which("rustc") is None, reason="rustc is not installed")
def test_a_rust_source_is_the_rules(run, spec, tmp_path):
    assert run("emit", spec, "--target", "rust", "--out", "out").returncode == 0
    file = os.path.join("out", "src", "tables.rs")
    done = run("verify", file, "--spec", spec)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"{file}: in every state and for all arguments it decides as {spec} says\n"
    source = tmp_path / file
    source.write_text(source.read_text().replace("NodeRow([", "NodeRow([1 + ", 1))
    done = run("verify", file, "--spec", spec)
    assert (done.returncode, done.stdout) == (1, f"{file}: the checksum of the table is wrong\n")


def test_a_certificate_is_not_written_over_the_spec(run, spec):
    before = spec.read_text()
    done = run("check", spec, "--certificate", spec)
    assert done.returncode == 2
    assert spec.read_text() == before
    assert run("check", spec, "--certificate", os.path.join("no", "where", "x"), "--deny", "warnings").returncode == 0
