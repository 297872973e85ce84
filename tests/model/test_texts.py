"""Which `because` text an answer bears."""

import pytest

from exover.model.event import Ask, Rejected
from exover.model.semantics import Reference
from exover.ocrd.machine import Machine
from exover.pipeline import build
from tests.support.engines import model_of


@pytest.mark.parametrize(("own", "text"), [("", "none left"), ('because ""', ""), ('because "mine"', "mine")])
def test_a_clause_that_consumes_has_its_own_text_or_that_of_its_resource(own: str, text: str) -> None:
    model = model_of(f"""spec s; module m {{ request a() {{ consumes fuel 1 {own}; }} }}
        resource fuel: 1 consumable = 0 because "none left";""")
    answer = (Rejected("m.a", "fuel", text),)
    reference = Reference(model)
    assert reference.step(reference.start(), Ask("m.a", ()))[1] == answer
    assert Machine(model, build(model).tables).step(Ask("m.a", ())) == answer
