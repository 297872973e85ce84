"""The library beyond the examples of docs/library.md: what it refuses, and that importing it costs nothing."""

import subprocess
import sys
from pathlib import Path

import pytest

import exover
from exover.syntax.decode import MAX_BYTES
from tests.runtime.compiling import ROOT
from tests.support.command import Run

MUTEX = "module m { request a(); request b(); } mutex m.a, m.b;"
WRONG = f"spec wrong; {MUTEX} poster p: bool = false; forbid f: active(m.a) and p;"


def modules_after(statement: str) -> set[str]:
    code = f"{statement}; import sys; print(*[m for m in sys.modules if m.startswith('exover.')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_importing_it_imports_nothing_else() -> None:
    assert modules_after("import exover; exover.__version__") == set()
    assert "exover.library" in modules_after("import exover; exover.load")
    assert "exover.library" not in modules_after("import exover.cli.main")


def test_every_name_is_there_and_no_other() -> None:
    for name in exover.__all__:
        assert getattr(exover, name) is not None
    assert set(exover.__all__) <= set(dir(exover))
    with pytest.raises(AttributeError, match="no attribute 'chek'"):
        exover.chek  # type: ignore[attr-defined]  # noqa: B018


def test_files_that_are_no_text() -> None:
    with pytest.raises(FileNotFoundError):
        exover.load("nothing.exo")


def test_bytes_that_are_no_text(tmp_path: Path) -> None:
    (tmp_path / "s.exo").write_bytes(b"spec \xff;")
    with pytest.raises(exover.SpecError, match="no UTF-8") as caught:
        exover.load(tmp_path / "s.exo")
    assert [diagnostic.code for diagnostic in caught.value.diagnostics] == ["E002"]


def test_properties_are_read_and_their_mistakes_told(tmp_path: Path) -> None:
    spec = exover.loads(f"spec s; {MUTEX}")
    (tmp_path / "s.prop").write_text("for s;\nproperty never_a: never active(m.a);\n")
    found = exover.check(spec, exover.load_properties(tmp_path / "s.prop", spec))
    assert found.verdict == "violated" and [finding.subject for finding in found.of("property")] == ["never_a"]
    (tmp_path / "s.prop").write_text("for s;\nproperty p: never active(m.c);\n")
    with pytest.raises(exover.SpecError, match=r"m\.c"):
        exover.load_properties(tmp_path / "s.prop", spec)


def test_the_properties_of_a_file_are_found(tmp_path: Path) -> None:
    (tmp_path / "s.exo").write_text(f"spec s; {MUTEX}")
    (tmp_path / "properties").mkdir()
    (tmp_path / "properties" / "s.prop").write_text("for s;\nproperty never_a: never active(m.a);\n")
    spec = exover.load(tmp_path / "s.exo")
    assert exover.check(spec).verdict == "violated"
    assert exover.check(spec, exover.NO_PROPERTIES).verdict == "holds"
    (tmp_path / "s.prop").write_text("for s;\n")
    with pytest.raises(ValueError, match="2 properties files"):
        exover.check(spec)


def test_findings_render_as_the_command_prints_them(run: Run) -> None:
    path = ROOT / "specs" / "violations" / "obligation.exo"
    printed = run("check", path, "--format", "json")
    assert exover.check(exover.load(path)).render("json") == printed.stdout and printed.returncode == 1


def test_tables_are_marked_as_checked_only_by_findings_that_hold() -> None:
    spec, wrong = exover.loads(f"spec s; {MUTEX}"), exover.loads(WRONG)
    found = exover.check(wrong)
    assert found.verdict == "violated"
    with pytest.raises(ValueError, match="violated"):
        exover.compile(wrong, found)
    with pytest.raises(ValueError, match="not the findings of s"):
        exover.compile(spec, found)
    assert exover.compile(spec).unchecked and not exover.compile(spec, exover.check(spec)).unchecked


def test_tables_of_another_spec_and_damaged_ones_are_refused(tmp_path: Path) -> None:
    spec, other = exover.loads(f"spec s; {MUTEX}"), exover.loads(WRONG)
    data = exover.compile(spec).data
    with pytest.raises(exover.TablesError, match="not the tables of wrong"):
        exover.load_tables(data, other)
    with pytest.raises(exover.TablesError, match="checksum"):
        exover.load_tables(data[:-1] + bytes([data[-1] ^ 1]), spec)
    with pytest.raises(FileNotFoundError):
        exover.load_tables(tmp_path / "s.bin", spec)


