"""An explanation for people, and as JSON."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import groupby
from typing import Any

from exover.model.event import Action, Invalid
from exover.model.explanation import Account, Attempt, CounterfactualSearch, Demand, Explanation, Fact, RuleVerdict
from exover.model.model import Model
from exover.model.wire import action_json, escaped, event_json
from exover.model.wording import action_text, event_text, visible

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
"""Characters of a rule's text that are shown; the list of a mutex may be long."""
MANY = 8
"""Facts of one voice, and voices of one kind, that the text shows; the JSON object has all."""


# ---- text ----


def render_text(model: Model, explanation: Explanation) -> str:
    """Return the explanation as text with a final newline."""
    return "".join(f"{visible(line)}\n" for line in _lines(model, explanation))


def _lines(model: Model, explanation: Explanation) -> Iterator[str]:
    event = "an event that cannot be read" if explanation.event is None else event_text(model, explanation.event)
    yield f"step {explanation.step}: {event}"
    for action in explanation.actions:
        yield f"  {action_text(model, action)}"
    for account in explanation.accounts:
        yield ""
        yield from _account(model, account)
    if explanation.search:
        yield ""
        yield from _search(model, explanation.search)


def _account(model: Model, account: Account) -> Iterator[str]:
    yield f"why {_short(model, account.action) if account.action else 'nothing was done'}: {account.text}"
    for voice in account.deciding:
        yield from _voice(voice)
    yield from _heard((voice for voice in account.others if voice.demand != "nothing"), "also ")
    yield from _heard((voice for voice in account.others if voice.demand == "nothing"), "")


def _heard(voices: Iterable[RuleVerdict], word: str) -> Iterator[str]:
    """Yield the voices, those of one rule together: the pairs of a mutex."""
    for _, group in groupby(voices, key=lambda voice: (voice.rule, voice.demand)):
        same = list(group)
        facts = tuple(dict.fromkeys(fact for voice in same for fact in voice.facts))
        yield from _voice(replace(same[0], facts=facts), word)


def _voice(voice: RuleVerdict, word: str = "") -> Iterator[str]:
    """Yield what a rule says, its text, the facts, and its remedies."""
    because = "" if voice.because is None else f": {voice.because}"
    yield f"  {word}{voice.rule} {DEMANDS[voice.demand]}{because}"
    if voice.written:
        cut = voice.written if len(voice.written) <= LONG else f"{voice.written[: LONG - 1]}…"
        yield f"    {voice.location.file}:{voice.location.line}: {cut}"
    yield f"    {voice.moment}"
    yield from (f"      {_fact(fact)}" for fact in voice.facts[:MANY])
    if len(voice.facts) > MANY:
        yield f"      and {len(voice.facts) - MANY} more"
    yield from (f"    {_attempt(attempt)}" for attempt in voice.attempts)


def _fact(fact: Fact) -> str:
    return f"{fact.condition} is {'true' if fact.holds else 'false'}" + (f": {fact.read}" if fact.read else "")


def _attempt(attempt: Attempt) -> str:
    return f"remedy {attempt.remedy} {'is taken' if attempt.chosen else 'does not apply'}: {attempt.note}"


def _short(model: Model, action: Action) -> str:
    """Return an action without its rule and detail."""
    return f"invalid {action.code}" if isinstance(action, Invalid) else action_text(model, action).partition(" [")[0]


def _search(model: Model, search: CounterfactualSearch) -> Iterator[str]:
    changes = f"{search.tried} change{'' if search.tried == 1 else 's'}"
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
    return escaped(json.dumps(told, ensure_ascii=False, indent=1)) + "\n"


def _account_json(model: Model, account: Account) -> dict[str, Any]:
    return {
        "action": action_json(model, account.action) if account.action else None,
        "text": account.text,
        "deciding": [_voice_json(voice) for voice in account.deciding],
        "others": [_voice_json(voice) for voice in account.others],
    }


def _voice_json(voice: RuleVerdict) -> dict[str, Any]:
    location = voice.location
    return {
        "rule": voice.rule,
        "because": voice.because,
        "written": voice.written,
        "location": {"file": location.file, "line": location.line, "column": location.column},
        "demand": voice.demand,
        "moment": voice.moment,
        "facts": [{"condition": fact.condition, "holds": fact.holds, "read": fact.read} for fact in voice.facts],
        "remedies": [{"remedy": a.remedy, "chosen": a.chosen, "note": a.note} for a in voice.attempts],
    }


def _search_json(model: Model, search: CounterfactualSearch) -> dict[str, Any]:
    turns = [
        {"if": list(turn.changes), "actions": [action_json(model, action) for action in turn.actions]}
        for turn in search.turns
    ]
    return {"turns": turns, "tried": search.tried, "quantities": search.most, "complete": search.complete}
