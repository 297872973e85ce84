"""Decides whether NEW may take over from OLD, and which requests have to end first."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from exover.dataclass import dataclass
from exover.loop.claim import Verdict, worst
from exover.model.model import Rule
from exover.model.property import Property
from exover.swap.carry import Carry
from exover.swap.later import BrokenLater
from exover.swap.proof import Obligations
from exover.swap.record import CarriedLast, CarriedLevel, CarriedPast, CarriedReading, RecordField

AskProperties = Callable[[tuple[Property, ...]], Mapping[str, Verdict]]
"""Checks properties of OLD, and returns their verdicts by name."""


@dataclass(frozen=True)
class SwapAnswer:
    """The result: `verdict` is `holds` iff no state of OLD breaks a rule of NEW once the requests `ended` are idle.

    `ended`: the requests of OLD that have to be idle, each with the rules of NEW that need it; without rules, NEW lacks
    or changes the request. `open`: rules that may be broken all the same. `asked`: how many of the `rules` of NEW
    needed a check. `forgotten`: what gets its initial value in NEW, since OLD does not keep it, or not so.
    """

    verdict: Verdict
    ended: Mapping[str, tuple[str, ...]]
    open: tuple[str, ...]
    asked: int
    rules: int
    forgotten: tuple[str, ...]


def prove(carry: Carry, ask: AskProperties) -> SwapAnswer:
    """Return whether NEW may take over; what has to end first is chosen greedily, by how many rules it helps."""
    ended: dict[str, tuple[str, ...]] = dict.fromkeys(
        (r.name for r in carry.old.model.requests if r.name in carry.changed), ()
    )
    rules, start = carry.new.model.rules, Obligations(carry, BrokenLater(carry.new), frozenset(ended))
    asked, found = _ask(start, rules, ask)
    while found:
        obligations = replace(start, ended=frozenset(ended))
        helped = _helped(obligations, list(found), ask)
        if not helped:
            break
        chosen = max(helped, key=lambda name: (len(helped[name]), -list(helped).index(name)))
        wanted = helped[chosen] or [rule for rule in found if chosen in obligations.about(rule)]
        ended[chosen] = tuple(dict.fromkeys(rule.name for rule in wanted))
        _, found = _ask(replace(start, ended=frozenset(ended)), tuple(found), ask)
    names = tuple(dict.fromkeys(rule.name for rule in found))
    return SwapAnswer(worst(found.values()), ended, names, asked, len({rule.name for rule in rules}), _forgotten(carry))


def _ask(obligations: Obligations, rules: tuple[Rule, ...], ask: AskProperties) -> tuple[int, dict[Rule, Verdict]]:
    """Return how many rules, by name, needed a check, and the verdicts of the rules that may be broken."""
    known = list(obligations.properties(rules))
    verdicts = ask(tuple(prop for _, prop in known if prop is not None))
    found: dict[Rule, Verdict] = {rule: "unknown" if prop is None else verdicts[prop.name] for rule, prop in known}
    broken: dict[Rule, Verdict] = {rule: verdict for rule, verdict in found.items() if verdict != "holds"}
    return len({rule.name for rule, _ in known}), broken


def _helped(before: Obligations, rules: list[Rule], ask: AskProperties) -> dict[str, list[Rule]]:
    """Return by request the rules that are not broken once it has ended, too; empty if some rule depends on none."""
    about = [before.about(rule) for rule in rules]
    if not all(about):
        return {}
    names = [r.name for r in before.carry.old.model.requests if any(r.name in each for each in about)]
    asked: dict[str, Property] = {}
    helped: dict[str, list[Rule]] = {name: [] for name in names}
    waiting: list[tuple[str, str, Rule]] = []
    for name in names:
        mine = tuple(rule for rule, each in zip(rules, about, strict=True) if name in each)
        open_ones = dict(replace(before, ended=before.ended | {name}).properties(mine))
        helped[name] += [rule for rule in mine if rule not in open_ones]
        for rule, prop in open_ones.items():
            if prop is not None:
                key = f"{prop.name} without {name}"
                asked[key] = replace(prop, name=key)
                waiting.append((key, name, rule))
    verdicts = ask(tuple(asked.values()))
    for key, name, rule in waiting:
        if verdicts[key] == "holds":
            helped[name].append(rule)
    return helped


def _forgotten(carry: Carry) -> tuple[str, ...]:
    told = (_called(number) for number in carry.after if not carry.remembers(number) and _matters(number, carry))
    return tuple(dict.fromkeys(told))


def _matters(number: RecordField, carry: Carry) -> bool:
    match number:
        case CarriedReading(name, how):
            is_latch = any(latch.name == name for latch in carry.new.model.latches)
            return how != "unread" and (not is_latch or any(latch.name == name for latch in carry.old.model.latches))
        case CarriedLevel(_, kept):
            return kept
        case CarriedLast(request, kept):
            return kept and request in carry.old.model.request
        case CarriedPast(request, _):
            return request in carry.old.model.request
        case _:
            return False


def _called(number: RecordField) -> str:
    match number:
        case CarriedReading(name):
            return name
        case CarriedLevel(resource):
            return resource
        case CarriedLast(request):
            return f"last({request})"
        case CarriedPast(request):
            return f"past({request})"
        case _:
            raise TypeError(number)
