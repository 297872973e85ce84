"""Every kind of bad input: a clear message that names the place, status 2, no traceback, nothing on standard output."""

import errno
import os
import subprocess
import sys

import pytest

from exover.cli import files
from exover.cli.arguments import parser
from exover.ocrd import roots
from exover.syntax import parse
from tests.support.command import environment

VERBS: list[tuple[str, ...]] = [("check",), ("simulate",), ("emit", "--target", "c", "--out", "out")]


def refused(done: "subprocess.CompletedProcess[str]", *needles: str) -> None:
    assert done.returncode == 2, done
    assert not done.stdout
    assert "Traceback" not in done.stderr
    for needle in needles:
        assert needle in done.stderr


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb[0])
def test_no_verb_reads_what_is_no_spec(verb, run, spec):
    refused(run(*verb, "no.exo"), "error[E001]", "exover: error: cannot read no.exo: No such file or directory")
    spec.write_text(spec.read_text().replace("nd.stop over", "nd.stp over"))
    refused(run(*verb, "demo.exo"), "error[E203]", "--> demo.exo:4:14", "nd.stp over", "did you mean `", "^^^")


def test_paths_that_are_no_files(run, spec, tmp_path):
    refused(run("simulate", tmp_path), f"exover: error: cannot read {tmp_path}: Is a directory")
    refused(run("check", spec / "x.exo"), "cannot read", "Not a directory")
    refused(run("check", "/dev/zero"), "error[E003]", "--> /dev/zero")


@pytest.mark.parametrize("verb", ["replay", "verify"])
def test_what_is_too_large_is_not_read_in_part(run, spec, tmp_path, verb, monkeypatch):
    monkeypatch.setattr(files, "MOST_BYTES", 100)
    (tmp_path / "x.bin").write_bytes(bytes(101))
    words = ("replay", "x.bin", "demo.exo") if verb == "replay" else ("verify", "x.bin", "--spec", "demo.exo")
    refused(run(*words), "exover: error: cannot read x.bin: it is larger than 100 bytes")


@pytest.mark.parametrize(
    "words",
    [
        ("explain", "--finding"),
        ("trace",),
        ("check", "demo.exo", "--baseline"),
        ("report", "demo.exo", "--out", "x.html", "--audit"),
    ],
    ids=lambda words: words[0],
)
def test_no_report_is_read_without_an_end(run, spec, words, monkeypatch):
    monkeypatch.setattr(files, "MOST_BYTES", 100)
    refused(run(*words, "/dev/zero"), "exover: error: cannot read /dev/zero: it is larger than 100 bytes")


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_unreadable(run, spec):
    spec.chmod(0)
    refused(run("check", spec), f"cannot read {spec}: Permission denied")


@pytest.mark.parametrize(
    ("command", "counts"), [(("check", "."), ""), (("fmt", "."), "1 file left unchanged, 1 that cannot be read")]
)
def test_a_folder_that_cannot_be_read_is_not_passed_over(run, spec, monkeypatch, command, counts):
    run("fmt", spec)
    (spec.parent / "locked").mkdir()
    real = os.scandir

    def scandir(path):
        if os.path.basename(path) == "locked":
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)
        return real(path)

    monkeypatch.setattr(os, "scandir", scandir)
    refused(run(*command), "exover: error: cannot read ./locked: Permission denied\n", counts)


def test_what_is_passed_on_may_be_empty():
    given = parser().parse_args(["gate", "mcp", "a", "--bind", "b", "--", "server", ""])
    assert given.server == ["server", ""]
    given = parser().parse_args(["gate", "ros2", "a", "--bind", "b", "--decisions", ""])
    assert given.decisions == ""


