"""The SMV text of the command line: the same bytes each time, whatever the checks say, with what the properties say."""

from pathlib import Path

import pytest

from exover.cli.main import main
from tests.runtime.compiling import ROOT

SPEC = "spec s; module m { request r(); } forbid f: active(m.r) by kill m.r; launch l: m.r() when past(m.r);"
PROPERTIES = "for s; property p: always possible past(m.r); property q: ltl G !past(m.r);"


def emitted(folder: Path, *more: str) -> dict[str, str]:
    """Return the files that the command writes for a spec that is violated."""
    (folder / "s.exo").write_text(SPEC)
    assert main(["emit", str(folder / "s.exo"), "--target", "smv", "--out", str(folder / "out"), *more]) == 0
    return {path.name: path.read_text() for path in (folder / "out").iterdir()}


def test_a_spec_need_not_hold_to_be_judged_by_others(tmp_path: Path) -> None:
    found = emitted(tmp_path)
    assert emitted(tmp_path) == found
    assert set(found) == {"s.smv", "s.fair.smv"}
    assert "-- rule f" in found["s.smv"] and "INVARSPEC NAME completeness.f :=" in found["s.smv"]
    assert "CTLSPEC NAME starvation.m.r :=" in found["s.fair.smv"] and "JUSTICE m.r$0 = idle" in found["s.fair.smv"]


@pytest.mark.parametrize("given", [True, False])
def test_properties_are_specifications(given: bool, tmp_path: Path) -> None:
    file = tmp_path / ("given.prop" if given else "s.prop")
    file.write_text(PROPERTIES)
    text = emitted(tmp_path, *(["--properties", str(file)] if given else []))["s.smv"]
    assert "CTLSPEC NAME property.p :=\n  AG EF (m.r$past = 1);" in text
    assert "LTLSPEC NAME property.q :=\n  G (m.r$past = 0);" in text


def test_what_is_too_large_to_be_written_down_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = tmp_path / "large.exo"
    spec.write_text("spec large; resource tank: 9999 consumable; module m { request r() { consumes tank 1; } }")
    command = ["emit", str(spec), "--unchecked", "--out", str(tmp_path), "--target"]
    assert main([*command, "aiger,smv"]) == 2
    assert capsys.readouterr().err.endswith(
        "cannot be written as smv: consumable `tank` has 10000 levels; 4096 at most are followed: "
        "nothing is emitted; leave smv out: aiger and smt2 have no such limit\n"
    )
    assert main([*command, "aiger,smt2"]) == 0


def test_a_range_is_written_without_its_values(tmp_path: Path) -> None:
    """What stands for all readings of a poster may be far apart."""
    spec = tmp_path / "wide.exo"
    whole = f"{-(2**63)} .. {2**63 - 1}"
    spec.write_text(f"spec wide; poster p: int in {whole} = 0; module m {{ request r() {{ check p > 3; }} }}")
    assert main(["emit", str(spec), "--target", "smv", "--out", str(tmp_path)]) == 0
    assert "p : {-9223372036854775808, 3, 4};" in (tmp_path / "wide.smv").read_text()


def test_what_rests_on_a_run_through_compared_reals_is_not_asked(tmp_path: Path) -> None:
    """Here some abstract run ends the wait, and no value of `top` does."""
    spec = tmp_path / "reals.exo"
    spec.write_text(
        "spec reals; poster top: real in 0 .. 2 = 0;"
        "module m { request r(x: real in 0 .. 2, y: real in 1 .. 1.5) {"
        " fail when x >= top else wait; fail when x <= y; } }"
    )
    assert main(["emit", str(spec), "--target", "smv", "--out", str(tmp_path)]) == 0
    text = (tmp_path / "reals.smv").read_text()
    assert "-- not asked: deadlock.m.r\n" in text and "-- not asked: reachability.m.r\n" in text
    assert "NAME deadlock.m.r" not in text and "NAME reachability.m.r" not in text
    assert "INVARSPEC NAME safety.m.r.fail.1 :=" in text
    assert "CTLSPEC NAME starvation.m.r :=" in (tmp_path / "reals.fair.smv").read_text()


@pytest.mark.parametrize("name", ["rover", "assistant", "satellite", "diligent"])
def test_the_examples_can_be_written(name: str, tmp_path: Path) -> None:
    out = str(tmp_path)
    assert main(["emit", str(ROOT / "specs" / f"{name}.exo"), "--target", "smv", "--out", out]) == 0
    assert (tmp_path / f"{name}.fair.smv").read_text().count("MODULE main") == 1


def test_the_text_grows_in_proportion_to_the_spec(tmp_path: Path) -> None:
    """A history variable is named where something sets it, and not at each event."""

    def length(requests: int) -> int:
        spec = tmp_path / "ring.exo"
        declared = " ".join(f"request r{n}();" for n in range(requests))
        rules = " ".join(f"mutex m.r{n}, m.r{(n + 1) % requests};" for n in range(requests))
        spec.write_text(f"spec ring; module m {{ {declared} }} {rules}")
        assert main(["emit", str(spec), "--target", "smv", "--out", str(tmp_path)]) == 0
        return (tmp_path / "ring.smv").stat().st_size

    assert length(40) < 2.1 * length(20)
