"""What ABC prints and writes: whole, cut off, and nonsense."""

import pytest

from exover.engines.aig.abc.output import NoOutput, Tally, clauses, runs, tally

PRINTED = """Output   6 was asserted in frame  1 ( 1) (solved   1 out of   3 outputs).
Timing out on output 14 in frame 3.
Invariant F[6] : 2 clauses with 3 flops (out of 4) (cex = 0, ave = 7.02)
Verification of invariant with 2 clauses was successful.  Time =     0.00 sec
\x1b[1;32mProperties:\x1b[0m  All = 3. Proved = 1. Disproved = 1. Undecided = 1.   Time =     0.14 sec
"""
PLA = """# Clauses of the last timeframe for "circuit"
.i 3
.o 1
.p 2
.ilb l0 l2 l10
.ob inv
1-0 1
-1- 1
.e
"""
CEX = "#\n#\n# CEX for output 2\n#\n00\n100\n010#\n#\n# CEX for output 10\n#\n00\n111# DONE\n"


def test_the_tally_is_read_in_any_colour() -> None:
    assert tally(PRINTED) == Tally(1, 1, 1, frozenset({14}))
    last = PRINTED.replace("Proved = 1", "Proved = 2").replace("All = 3", "All = 4").replace("14", " 2")
    assert tally(PRINTED + last) == Tally(2, 1, 1, frozenset({2, 14}))


@pytest.mark.parametrize("printed", ["", PRINTED[:-80], "Properties: All = x.", PRINTED.replace("All = 3", "All = 4")])
def test_a_tally_that_does_not_add_up_is_none(printed: str) -> None:
    assert tally(printed) is None


def test_clauses_are_read_by_the_names_of_latches() -> None:
    assert clauses(PLA) == [{0: True, 10: False}, {2: True}]
    assert clauses("") == []


@pytest.mark.parametrize("wrong", [("1-0 1", "1-01 1"), ("l10", "n10"), ("-1- 1", "-1x 1"), (".ilb l0", ".ilb")])
def test_what_are_no_clauses_is_refused(wrong: tuple[str, str]) -> None:
    with pytest.raises(NoOutput):
        clauses(PLA.replace(*wrong))


def test_runs_are_read_by_output() -> None:
    assert runs(CEX, 3) == {2: ((True, False, False), (False, True, False)), 10: ((True, True, True),)}
    assert runs("", 3) == {}


@pytest.mark.parametrize("wrong", [CEX.replace("100", "10"), CEX.replace("111", "1x1"), CEX[:-12]])
def test_what_are_no_runs_is_refused(wrong: str) -> None:
    with pytest.raises(NoOutput):
        runs(wrong, 3)
