"""What a command reads it never writes over."""

from pathlib import Path

import pytest

SPEC = "spec s; module m { request a(); request b(); } mutex m.a, m.b;"
LOCKING = (Path(__file__).parents[2] / "specs" / "violations" / "lockout.exo").read_text()
EVENTS = '{"ask": "m.a"}\n{"ask": "m.b"}\n'
PROPERTIES = "for s; property apart: never (active(m.a) and active(m.b));"
FILES = {"s.exo": SPEC, "t.exo": SPEC, "s.prop": PROPERTIES, "events.jsonl": EVENTS, "box.bin": "no box"}
FILES |= {"exover.toml": "", "base.json": "{}", "p.exo": 'spec p; include "q.exo"; module m { request a(); }'}
FILES |= {"q.exo": "part q;", "s.json": SPEC, "b.bin": "part q;"}
FILES |= {"b.exo": 'spec b; include "b.bin"; module m { request a(); }'}


@pytest.mark.parametrize(
    ("command", "output"),
    [
        ("graph s.exo --out s.exo", "s.exo"),
        ("graph s.exo --out ./link.exo", "./link.exo"),
        ("diff s.exo t.exo --out t.exo", "t.exo"),
        ("diff s.exo t.exo --properties s.prop --out s.prop", "s.prop"),
        ("swap s.exo t.exo --out t.exo", "t.exo"),
        ("audit s.exo t.exo events.jsonl --out events.jsonl", "events.jsonl"),
        ("import t.exo --out t.exo", "t.exo"),
        ("trace events.jsonl --out events.jsonl", "events.jsonl"),
        ("report s.exo --properties s.prop --out s.prop", "s.prop"),
        ("report s.exo --out s.exo", "s.exo"),
        ("report s.exo --out s.prop", "s.prop"),
        ("report s.exo --out exover.toml", "exover.toml"),
        ("report s.exo --baseline base.json --out base.json", "base.json"),
        ("report s.exo --config exover.toml --out exover.toml", "exover.toml"),
        ("check s.exo --output json=exover.toml", "exover.toml"),
        ("check s.exo t.exo --output json=exover.toml", "exover.toml"),
        ("check s.exo --certificate s.prop", "s.prop"),
        ("graph p.exo --out q.exo", "q.exo"),
        ("audit s.exo . --out events.jsonl", "events.jsonl"),
        ("emit s.json --target json --out .", "./s.json"),
        ("emit b.exo --unchecked --target c,bin --out .", "./b.bin"),
        ("replay box.bin s.exo --events box.bin", "box.bin"),
        ("gate mcp s.exo --bind s.prop --log s.exo -- true", "s.exo"),
        ("gate mcp s.exo --bind s.prop --log s.prop -- true", "s.prop"),
    ],
)
def test_what_is_read_is_not_written_over(run, tmp_path: Path, command: str, output: str) -> None:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "link.exo").symlink_to("s.exo")
    done = run(*command.split(), cwd=tmp_path)
    told = f"exover: error: {output} cannot be written over: the command reads it\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", told)
    assert {name: (tmp_path / name).read_text() for name in FILES} == FILES


def test_what_was_written_before_is_written_again(run, tmp_path: Path) -> None:
    (tmp_path / "s.exo").write_text(SPEC)
    for _ in range(2):
        done = run("graph", "s.exo", "--format", "dot", "--out", "s.dot", cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")


def test_the_spec_that_a_report_names_is_not_written_over(run, tmp_path: Path) -> None:
    (tmp_path / "locking.exo").write_text(LOCKING)
    (tmp_path / "r.json").write_text(run("check", "locking.exo", "--format", "json", cwd=tmp_path).stdout)
    done = run("trace", "r.json", "--check", "lockout", "--out", "locking.exo", cwd=tmp_path)
    told = "exover: error: locking.exo cannot be written over: the command reads it"
    assert (done.returncode, done.stdout, done.stderr.splitlines()[-1]) == (2, "", told)
    assert (tmp_path / "locking.exo").read_text() == LOCKING
