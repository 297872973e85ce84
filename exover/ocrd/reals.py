"""Diagrams of comparisons of reals: with constants by ranks, with each other by orders."""

from exover.dataclass import dataclass
from exover.model.expression import Const, ModelTerm, Operator, Param, Reading, mirrored
from exover.ocrd.diagram import NO, YES
from exover.ocrd.relations import Relations
from exover.ocrd.vector import LEFT, SAME, ArgRank, Order, Quantity, Rank, Vocabulary
from exover.ocrd.view import ParameterOwner


@dataclass(frozen=True)
class RealComparisons(Relations):
    """Builds, in one manager, diagrams of comparisons of the reals of one model."""

    @property
    def vocabulary(self) -> Vocabulary:
        """The quantities of the model."""
        return self.numbers.vocabulary

    def compare_reals(self, op: Operator, left: ModelTerm, right: ModelTerm, subject: ParameterOwner | None) -> int:
        """Return the condition `left op right` of two reals."""
        if isinstance(left, Const):
            left, right, op = right, left, mirrored(op)
        if isinstance(left, Reading) and isinstance(right, Param):
            left, right, op = right, left, mirrored(op)
        assert isinstance(left, Param | Reading), "two constants are folded when names are resolved"
        if isinstance(right, Const):
            return self._compare_rank(op, left, right, subject)
        assert isinstance(right, Param | Reading)
        request = subject.request if subject and isinstance(left, Param) else None
        if request is None or isinstance(right, Param):
            ordered = left.name <= right.name
            left, right, op = (left, right, op) if ordered else (right, left, mirrored(op))
        if left == right:
            return YES if op in ("<=", ">=", "==") else NO
        bounds: dict[Operator, tuple[Operator, int]] = {"<": ("<=", LEFT), "<=": ("<=", SAME)}
        bounds |= {">": (">", SAME), ">=": (">", LEFT), "==": ("==", SAME), "!=": ("!=", SAME)}
        relation, bound = bounds[op]
        return self.relate(relation, self.form(Order(request, left, right)), bound)

    def _compare_rank(
        self, op: Operator, side: Param | Reading, constant: Const, subject: ParameterOwner | None
    ) -> int:
        quantity: Quantity
        if isinstance(side, Param):
            assert subject is not None
            key: tuple[str | None, str] = (subject.request, side.name)
            quantity = ArgRank(subject.request, side.name)
        else:
            key, quantity = (None, side.name), Rank(side.name)
        same = 2 * self.vocabulary.thresholds[key].index(float(constant.value)) + 1
        return self.relate(op, self.form(quantity), same)
