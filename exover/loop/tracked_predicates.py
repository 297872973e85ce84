"""Tracked predicates: what conditions of a model and of properties tell apart beyond the tests of the tables."""

from collections.abc import Iterator
from dataclasses import field

from exover.dataclass import dataclass
from exover.model.conditions import comparisons, conditions
from exover.model.expression import Compare, Cond, Const, ModelTerm, Own, Param, Past, Reading, Status, atoms, leaves
from exover.model.model import Model, Request
from exover.model.property import Atom, Happened, Properties, formulas
from exover.model.property import atoms as property_atoms
from exover.model.reads import reads
from exover.model.types import Real, ordinal
from exover.ocrd.vector import Vocabulary


@dataclass
class TrackedConstants:
    """What conditions tell apart of one number: on which side of each cut it lies or, if `exact`, its value."""

    cuts: set[int] = field(default_factory=set)
    exact: bool = False


@dataclass
class TrackedPast:
    """What conditions tell apart of a past: comparisons of its values, and values that `self.p` is compared with."""

    comparisons: list[Compare] = field(default_factory=list)
    exact: set[str] = field(default_factory=set)


@dataclass
class TrackedPredicates:
    """What is told apart of each parameter and reading; for each request the conditions on its arguments alone."""

    params: dict[tuple[str, str], TrackedConstants] = field(default_factory=dict)
    readings: dict[str, TrackedConstants] = field(default_factory=dict)
    compared: set[tuple[str, str]] = field(default_factory=set)
    """Real parameters that are compared with other reals."""
    cuts: dict[tuple[str | None, str], set[float]] = field(default_factory=dict)
    """The constants that reals are compared with: by request and parameter, or None and poster."""
    orders: set[tuple[str, str, str]] = field(default_factory=set)
    """Requests, their real parameters and the real posters that these are compared with."""
    pairs: set[tuple[str, str]] = field(default_factory=set)
    """Real posters that are compared with each other, the lesser name first."""
    conditions: dict[str, list[Cond]] = field(default_factory=dict)
    levels: set[str] = field(default_factory=set)
    """Consumables whose level some condition reads."""
    lasts: set[str] = field(default_factory=set)
    """Requests whose last outcome some condition reads."""
    pasts: dict[str, "TrackedPast"] = field(default_factory=dict)
    """What is told apart of the past, for each request whose past some condition reads."""

    def constants(self, request: str, param: str) -> TrackedConstants:
        """Return what conditions tell apart of a parameter."""
        return self.params.get((request, param)) or TrackedConstants()


def tracked_predicates(model: Model, properties: Properties) -> TrackedPredicates:
    """Return what all conditions of the model and of the properties tell apart."""
    found = TrackedPredicates()
    vocabulary = Vocabulary(model)
    for request, cond in (*conditions(model), *((None, cond) for cond in property_conditions(properties))):
        for read in reads(cond):
            if read.kind == "level":
                found.levels.add(read.name)
            elif read.kind == "last":
                found.lasts.add(read.name)
        for subject, compare in comparisons(cond, request):
            _compare(found, vocabulary, subject, request, compare)
        _collect(found, model, request, cond)
    return found


def property_conditions(properties: Properties) -> Iterator[Cond]:
    """Yield the conditions in atoms of formulas; the arguments of an occurrence count as those of a slot."""
    for formula in formulas(properties):
        for atom in property_atoms(formula):
            match atom:
                case Atom(condition):
                    yield condition
                case Happened(_, request, where):
                    yield Status("active", request, where)


def _compare(
    found: TrackedPredicates, vocabulary: Vocabulary, subject: str | None, owner: str | None, compare: Compare
) -> None:
    sides = (compare.left, compare.right)
    if any(_is_real(vocabulary, subject, side) for side in sides):
        _compare_reals(found, subject, *sides)
        return
    for side, other in (sides, sides[::-1]):
        for leaf in leaves(side):
            tracked = _tracked_constants(found, subject, owner, leaf)
            if tracked is None:
                continue
            if leaf is side and isinstance(other, Const):
                number = _number(vocabulary, owner if isinstance(leaf, Own) else subject, leaf, other)
                tracked.cuts |= {number - 1, number}
            else:
                tracked.exact = True


