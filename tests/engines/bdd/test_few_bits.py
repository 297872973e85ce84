"""Operations on few bits are those of the manager."""

from random import Random

import pytest

from exover.engines.bdd.few_bits import FewBits
from exover.engines.bdd.manager import BddManager, Set
from exover.engines.bdd.space import new_manager
from tests.support.needed import needs_cudd

pytestmark = needs_cudd
NAMES = [f"x{number}" for number in range(12)]


@pytest.fixture(scope="module")
def few() -> FewBits:
    """A manager with a dozen bits."""
    manager = new_manager()
    assert isinstance(manager, FewBits)
    manager.declare(*NAMES)
    return manager


def random_set(random: Random, bdd: BddManager, clauses: int) -> Set:
    """Return a disjunction of conjunctions of three bits."""
    found = bdd.false
    for _ in range(clauses):
        found |= bdd.cube({name: random.random() < 0.5 for name in random.sample(NAMES, 3)})
    return found


@pytest.mark.parametrize("clauses", [1, 3, 40])
def test_substitutions_are_simultaneous(few: FewBits, clauses: int) -> None:
    random, plain = Random(clauses), few.manager
    for _ in range(200):
        states = random_set(random, few, clauses)
        names = random.sample(NAMES, random.randint(0, 9))
        constants = {name: random.random() < 0.5 for name in names}
        assert few.let(constants, states) == (plain.let(constants, states) if names else states)
        functions = {name: random.choice([few.true, few.false, random_set(random, few, 2)]) for name in names}
        assert few.let(functions, states) == (plain.let(functions, states) if names else states)
        others = dict(zip(names, random.sample(NAMES, len(names)), strict=True))
        assert few.let(others, states) == (plain.let(others, states) if names else states)


@pytest.mark.parametrize("clauses", [1, 3, 40])
def test_quantifiers_and_cubes_are_the_managers(few: FewBits, clauses: int) -> None:
    random, plain = Random(clauses), few.manager
    for _ in range(200):
        names = random.sample(NAMES, random.randint(0, 9))
        states = random_set(random, few, clauses)
        assert few.exist(names, states) == plain.exist(names, states)
        literals = {name: random.random() < 0.5 for name in names}
        assert few.cube(literals) == plain.cube(literals)
