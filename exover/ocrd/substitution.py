"""Substitution of constants for `self.p`, the parameters of the request whose clause a condition is."""

from exover.model.evaluate import OPERATORS
from exover.model.expression import FALSE, TRUE, AtomicCond, Compare, Cond, Const, ModelTerm, Own, Sum, with_atoms


def substitute(cond: Cond, values: dict[str, Const]) -> Cond:
    """Return the condition with `values` substituted for every `self.p`; comparisons of two constants are folded."""

    def known(atom: AtomicCond) -> Cond:
        if not isinstance(atom, Compare):
            return atom
        left, right = _replace(atom.left, values), _replace(atom.right, values)
        if isinstance(left, Const) and isinstance(right, Const):
            return TRUE if OPERATORS[atom.operator](left.value, right.value) else FALSE
        return Compare(atom.operator, left, right)

    return with_atoms(cond, known)


def _replace(term: ModelTerm, values: dict[str, Const]) -> ModelTerm:
    match term:
        case Own(name):
            return values[name]
        case Sum(constant, terms):
            return Sum(constant, tuple((factor, _replace(part, values)) for factor, part in terms))
        case _:
            return term