def _compare_reals(found: TrackedPredicates, subject: str | None, left: ModelTerm, right: ModelTerm) -> None:
    for side, other in ((left, right), (right, left)):
        key = (
            (subject, side.name)
            if isinstance(side, Param)
            else (None, side.name)
            if isinstance(side, Reading)
            else None
        )
        if key is not None and isinstance(other, Const):
            found.cuts.setdefault(key, set()).add(float(other.value))
        if isinstance(side, Reading):
            found.readings.setdefault(side.name, TrackedConstants())
        match subject, side, other:
            case str(request), Param(name), Reading(poster):
                found.compared.add((request, name))
                found.orders.add((request, name, poster))
            case str(request), Param(name), Param():
                found.compared.add((request, name))
            case _, Reading(name), Reading(poster) if name < poster:
                found.pairs.add((name, poster))
            case _:
                pass


def _is_real(vocabulary: Vocabulary, subject: str | None, term: ModelTerm) -> bool:
    match term:
        case Const(value):
            return isinstance(value, float)
        case Param(name):
            return subject is not None and isinstance(vocabulary.parameter_types[subject, name], Real)
        case Reading(name):
            return isinstance(vocabulary.reading_type(name), Real)
        case _:
            return False


def _tracked_constants(
    found: TrackedPredicates, subject: str | None, owner: str | None, leaf: ModelTerm
) -> TrackedConstants | None:
    match leaf:
        case Param(name) if subject is not None:
            return found.params.setdefault((subject, name), TrackedConstants())
        case Own(name) if owner is not None:
            return found.params.setdefault((owner, name), TrackedConstants())
        case Reading(name):
            return found.readings.setdefault(name, TrackedConstants())
        case _:
            return None


def _number(vocabulary: Vocabulary, subject: str | None, leaf: ModelTerm, constant: Const) -> int:
    match leaf:
        case Param(name) | Own(name) if subject is not None:
            return ordinal(vocabulary.parameter_types[subject, name], constant.value)
        case Reading(name):
            return ordinal(vocabulary.reading_type(name), constant.value)
        case _:
            return int(constant.value)


def _collect(found: TrackedPredicates, model: Model, subject: str | None, cond: Cond) -> None:
    """Record the conditions that read the arguments of one request and nothing else."""
    for atom in atoms(cond):
        match atom:
            case Past(request, where):
                _remember(found.pasts.setdefault(request, TrackedPast()), where)
                _own(found, subject, where)
            case Status(_, request, where):
                _own(found, subject, where)
                if where is not None and _reads_own_arguments_only(model.request[request], where):
                    found.conditions.setdefault(request, []).append(where)
                if where is not None:
                    _collect(found, model, request, where)
            case Compare():
                if subject is not None and _reads_own_arguments_only(model.request[subject], atom):
                    found.conditions.setdefault(subject, []).append(atom)
            case _:
                pass


def _own(found: TrackedPredicates, subject: str | None, where: Cond | None) -> None:
    """Record the parts of a condition inside `with` that read `self.p` alone, as conditions on the clause's request."""
    for atom in atoms(where) if where is not None and subject is not None else ():
        if isinstance(atom, Compare) and subject is not None:
            sides = (atom.left, atom.right)
            if all(isinstance(side, Const | Own) for side in sides):
                left, right = (Param(side.name) if isinstance(side, Own) else side for side in sides)
                found.conditions.setdefault(subject, []).append(Compare(atom.operator, left, right))


def _remember(tracked: TrackedPast, where: Cond | None) -> None:
    """Record what a condition on a past tells apart."""
    for atom in atoms(where) if where is not None else ():
        assert isinstance(atom, Compare), "inside `with` there are comparisons alone"
        terms = (*leaves(atom.left), *leaves(atom.right))
        if any(isinstance(term, Own) for term in terms):
            tracked.exact |= {term.name for term in terms if isinstance(term, Param)}
        else:
            tracked.comparisons.append(atom)


def _reads_own_arguments_only(request: Request, cond: Cond) -> bool:
    names = {parameter.name for parameter in request.params}
    for atom in atoms(cond):
        if not isinstance(atom, Compare):
            return False
        for term in (*leaves(atom.left), *leaves(atom.right)):
            if not (isinstance(term, Const) or (isinstance(term, Param) and term.name in names)):
                return False
    return True
