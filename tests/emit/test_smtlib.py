"""What is asked, as SMT-LIB 2: Z3 reads the text, and its answers are those of the checks."""

import re
from pathlib import Path

import pytest

from exover.checks import claims
from exover.checks.run import check_all
from exover.cli.main import main
from exover.emit import smtlib
from exover.model.property import NO_PROPERTIES
from tests.support.engines import model_of
from tests.support.small import compiled, small_spec_of

FLAWED = """spec flawed;
poster a: int in 0 .. 100 = 0;
poster x: real in 0 .. 1 = 0.1;
module m {
    request r(v: real in 0 .. 1) { check enough: v > 0.5 and x < 1; }
    request never() { check no: a > 7 and a < 3; }
}
forbid both: active(m.r) and a >= 99;
"""


def answers(text: str) -> dict[str, list[str]]:
    """Return what Z3 answers to each question by its name: to its runs, then to its step."""
    import z3

    context = z3.Context()
    said = z3.Z3_eval_smtlib2_string(context.ref(), text)
    assert "error" not in said and "unknown" not in said, said
    found: dict[str, list[str]] = {}
    for name, answer in re.findall(r"^(.*?): .*\n(sat|unsat)$", said, re.MULTILINE):
        found.setdefault(name, []).append(answer)
    return found


def asked(spec: str) -> tuple[str, dict[str, str]]:
    """Return the text of what is asked of a spec, and what the checks answer."""
    made = compiled(model_of(spec))
    said = tuple(claims(made.model, NO_PROPERTIES))
    (artefact,) = smtlib.emit(made, NO_PROPERTIES, said, made.model.name)
    verdicts = {f"{f.check} {f.subject}": f.verdict for f in check_all(made, lambda what: None).findings}
    return artefact.content.decode(), verdicts


@pytest.mark.parametrize("spec", (FLAWED, small_spec_of(4)), ids=("flawed", "small"))
def test_answers_are_those_of_the_checks(spec: str) -> None:
    text, verdicts = asked(spec)
    decided = 0
    for name, said in answers(text).items():
        check = name.split(" ")[0]
        if check == "consistency":
            assert (said == ["sat"]) == (verdicts[name] == "holds")
        elif check in ("safety", "completeness", "reachability", "obligation", "idle-guard"):
            some = check in ("reachability", "idle-guard")
            runs, step = said
            if runs == "sat" or step == "unsat":
                decided += 1
                assert verdicts[name] == ("holds" if some == (runs == "sat") else "violated"), name
    assert decided >= 5


def test_the_text_names_what_it_is_about() -> None:
    text, _ = asked(FLAWED)
    for part in (
        "; ---- safety both ----",
        "(|m.r[0].v| Real)",
        "(|ask m.r: v| Real)",
        "(define-fun step ",
        "|next a|",
    ):
        assert part in text
    assert asked(FLAWED)[0] == text


def test_a_spec_that_fails_can_be_asked_about(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "flawed.exo").write_text(FLAWED)
    assert main(["emit", str(tmp_path / "flawed.exo"), "--target", "smt2", "--out", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'out' / 'flawed.smt2'}\n"
    assert (tmp_path / "out" / "flawed.smt2").read_text().startswith("; The closed loop of the spec flawed")
