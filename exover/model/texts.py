"""Events and actions as JSON texts, equal to `json.dumps` of their objects, made from cached templates."""

import json
from collections.abc import Callable, Hashable, Iterable
from dataclasses import replace
from typing import Any

from exover.model.event import Action, Args, Ask, Event, Launched, Observe, Report
from exover.model.model import Model
from exover.model.types import Value
from exover.model.wire import action_json, event_json, number

HOLE = "\0"
"""Stands for a value in a template; no name of the language contains it."""
encode = json.JSONEncoder(ensure_ascii=False).encode
_HOLE = encode(HOLE)


class WireTexts:
    """The texts of the events and actions of one model, by a template for each event or action without its values."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._templates: dict[Hashable, str] = {}

    def decision(self, event: Event, actions: Iterable[Action]) -> str:
        """Return the text of an object with an event and the actions that answered it."""
        return f'{{"event": {self.event(event)}, "actions": [{", ".join(map(self.action, actions))}]}}'

    def event(self, event: Event) -> str:
        """Return the text of `event_json`."""
        match event:
            case Ask(name, args):
                return self._filled(name, args, event_json, event, "args")
            case Report(name, slot, "ok", results):
                return self._filled((name, slot), results, event_json, event, "results")
            case Observe(_, value, False):
                return f'{{"observe": {encode(event.name)}, "value": {value_text(value)}}}'
            case _:
                return self._filled(event, (), event_json, event)

    def action(self, action: Action) -> str:
        """Return the text of `action_json`."""
        if isinstance(action, Launched):
            said = (action.request, action.slot, action.rule, action.because, action.launch_rule)
            return self._filled(said, action.args, action_json, action, "args")
        return self._filled(action, (), action_json, action)

    def _filled(
        self, key: Hashable, values: Args, json_of: Callable[[Model, Any], Any], said: Any, name: str = ""
    ) -> str:
        """Return the text of `json_of(said)`, where the field `name` of `said` holds `values`.

        `key` identifies the template: equal for what differs only in these values. Without `name` there are none.
        """
        template = self._templates.get(key)
        if template is None:
            open_one = replace(said, **{name: (HOLE,) * len(values)}) if name else said
            text = encode(json_of(self._model, open_one))
            template = self._templates[key] = text.replace("%", "%%").replace(_HOLE, "%s")
        return template % tuple(map(value_text, values))


def value_text(value: Value) -> str:
    """Return a value as JSON."""
    return repr(number(value)) if isinstance(value, float) else encode(value)
