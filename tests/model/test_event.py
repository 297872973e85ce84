"""Reasons without a rule, and codes of `invalid`: the same everywhere, in the orders that bytes number them by."""

import re
from pathlib import Path

from exover.audit.mission import CODES
from exover.model.event import INVALID_CODES, NO_RULES
from exover.pipeline import load
from exover.run.codec import C_CODES, OWN
from exover.source import Source

ROOT = Path(__file__).parents[2]
LANGUAGE = (ROOT / "docs" / "language.md").read_text(encoding="utf-8")


def test_codes_of_invalid_are_those_of_the_page() -> None:
    listed = LANGUAGE.partition("1. **Validate.**")[2].partition("But an out-of-range")[0]
    assert tuple(re.findall(r"`([a-z]+-[a-z-]+)`", listed)) == INVALID_CODES


def test_codes_of_invalid_are_numbered_as_the_runtime_and_recorded_missions_number_them() -> None:
    header = (ROOT / "exover" / "runtime" / "exover.h").read_text(encoding="utf-8")
    enum = header.partition("enum exover_invalid {")[2].partition("}")[0]
    assert tuple(each.lower().replace("_", "-") for each in re.findall(r"EXOVER_([A-Z_]+)", enum)) == C_CODES
    assert (*C_CODES, "wrong-type") == CODES and set(CODES) == set(INVALID_CODES)


def test_no_rule_is_called_as_a_reason_without_one_but_for_that_of_a_checker_that_is_faulty() -> None:
    reserved = re.search(r"rules called ((?:`\w+`(?:, )?)+),", LANGUAGE)
    assert reserved is not None and tuple(re.findall(r"\w+", reserved[1])) == NO_RULES
    assert set(OWN.values()) - set(NO_RULES) == {"faulty"}
    for name in (*NO_RULES, "faulty"):
        loaded = load(Source("s", f"spec s; module m {{ request a(); request b(); }} mutex {name}: m.a, m.b;"))
        assert [each.code for each in loaded.diagnostics] == ["E212"] * (name in NO_RULES)
