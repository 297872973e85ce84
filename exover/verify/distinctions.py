"""What the conditions of a model tell apart, beyond what tests of the tables do: the ground of questions on rules."""

from dataclasses import dataclass, field

from exover.model.expression import Compare, Cond, Const, Own, Param, Past, Reading, Status, Term, atoms, leaves
from exover.model.model import Model, Request
from exover.model.reads import reads
from exover.model.types import Real, ordinal
from exover.ocrd.vector import Vocabulary, comparisons, conditions


@dataclass
class Told:
    """What is told apart of one number: on which side of each cut it lies, or its very value."""

    cuts: set[int] = field(default_factory=set)
    exact: bool = False


@dataclass
class PastTold:
    """What is told apart of a past: by comparisons of its values, and values that `self.p` is compared with."""

    comparisons: list[Compare] = field(default_factory=list)
    exact: set[str] = field(default_factory=set)


@dataclass
class Distinctions:
    """By parameter and by reading what is told apart of it; by request the conditions on its arguments alone."""

    params: dict[tuple[str, str], Told] = field(default_factory=dict)
    readings: dict[str, Told] = field(default_factory=dict)
    compared: set[tuple[str, str]] = field(default_factory=set)
    """Real parameters that are compared with other reals."""
    conditions: dict[str, list[Cond]] = field(default_factory=dict)
    levels: set[str] = field(default_factory=set)
    """Consumables whose level some condition reads."""
    lasts: set[str] = field(default_factory=set)
    """Requests whose last outcome some condition reads."""
    pasts: dict[str, "PastTold"] = field(default_factory=dict)
    """By request whose past some condition reads what is told apart of it."""


def distinctions(model: Model) -> Distinctions:
    """Return what all conditions of the model tell apart."""
    found = Distinctions()
    vocabulary = Vocabulary(model)
    for request, cond in conditions(model):
        found.levels |= {read.name for read in reads(cond) if read.kind == "level"}
        found.lasts |= {read.name for read in reads(cond) if read.kind == "last"}
        for subject, compare in comparisons(cond, request):
            _compare(found, vocabulary, subject, request, compare)
        _collect(found, model, request, cond)
    return found


def _compare(
    found: Distinctions, vocabulary: Vocabulary, subject: str | None, owner: str | None, compare: Compare
) -> None:
    sides = (compare.left, compare.right)
    if any(_is_real(vocabulary, subject, side) for side in sides):
        named = [side for side in sides if isinstance(side, Param)]
        if not any(isinstance(side, Const) for side in sides) and subject is not None:
            found.compared |= {(subject, side.name) for side in named}
        for side in sides:
            if isinstance(side, Reading):
                found.readings.setdefault(side.name, Told())
        return
    for side, other in (sides, sides[::-1]):
        for leaf in leaves(side):
            told = _told(found, subject, owner, leaf)
            if told is None:
                continue
            if leaf is side and isinstance(other, Const):
                number = _number(vocabulary, owner if isinstance(leaf, Own) else subject, leaf, other)
                told.cuts |= {number - 1, number}
            else:
                told.exact = True


def _is_real(vocabulary: Vocabulary, subject: str | None, term: Term) -> bool:
    match term:
        case Const(value):
            return isinstance(value, float)
        case Param(name):
            return subject is not None and isinstance(vocabulary.parameter_types[subject, name], Real)
        case Reading(name):
            return isinstance(vocabulary.reading_type(name), Real)
        case _:
            return False


def _told(found: Distinctions, subject: str | None, owner: str | None, leaf: Term) -> Told | None:
    match leaf:
        case Param(name) if subject is not None:
            return found.params.setdefault((subject, name), Told())
        case Own(name) if owner is not None:
            return found.params.setdefault((owner, name), Told())
        case Reading(name):
            return found.readings.setdefault(name, Told())
        case _:
            return None


def _number(vocabulary: Vocabulary, subject: str | None, leaf: Term, constant: Const) -> int:
    match leaf:
        case Param(name) | Own(name) if subject is not None:
            return ordinal(vocabulary.parameter_types[subject, name], constant.value)
        case Reading(name):
            return ordinal(vocabulary.reading_type(name), constant.value)
        case _:
            return int(constant.value)


def _collect(found: Distinctions, model: Model, subject: str | None, cond: Cond) -> None:
    """Note the conditions that read the arguments of one request and nothing else."""
    for atom in atoms(cond):
        match atom:
            case Past(request, where):
                _remember(found.pasts.setdefault(request, PastTold()), where)
            case Status(_, request, where):
                if where is not None and _reads_own_arguments_only(model.request[request], where):
                    found.conditions.setdefault(request, []).append(where)
                if where is not None:
                    _collect(found, model, request, where)
            case Compare():
                if subject is not None and _reads_own_arguments_only(model.request[subject], atom):
                    found.conditions.setdefault(subject, []).append(atom)
            case _:
                pass


def _remember(told: PastTold, where: Cond | None) -> None:
    """Note what the condition on a past tells apart."""
    for atom in atoms(where) if where is not None else ():
        assert isinstance(atom, Compare), "inside `with` there are comparisons alone"
        terms = (*leaves(atom.left), *leaves(atom.right))
        if any(isinstance(term, Own) for term in terms):
            told.exact |= {term.name for term in terms if isinstance(term, Param)}
        else:
            told.comparisons.append(atom)


def _reads_own_arguments_only(request: Request, cond: Cond) -> bool:
    names = {parameter.name for parameter in request.params}
    for atom in atoms(cond):
        if not isinstance(atom, Compare):
            return False
        for term in (*leaves(atom.left), *leaves(atom.right)):
            if not (isinstance(term, Const) or (isinstance(term, Param) and term.name in names)):
                return False
    return True
