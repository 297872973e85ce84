"""Whether NEW may take over from OLD, and which requests have to end first."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from exover.loop.claim import Verdict
from exover.model.model import Rule
from exover.model.property import Property
from exover.swap.carry import Carry
from exover.swap.proof import Obligations
from exover.swap.record import Level, Number, Past, Read

Ask = Callable[[tuple[Property, ...]], Mapping[str, Verdict]]
"""What is known of properties of OLD, by their names."""


@dataclass(frozen=True)
class Answer:
    """What was found: `verdict` is `holds` iff no state of OLD breaks a rule of NEW once these requests have ended.

    `ended`: the requests of OLD that have to be idle, each with the rules of NEW for which; without one it is a request
    that means something else in NEW, or nothing. `open`: rules that may be broken whatever has ended. `asked`: how many
    rules were asked about. `forgotten`: what NEW starts with, since OLD does not remember it so.
    """

    verdict: Verdict
    ended: Mapping[str, tuple[str, ...]]
    open: tuple[str, ...]
    asked: int
    forgotten: tuple[str, ...]


def prove(carry: Carry, ask: Ask) -> Answer:
    """Return whether NEW may take over, with as few requests that have to end first as one after another gives."""
    ended: dict[str, tuple[str, ...]] = dict.fromkeys(
        (r.name for r in carry.old.model.requests if r.name in carry.changed), ()
    )
    left: set[int] | None = None
    asked = 0
    while True:
        obligations = Obligations(carry, frozenset(ended))
        known = [(rule, prop) for rule, prop in obligations.properties() if left is None or id(rule) in left]
        verdicts = ask(tuple(prop for _, prop in known if prop is not None))
        asked = asked or len(known)
        bad = [(rule, "unknown" if prop is None else verdicts[prop.name]) for rule, prop in known]
        bad = [(rule, verdict) for rule, verdict in bad if verdict != "holds"]
        left = {id(rule) for rule, _ in bad}
        chosen = _next(obligations, [rule for rule, _ in bad])
        if chosen is None:
            names = tuple(dict.fromkeys(rule.name for rule, _ in bad))
            said: set[str] = {verdict for _, verdict in bad}
            verdict: Verdict = "violated" if "violated" in said else "unknown" if said else "holds"
            return Answer(verdict, ended, names, asked, tuple(_forgotten(carry)))
        ended[chosen] = tuple(dict.fromkeys(rule.name for rule, _ in bad if chosen in obligations.about(rule)))


def _next(obligations: Obligations, rules: list[Rule]) -> str | None:
    """Return the request whose end helps most rules, the first of several; None if one of them nobody's end helps."""
    about = [obligations.about(rule) for rule in rules]
    if not about or not all(about):
        return None
    names = [name for each in about for name in each]
    return max(dict.fromkeys(names), key=names.count)


def _forgotten(carry: Carry) -> Iterable[str]:
    for number in carry.after:
        if not carry.remembers(number) and _matters(number, carry):
            yield _called(number)


def _matters(number: Number, carry: Carry) -> bool:
    match number:
        case Read(name, how):
            return how != "unread" and all(latch.name != name for latch in carry.new.model.latches)
        case Level(_, kept):
            return kept
        case Past(request, _):
            return request in carry.old.model.request
        case _:
            return False


def _called(number: Number) -> str:
    match number:
        case Read(name):
            return name
        case Level(resource):
            return resource
        case Past(request):
            return f"past({request})"
        case _:
            raise TypeError(number)