@pytest.mark.parametrize(
    ("content", "needles"),
    [
        (b"", ("error[E004]", "a.exo:1:1")),
        (bytes(range(256)) * 40, ("error[E002]", "--> a.exo", "exover: error: cannot read a.exo")),
        (b"spec a; forbid " + b"(" * 10_000 + b"true" + b")" * 10_000, ("error[E109]", "a.exo:1:")),
        (b"spec a; module m { request r(); }\n" + b"mutex m.r, m.r;\n" * 2_000, ("error[E003]", "a.exo:1111:14")),
    ],
    ids=["empty", "binary", "nested", "large"],
)
def test_files_that_are_no_specs(run, tmp_path, content, needles, monkeypatch):
    assert parse.MAX_TOKENS == 500_000  # to read so many takes seconds
    monkeypatch.setattr(parse, "MAX_TOKENS", 10_000)
    (tmp_path / "a.exo").write_bytes(content)
    refused(run("check", "a.exo"), *needles)


def test_a_name_of_a_file_begins_no_line(run, tmp_path):
    name = "a\nexover: error: forged.exo"
    for done in (run("check", name), run("trace", name), run("fmt", "--check", name)):
        refused(done)
        assert sum(line.startswith("exover: error: ") for line in done.stderr.split("\n")) == 1
    (tmp_path / name).write_text("spec s; nonsense;")
    done = run("check", name)
    refused(done)
    assert not any(line.startswith("exover: error: forged") for line in done.stderr.split("\n"))


def test_no_folder_stands_for_standard_input(run, spec, tmp_path):
    (tmp_path / "-").mkdir()
    done = run("check", "-", input=spec.read_text())
    assert done.stdout.startswith("<stdin>: spec demo") and done.returncode == 0
    assert run("fmt", "-", input="spec s;module m{request a();}").stdout.startswith("spec s;\n")


def test_control_characters_do_not_reach_the_terminal(run, tmp_path):
    (tmp_path / "\x1b[2J.exo").write_text("spec \x1b[31m;")
    done = run("check", "\x1b[2J.exo")
    refused(done, "error[E")
    assert "\x1b" not in done.stderr


def test_the_names_of_files_in_answers_do_not_control_the_terminal(run, tmp_path):
    name = "a\n\x1b[2J"
    (tmp_path / f"{name}.exo").write_text("spec s; module m { request a(); }")
    (tmp_path / f"{name}.toml").write_text('gate = { spec = "s", start = "idle" }\n[request."m.a"]\ntool = "a"\n')
    assert run("emit", f"{name}.exo", "--target", "bin", "--out", ".").returncode == 0
    (tmp_path / "s.bin").rename(tmp_path / f"{name}.bin")
    for done in (
        run("verify", f"{name}.bin", "--spec", f"{name}.exo"),
        run("gate", "check", f"{name}.exo", "--bind", f"{name}.toml"),
        run("swap", f"{name}.exo", f"{name}.exo", "--out", "map"),
    ):
        assert done.returncode == 0, done
        assert "\x1b" not in done.stdout and "a\ufffd\ufffd[2J." in done.stdout


@pytest.mark.parametrize(
    ("arguments", "needle"),
    [
        ((), "VERB"),
        (("fly",), "invalid choice: 'fly'"),
        (("swap", "a", "b", "c", "--out", "d"), "unrecognized arguments: c\n"),
        (("check", "a", "--format", "xml"), "invalid choice: 'xml'"),
        (("check", "a", "--time"), "--time"),
        (("check", "a", "--deny", "notes"), "invalid choice: 'notes'"),
        (("simulate", "a", "--engine", "steam"), "invalid choice: 'steam'"),
        (("check",), "SPEC"),
        (("emit", "a", "--out", "x"), "--target"),
        (("emit", "a", "--target", "c"), "--out"),
        (("emit", "a", "--target", "c", "--out", ""), "argument --out: the value is empty"),
        (("check", ""), "argument SPEC: the value is empty"),
        (("check", "a", "--certificate", ""), "argument --certificate: the value is empty"),
        (("audit", "a", "b", "--bind="), "argument --bind: the value is empty"),
        (("graph", "a", "--only", "excludes,foo"), "invalid choice: 'foo' (choose from "),
        (("emit", "a", "--target", "pdf", "--out", "x"), "invalid choice: 'pdf'"),
    ],
)
def test_usage(run, arguments, needle):
    refused(run(*arguments), "usage: exover", needle)


