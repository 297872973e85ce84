"""Small specs on which the tables once failed, found by random testing: the tables answer as the reference does."""

import pytest

from tests.support.engines import agree_at_random

SPECS = {
    "an enum of self opposite a constant inside with": """
        module m {
            request a(z: {left, right}) { check active(m.b with self.z == left); }
            request b(z: {left, right}) { fail when past(m.a with self.z != z or self.z in {right}); }
        }""",
    "a condition inside with that reads nothing but self": """
        module m {
            request a(w: {left, right}) {
                fail when past(m.b with right == self.w);
                check not active(m.b with self.w == left);
            }
            request b(n: bool) instances 2;
        }""",
}


@pytest.mark.parametrize("text", SPECS.values(), ids=SPECS)
def test_tables_answer_as_the_reference_does(text: str) -> None:
    agree_at_random(f"spec s; {text}", seed=1, events=300)
