"""What arguments count for, of those alone that it depends on, is what the tables say of all of them."""

import pytest

from exover.loop.finite.argument_classes import Arguments
from exover.loop.finite.builder import ClosedLoop
from exover.model.event import Args
from exover.model.types import ordinal
from exover.ocrd.tables import NONE
from tests.support.engines import model_of
from tests.support.generate import Size, random_spec
from tests.support.small import compiled

CHOSEN = """spec s;
poster limit: real in 0 .. 9 = 3;
module m {
    request a(k: int in 0 .. 3, n: int in 1 .. 5, x: real in 0 .. 9, y: real in 0 .. 9) instances 2 {
        uses p 3 when n > 2 and k == 1;
        uses p 1 when x > y and y > 2;
        uses p 2 when x > 4;
        fail far: when x > limit;
    }
    request b(k: int in 0 .. 3) { check not active(m.a with k == self.k and n > 3) and used(p) < 4; }
}
resource p: 20 by wait;"""


def told(arguments: Arguments, args: Args, choice: tuple[int, ...]) -> tuple[int, ...]:
    """Return by feature what these arguments count for, of all that they are loaded into."""
    entries, found = arguments.with_orders(args, choice), []
    for feature in arguments.tables.features[arguments.row.features : arguments.row.features_end]:
        weight = 1
        if feature.weight != NONE:
            weight = ordinal(arguments.params[feature.weight].type, args[feature.weight])
        found.append(weight if arguments.loader.agrees(feature.predicate, entries) else 0)
    return tuple(found)


@pytest.mark.parametrize("seed", [None, *range(12)])
def test_weights_are_those_that_the_tables_tell(seed: int | None) -> None:
    made = compiled(model_of(CHOSEN if seed is None else random_spec(seed, Size())))
    loop = ClosedLoop(made.model, made.tables, made.entries)
    for arguments in loop.arguments:
        for args in arguments.samples:
            for choice in arguments.choices():
                assert arguments.weights(args, choice) == told(arguments, args, choice)