@pytest.mark.parametrize(
    ("arguments", "usage", "needle"),
    [
        (("check", "a", "--fromat", "json"), "check", "unrecognized arguments: --fromat; did you mean `--format`?"),
        (("check", "a", "--fromat=json"), "check", "unrecognized arguments: --fromat=json; did you mean `--format`?"),
        (("check", "--count", "-", "--xyzzy"), "check", "unrecognized arguments: --xyzzy\n"),
        (("emit", "a", "--taget", "c", "--out", "x"), "emit", "did you mean `--target`?"),
        (("simulate", "a", "b"), "simulate", "unrecognized arguments: b; did you mean `--events b`?"),
        (("explain", "a", "b"), "explain", "unrecognized arguments: b; did you mean `--events b`?"),
        (
            ("check", "a", "--count", "b"),
            "check",
            "unrecognized arguments: b; write all of SPEC together, with no option between them",
        ),
        (("simulate", "a", "--engine", "rusty"), "simulate", "did you mean `rust`?"),
        (("--verison",), "[-h]", "unrecognized arguments: --verison; did you mean `--version`?"),
        (("chek", "a"), "[-h]", "did you mean `check`?"),
        (("help", "chek"), "help", "did you mean `check`?"),
    ],
)
def test_what_was_meant_is_said_under_the_usage_of_the_verb(run, arguments, usage, needle):
    done = run(*arguments)
    refused(done, needle)
    assert done.stderr.startswith(f"usage: exover {usage}")


def test_help_of_a_verb(run):
    for arguments in ((), ("check",), ("help",)):
        asked, told = run("help", *arguments), run(*arguments, "--help")
        assert (asked.returncode, asked.stderr, asked.stdout) == (0, "", told.stdout)


def test_a_spec_from_standard_input(run, spec):
    done = run("check", "-", input=spec.read_text())
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("<stdin>: spec demo, 2 requests, 1 rule\nproperties: none")
    refused(run("check", "-", input="spec demo"), "error[E107]", "--> <stdin>:1:10", "error: <stdin> has a mistake")
    refused(run("check", "-", stdin=None, preexec_fn=lambda: os.close(0)), "cannot read standard input: it is closed")
    assert run("emit", "-", "--target", "bin", "--out", "out", input=spec.read_text()).stdout == "out/demo.bin\n"


def test_standard_input_is_read_once(run, spec):
    for command in (
        *("check - --properties -", "check - --config -", "check - --baseline -", "check - -", "fmt - -"),
        *("simulate -", "explain -", "trace - --spec -", "swap - - --out map", "gate check - --bind -"),
        *("verify - --table -", "verify - --spec -", "diff - -", "diff - demo.exo --properties -"),
        *("diff demo.exo demo.exo --properties -", "audit - -", "report - --audit - --out r.html", "replay - -"),
    ):
        refused(run(*command.split(), input=spec.read_text()), "only one thing can be read from standard input")


def test_standard_input_is_checked_alone(run, spec):
    for form in ("text", "junit"):
        done = run("check", "-", spec.name, "--format", form, input=spec.read_text())
        refused(done, "standard input is checked alone: name no other spec beside -")


def test_standard_input_is_no_output(run, spec):
    for command in (
        *("graph demo.exo --out -", "report demo.exo --out -", "check demo.exo --certificate -"),
        *("emit demo.exo --target bin --out -", "replay box --events -", "gate mcp demo.exo --bind b --log - -- cat"),
    ):
        refused(run(*command.split()), "- is standard input, and no file to write; ./- is a file of that name")
    assert not (spec.parent / "-").exists()