def test_what_is_no_event_is_answered_so() -> None:
    spec = exover.loads(f"spec s; {MUTEX}")
    for checker in (spec, exover.compile(spec)):
        invalid, launched = exover.simulate(checker, ["no event", {"ask": "m.a"}])
        assert invalid.event == invalid.actions[0] and isinstance(invalid.event, exover.Invalid)
        assert launched == exover.Answer(exover.Ask("m.a"), (exover.Launched("m.a", 0, ()),), launched.line)


def test_a_byte_order_mark_is_skipped_as_in_files() -> None:
    spec = exover.loads(f"\ufeffspec s; {MUTEX}")
    (launched,) = exover.simulate(spec, ['\ufeff{"ask": "m.a"}'])
    assert launched.event == exover.Ask("m.a")


@pytest.mark.parametrize(("text", "code"), [(" " * MAX_BYTES, "E003"), ("// \ud800", "E002")], ids=["E003", "E002"])
def test_a_text_that_no_file_could_hold_is_refused_as_one(text: str, code: str) -> None:
    with pytest.raises(exover.SpecError) as refused:
        exover.loads(f"spec s; {MUTEX}{text}")
    assert [each.code for each in refused.value.diagnostics] == [code]


@pytest.mark.parametrize("line", ["\v", "\f", "\x1c", "\x85", "\u00a0", "\u3000"])
def test_a_line_of_characters_that_show_nothing_is_blank_neither_as_text_nor_as_bytes(line: str) -> None:
    spec = exover.loads(f"spec s; {MUTEX}")
    for lines in (["", " \t\r\n", line], [b"", b" \t\r\n", line.encode()]):
        (answer,) = exover.simulate(spec, lines)
        assert isinstance(answer.event, exover.Invalid) and answer.event.code == "bad-event"


def test_a_text_is_not_taken_for_its_lines() -> None:
    with pytest.raises(TypeError, match="splitlines"):
        exover.simulate(exover.loads(f"spec s; {MUTEX}"), '{"ask": "m.a"}')  # type: ignore[arg-type]


def test_what_there_is_not_is_refused_with_what_there_is() -> None:
    spec = exover.loads("spec s; module m { request a(); }")
    with pytest.raises(ValueError, match=r"there is no engine 'zz': it is one of reference, tables, c, rust"):
        exover.simulate(spec, [], "zz")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"there is no format 'zz': it is one of text, json"):
        exover.check(spec).render("zz")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"there is no target 'zz': it is one of c, rust, bin"):
        exover.compile(spec).files("zz")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"write \[event\] for a single one"):
        exover.simulate(spec, {"ask": "m.a"})  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="a spec is a text"):
        exover.loads(b"spec s;")  # type: ignore[arg-type]


def test_a_time_limit_leaves_unknown_what_has_no_answer() -> None:
    spec = exover.load(ROOT / "tests" / "specs" / "surgical_arm.exo")
    try:
        found = exover.check(spec, timeout=0.5)
    except TimeoutError as reason:
        assert "0.5 s" in str(reason)
    else:
        assert "unknown" in {finding.verdict for finding in found}
    with pytest.raises(TimeoutError, match="before the tables"):
        exover.check(spec, timeout=0.001)


@pytest.mark.parametrize(
    "text",
    ["never active(m.b)", "possible used(r) > 1", "always p", "always (asked(m.b) leads to late)", "never past(m.b)"],
)
def test_properties_of_another_spec_are_refused(tmp_path: Path, text: str) -> None:
    other = exover.loads(
        "spec s; poster p: bool = false; resource r: 3; module m { request a() { uses r 1; } request b(); }"
        "latch late: when p until m.a;"
    )
    (tmp_path / "s.prop").write_text(f"for s; property q: {text};")
    properties = exover.load_properties(tmp_path / "s.prop", other)
    assert exover.check(other, properties).of("property")
    with pytest.raises(ValueError, match="not properties of s, which has no "):
        exover.check(exover.loads("spec s; module m { request a(); }"), properties)


def test_answers_come_in_any_number_of_processes() -> None:
    spec = exover.loads(f"spec s; {MUTEX}")
    assert [finding.verdict for finding in exover.check(spec, jobs=2)] == [f.verdict for f in exover.check(spec)]
