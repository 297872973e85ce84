"""Damaged tables with a right checksum: none that changes a decision is taken for the rules.

A few for each spec; `EXOVER_MUTANTS=50` tries as many of each and prints what became of them (`make mutants`).
"""

import os

import pytest

from tests.support.mutants import SUBJECTS, subject_of, tally

COUNT = int(os.environ.get("EXOVER_MUTANTS", "4"))


@pytest.mark.parametrize("number", range(len(SUBJECTS)))
def test_no_mutant_that_changes_a_decision_is_missed(number: int, capsys: pytest.CaptureFixture[str]) -> None:
    subject = subject_of(SUBJECTS[number])
    assert not subject.noticed(subject.built.data)
    found = tally(subject, COUNT, 100 + number, proofs=COUNT // 10)
    with capsys.disabled():
        if COUNT > 4:
            print(f"\n{subject.built.model.name}: {found.made} mutants, {dict(found.counts)}")
    assert found.missed == ()
