"""An explanation as text and as JSON."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import groupby
from typing import Any

from exover.escaping import visible_lines
from exover.model.event import Action, Invalid
from exover.model.explanation import Account, Attempt, CounterfactualSearch, Demand, Explanation, Fact, RuleVerdict
from exover.model.model import Model
from exover.model.wire import action_json, event_json, indented
from exover.model.wording import action_text, counted, event_text

DEMANDS: dict[Demand, str] = {
    "nothing": "does not object",
    "reject": "rejects it",
    "wait": "makes it wait",
    "settle": "makes it wait until its way is clear",
    "clear": "has its way cleared",
    "dismiss": "gives up what waits",
    "kill": "is broken",
    "launch": "asks for it",
    "violation": "is broken",
}
LONG = 160
"""The most characters of a rule's text that are shown; the list of a mutex may be long."""
MANY = 8
"""The most facts of one verdict that the text shows; the JSON object has all."""


# ---- text ----


def render_text(model: Model, explanation: Explanation) -> str:
    """Return the explanation as text with a final newline."""
    return visible_lines(_lines(model, explanation))


def _lines(model: Model, explanation: Explanation) -> Iterator[str]:
    yield f"step {explanation.step}: {_title(model, explanation)}"
    for action in explanation.actions:
        yield f"  {action_text(model, action)}"
    for action in explanation.unanswered:
        yield f"  {action_text(model, action)}, as before: not answered again"
    for account in explanation.accounts:
        yield ""
        yield from _account(model, account)
    if explanation.search:
        yield ""
        yield from _search(model, explanation.search)


def _title(model: Model, explanation: Explanation) -> str:
    match explanation.event, explanation.actions:
        case None, (Invalid("bad-event"), *_):
            return "an event that cannot be read"
        case None, _:
            return "an invalid event"
        case event, _:
            return event_text(model, event)


def _account(model: Model, account: Account) -> Iterator[str]:
    yield f"why {_short(model, account.action) if account.action else 'nothing was done'}: {account.text}"
    for verdict in account.deciding:
        yield from _verdict(verdict)
    besides = "also " if account.deciding else ""
    yield from _grouped((verdict for verdict in account.others if verdict.demand != "nothing"), besides)
    yield from _grouped((verdict for verdict in account.others if verdict.demand == "nothing"), "")


def _grouped(verdicts: Iterable[RuleVerdict], word: str) -> Iterator[str]:
    """Yield the lines of the verdicts; adjacent ones of one rule, as the pairs of a mutex, are joined."""
    for _, group in groupby(verdicts, key=lambda verdict: (verdict.rule, verdict.demand)):
        same = list(group)
        facts = tuple(dict.fromkeys(fact for verdict in same for fact in verdict.facts))
        yield from _verdict(replace(same[0], facts=facts), word)


def _verdict(verdict: RuleVerdict, word: str = "") -> Iterator[str]:
    """Yield the lines of a verdict: what the rule demands, its text, the moment, the facts and the remedies."""
    because = "" if verdict.because is None else f": {verdict.because}"
    yield f"  {word}{verdict.rule} {DEMANDS[verdict.demand]}{because}"
    if verdict.written:
        cut = verdict.written if len(verdict.written) <= LONG else f"{verdict.written[: LONG - 1]}…"
        yield f"    {verdict.location.file}:{verdict.location.line}: {cut}"
    yield f"    {verdict.moment}"
    yield from (f"      {_fact(fact)}" for fact in verdict.facts[:MANY])
    if len(verdict.facts) > MANY:
        yield f"      and {len(verdict.facts) - MANY} more"
    yield from (f"    {_attempt(attempt)}" for attempt in verdict.attempts)


def _fact(fact: Fact) -> str:
    return f"{fact.condition} is {'true' if fact.holds else 'false'}" + (f": {fact.read}" if fact.read else "")


def _attempt(attempt: Attempt) -> str:
    return f"remedy {attempt.remedy} {'is taken' if attempt.chosen else 'does not apply'}: {attempt.note}"


def _short(model: Model, action: Action) -> str:
    """Return an action without its rule and detail."""
    return f"invalid {action.code}" if isinstance(action, Invalid) else action_text(model, action).partition(" [")[0]


def _search(model: Model, search: CounterfactualSearch) -> Iterator[str]:
    changes = counted(search.tried, "change")
    if search.turns:
        yield f"what would have turned the answer ({changes} tried):"
        for turn in search.turns:
            answer = "; ".join(action_text(model, action) for action in turn.actions) or "no action"
            yield f"  if {' and '.join(turn.changes)}: {answer}"
    elif not search.tried:
        yield "nothing in the state could have turned the answer"
    else:
        yield f"nothing that was tried would have turned the answer: {changes} of up to {_quantities(search.most)}"
    if not search.complete:
        yield "  the search was cut there; further changes were not tried"


def _quantities(count: int) -> str:
    return "one quantity" if count == 1 else f"{count} quantities"


# ---- JSON ----


def render_json(model: Model, explanation: Explanation) -> str:
    """Return the explanation as one JSON object with a final newline (docs/traces.md)."""
    search = explanation.search
    told = {
        "step": explanation.step,
        "event": event_json(model, explanation.event) if explanation.event else None,
        "actions": [action_json(model, action) for action in explanation.actions],
        "why": [_account_json(model, account) for account in explanation.accounts],
        "search": _search_json(model, search) if search else None,
    }
    return indented(told)


def _account_json(model: Model, account: Account) -> dict[str, Any]:
    return {
        "action": action_json(model, account.action) if account.action else None,
        "text": account.text,
        "deciding": [_verdict_json(verdict) for verdict in account.deciding],
        "others": [_verdict_json(verdict) for verdict in account.others],
    }


def _verdict_json(verdict: RuleVerdict) -> dict[str, Any]:
    location = verdict.location
    return {
        "rule": verdict.rule,
        "because": verdict.because,
        "written": verdict.written,
        "location": {"file": location.file, "line": location.line, "column": location.column},
        "demand": verdict.demand,
        "moment": verdict.moment,
        "facts": [{"condition": fact.condition, "holds": fact.holds, "read": fact.read} for fact in verdict.facts],
        "remedies": [{"remedy": a.remedy, "chosen": a.chosen, "note": a.note} for a in verdict.attempts],
    }


def _search_json(model: Model, search: CounterfactualSearch) -> dict[str, Any]:
    turns = [
        {"if": list(turn.changes), "actions": [action_json(model, action) for action in turn.actions]}
        for turn in search.turns
    ]
    return {"turns": turns, "tried": search.tried, "quantities": search.most, "complete": search.complete}
