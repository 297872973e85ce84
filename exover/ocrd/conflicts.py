"""The second channel of a decision, a redundant check: pairs of requests that are never launched beside each other.

Two requests are in *conflict* iff a slot of one is never launched while a slot of the other is active, by the form of
the rules alone: one rule forbids both to be active together, and a launch is the answer only if the F of no rule in
question holds (docs/language.md section 4). A request is in conflict with itself if it has a single slot or a rule
forbids a second active one.
"""

from itertools import groupby

from exover.model.decision import BUSY, Reason
from exover.model.expression import And, Compare, Const, Count, Status
from exover.model.index import ModelIndex
from exover.model.model import Kill, Model, Rule
from exover.ocrd.tables import ALL_DENIALS, BLOCK, CLEARINGS, NO_DENIALS, ConflictRow


def pair(rule: Rule) -> tuple[str, str] | None:
    """Return the two requests (perhaps one, twice) if the rule only forbids them to be active together; else None."""
    match rule.condition:
        case And((Status("active", first, None), Status("active", second, None))) if rule.slot_of is None:
            return (first, second) if first != second else None  # one that is never to be active is in no conflict
        case Compare(">", Count((name,)), Const(1)):
            return name, name
        case _:
            return None


def conflicts(model: Model) -> tuple[frozenset[int], ...]:
    """Return for each request the numbers of the requests that it is in conflict with."""
    number = ModelIndex(model).request
    found = [{index} if request.instances == 1 else set() for index, request in enumerate(model.requests)]
    for first, second in filter(None, map(pair, model.rules)):
        found[number[first]].add(number[second])
        found[number[second]].add(number[first])
    return tuple(map(frozenset, found))


def row(others: frozenset[int]) -> list[ConflictRow]:
    """Return the bit row of these requests: its nonzero blocks, in order."""
    blocks = groupby(sorted(others), lambda index: index // BLOCK)
    return [ConflictRow(block, _signed(sum(1 << index % BLOCK for index in indices))) for block, indices in blocks]


def _signed(mask: int) -> int:
    """Return the unsigned `mask` of `BLOCK` bits as a signed number in two's complement, which fits 16-bit words."""
    return mask - (mask >> BLOCK - 1 << BLOCK)


def denials(model: Model, known: tuple[Reason, ...]) -> list[int]:
    """Return for each reason a code: which decisions for it imply that a request in conflict with the newcomer is
    active. These are all (`ALL_DENIALS`), only clearings (`CLEARINGS`) or none (`NO_DENIALS`).

    Under a rule that may kill, requests that are clearing also count as active, so a rejection for it implies nothing.
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
