"""The second channel of a decision: which requests are never active together, read from the rules themselves.

A *conflict* is a pair of requests of which no slot is launched while a slot of the other is active, whatever the
arguments and the rest of the state: two requests that one rule forbids to be active together, since a launch is the
answer only where no rule in question holds (docs/language.md section 4); and a request with itself, if it has a single
slot or a rule forbids a second active one.
"""

from itertools import groupby

from exover.model.decision import BUSY, Reason
from exover.model.expression import And, Compare, Const, Count, Status
from exover.model.index import ModelIndex
from exover.model.model import Kill, Model, Rule
from exover.ocrd.tables import ALL_DENIALS, BLOCK, CLEARINGS, NO_DENIALS, ConflictRow


def pair(rule: Rule) -> tuple[str, str] | None:
    """Return the two requests that the rule forbids to be active together, if that is all it says."""
    match rule.condition:
        case And((Status("active", first, None), Status("active", second, None))) if rule.slot_of is None:
            return (first, second) if first != second else None  # one that is never to be active is in no conflict
        case Compare(">", Count((name,)), Const(1)):
            return name, name
        case _:
            return None


def conflicts(model: Model) -> tuple[frozenset[int], ...]:
    """Return for every request the numbers of those that it conflicts with."""
    number = ModelIndex(model).request
    found = [{index} if request.instances == 1 else set() for index, request in enumerate(model.requests)]
    for first, second in filter(None, map(pair, model.rules)):
        found[number[first]].add(number[second])
        found[number[second]].add(number[first])
    return tuple(map(frozenset, found))


def row(others: frozenset[int]) -> list[ConflictRow]:
    """Return the bit row of these requests: its blocks that are not empty, in order."""
    blocks = groupby(sorted(others), lambda index: index // BLOCK)
    return [ConflictRow(block, _signed(sum(1 << index % BLOCK for index in indices))) for block, indices in blocks]


def _signed(mask: int) -> int:
    """Return the number of `BLOCK` bits in two's complement, which fits the narrowest words."""
    return mask - (mask >> BLOCK - 1 << BLOCK)


def denials(model: Model, known: tuple[Reason, ...]) -> list[int]:
    """Return for every reason which decisions for it show that a conflict of the newcomer is active.

    A request that is being cleared for counts as active where a rule could be cleared for by kills, so a rejection for
    such a rule shows nothing; a clearing does.
    """
    shown: dict[Reason, int] = {}
    for rule in model.rules:
        reason = Reason(rule.name, rule.because)
        kills = any(isinstance(remedy, Kill) for remedy in rule.remedies)
        mine = NO_DENIALS if pair(rule) is None else CLEARINGS if kills else ALL_DENIALS
        shown[reason] = min(shown.get(reason, mine), mine)
    if all(request.instances == 1 for request in model.requests):
        shown[BUSY] = ALL_DENIALS
    return [shown.get(reason, NO_DENIALS) for reason in known]