def test_standard_input_bears_its_name(run, spec):
    run("emit", "demo.exo", "--target", "bin", "--out", ".")
    done = run("verify", "demo.bin", "--spec", "-", input=spec.read_text())
    assert done.stdout.endswith("decides as <stdin> says\n")
    run("check", "demo.exo", "--certificate", "demo.cert")
    done = run("verify", "demo.cert", "--table", "demo.bin", "--spec", "-", input=spec.read_text())
    told = "demo.bin: in every state and for all arguments it decides as <stdin> says"
    assert (done.returncode, done.stdout.splitlines()[0]) == (0, told)
    refused(run("trace", "-", input="{"), "cannot use <stdin>: it is not JSON")
    refused(run("check", "demo.exo", "--baseline", "-", input="{"), "cannot use <stdin>: it is not JSON")
    refused(run("check", "demo.exo", "--config", "-", input="{"), "error: <stdin> has a mistake")


def test_help_and_version(run):
    for arguments in (("--help",), ("check", "-h"), ("simulate", "-h"), ("emit", "-h")):
        done = run(*arguments)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith("usage: exover")
    import exover

    for option in ("-V", "--version"):
        assert run(option).stdout == f"exover {exover.__version__}\n"


def test_events_that_cannot_be_read(run, spec, tmp_path):
    refused(run("simulate", spec, "--events", "no.jsonl"), "cannot read no.jsonl: No such file or directory")
    refused(run("simulate", spec, "--events", tmp_path), f"cannot read {tmp_path}: Is a directory")
    refused(run("simulate", spec, stdin=None, preexec_fn=lambda: os.close(0)), "cannot read standard input")


def test_output_that_cannot_be_written(run, spec):
    with open("/dev/full", "w") as full:
        for arguments in (("--help",), ("help",), ("-V",), ("simulate", spec), ("check", spec)):
            done = run(*arguments, stdout=full, input='{"ask": "nd.stop"}\n')
            assert done.returncode == 2
            assert done.stderr == "exover: error: cannot write to standard output: No space left on device\n"


def test_output_that_nobody_reads(run, spec):
    for arguments in (("--help",), ("simulate", spec)):
        read, write = os.pipe()
        os.close(read)
        done = run(*arguments, stdout=write, input='{"ask": "nd.stop"}\n' * 3)
        os.close(write)
        assert (done.returncode, done.stderr) == (0, "")


def test_output_that_is_closed(run, spec):
    for arguments in (("simulate", spec), ("help",), ("check", "--help"), ("-V",)):
        done = run(*arguments, stdout=None, input='{"ask": "nd.stop"}\n', preexec_fn=lambda: os.close(1))
        assert done.returncode == 2
        assert done.stderr == "exover: error: cannot write to standard output: it is closed\n"


@pytest.mark.parametrize(
    "verb", [("check",), ("emit", "--unchecked", "--target", "bin", "--out", "."), ("diff", "demo.exo")]
)
def test_tables_that_are_too_large_are_refused(run, spec, monkeypatch, verb):
    monkeypatch.setattr(roots, "MOST_NODES", 4)
    refused(run(*verb, "demo.exo"), "exover: error: demo.exo:", "tell too many cases apart (more than 4 nodes)")


@pytest.mark.parametrize("fault", ["RecursionError('too\\ndeep')", "KeyError('nd.goto')"])
def test_a_fault_of_ours_is_status_4(fault):
    program = f"""
import sys, types, exover.cli.main as main

def run(arguments):
    raise {fault}

main.import_module = lambda name: types.SimpleNamespace(run=run)
sys.exit(main.main(["check", "a.exo"]))
"""
    for debug in ("0", "1"):
        done = subprocess.run(
            [sys.executable, "-c", program],
            capture_output=True,
            text=True,
            env=environment(EXOVER_DEBUG=debug),
            check=False,
        )
        assert (done.returncode, done.stdout) == (4, "")
        assert done.stderr.splitlines()[-1].startswith(f"exover: internal fault: {fault.split('(')[0]}")
        assert "please report" in done.stderr
        assert ("Traceback" in done.stderr) == (debug == "1")
