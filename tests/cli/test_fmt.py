"""`exover fmt` as a process."""

import os
import socket
from contextlib import chdir
from unittest.mock import patch

from exover.cli.status import CliError

UGLY = "spec s;module m{request a();request b();}mutex m.a,m.b;"
NEAT = "spec s;\n\nmodule m {\n    request a();\n    request b();\n}\n\nmutex m.a, m.b;\n"
PROPERTIES = "for s;\n\nproperty p: never active(m.a);\n"


def test_files_are_written_and_told(run, tmp_path):
    (tmp_path / "deep" / "er").mkdir(parents=True)
    (tmp_path / ".hidden").mkdir()
    ugly, neat, hidden = tmp_path / "deep" / "er" / "u.exo", tmp_path / "n.prop", tmp_path / ".hidden" / "h.exo"
    ugly.write_text(UGLY)
    hidden.write_text(UGLY)
    neat.write_text(PROPERTIES)
    (tmp_path / "notes.txt").write_text(UGLY)
    checked = run("fmt", "--check")
    assert (checked.returncode, ugly.read_text()) == (1, UGLY)
    assert checked.stdout == f"{os.path.join('deep', 'er', 'u.exo')} would be reformatted\n"
    done = run("fmt")
    assert (done.returncode, ugly.read_text(), neat.read_text(), hidden.read_text()) == (0, NEAT, PROPERTIES, UGLY)
    assert done.stdout == f"{os.path.join('deep', 'er', 'u.exo')} reformatted\n"
    assert done.stderr == "1 file left unchanged, 1 file reformatted\n"
    again = run("fmt", "--check", "deep", "n.prop")
    assert (again.returncode, again.stdout, again.stderr) == (0, "", "2 files left unchanged\n")


def test_what_is_wrong_is_left_and_keeps_no_other_back(run, tmp_path):
    (tmp_path / "bad.exo").write_text("spec s; mutex a b;")
    (tmp_path / "good.exo").write_text(UGLY)
    done = run("fmt", "bad.exo", "missing.exo", "good.exo")
    assert done.returncode == 2
    assert "bad.exo:1:17" in done.stderr and "missing.exo" in done.stderr
    assert done.stderr.endswith("\n1 file reformatted, 1 that cannot be read or written, 1 with mistakes\n")
    assert (tmp_path / "bad.exo").read_text() == "spec s; mutex a b;"
    assert (tmp_path / "good.exo").read_text() == NEAT


def test_standard_input(run):
    assert run("fmt", "-", input=UGLY).stdout == NEAT
    assert run("fmt", "-", input="for s;property p:never active(m.a);").stdout == PROPERTIES
    checked = run("fmt", "--check", "-", input=UGLY)
    assert (checked.returncode, checked.stdout) == (1, "")
    assert run("fmt", "--check", "-", input=NEAT).returncode == 0
    wrong = run("fmt", "-", input="spec")
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert "--> <stdin>:1:5" in wrong.stderr and "<stdin> has a mistake\n" in wrong.stderr


def test_standard_output_that_cannot_be_written_is_no_mistake_of_a_text(run):
    reason = "cannot write to standard output: No space left on device"
    with patch("exover.cli.fmt.out", side_effect=CliError(reason)):
        done = run("fmt", "-", input=UGLY)
    assert (done.returncode, done.stderr) == (2, f"exover: error: {reason}\n")


def test_links_are_followed_and_permissions_kept(run, tmp_path):
    real, link = tmp_path / "real.exo", tmp_path / "link.exo"
    real.write_text(UGLY)
    real.chmod(0o640)
    link.symlink_to(real)
    assert run("fmt", "link.exo").returncode == 0
    assert link.is_symlink() and real.read_text() == NEAT and real.stat().st_mode & 0o777 == 0o640


def test_what_is_no_regular_file_in_a_folder_is_passed_over(run, tmp_path):
    """As by `check` and `audit`. A socket stands for a pipe, which would be waited for without an end."""
    (tmp_path / "link.exo").symlink_to("gone.exo")
    (tmp_path / "s.exo").write_text(UGLY)
    with socket.socket(socket.AF_UNIX) as end, chdir(tmp_path):
        end.bind("socket.exo")
    done = run("fmt", ".")
    assert (done.returncode, done.stdout) == (0, "s.exo reformatted\n")
    told = [f"exover: note: {name}.exo is passed over: it is no regular file" for name in ("link", "socket")]
    assert done.stderr.splitlines() == [*told, "1 file reformatted"]


def test_a_pipe_is_refused(run, tmp_path):
    os.mkfifo(tmp_path / "pipe.exo")
    done = run("fmt", "pipe.exo")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("exover: error: pipe.exo is no regular file; - formats standard input\n")


def test_a_folder_without_specs(run):
    done = run("fmt")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "no .exo or .prop file found\n")


def test_line_ends_and_marks_are_made_alike(run, tmp_path):
    path = tmp_path / "s.exo"
    path.write_bytes(b"\xef\xbb\xbf" + NEAT.replace("\n", "\r\n").encode())
    assert run("fmt", "s.exo").returncode == 0
    assert path.read_bytes() == NEAT.encode()
