"""A run from a black box as text: each step with its recorded answers, and where the reference interpreter differs."""

import json
from collections.abc import Iterable, Iterator

from exover.escaping import visible
from exover.model.event import Invalid
from exover.model.model import Model
from exover.model.replayed import BareAction, Replayed
from exover.model.wording import event_text, slot_text


def run_lines(model: Model, steps: Iterable[Replayed]) -> Iterator[str]:
    """Yield a line for each event, and below it one for each recorded answer and each fault or difference."""
    for step in steps:
        read = step.read
        event = json.dumps(step.event) if isinstance(read, Invalid) else event_text(model, read)
        yield visible(f"{step.number}. {event}")
        for said in step.recorded or ():
            yield visible(f"     {_text(model, said)}")
        for wrong in _wrong(model, step):
            yield visible(f"   ! {wrong}")


def _wrong(model: Model, step: Replayed) -> Iterator[str]:
    if step.recorded is None:
        yield "this step was not answered: the checker was stopped in it, or what follows is not whole"
    elif step.fault:
        yield f"the checker was faulty: {step.fault}"
    elif not step.agrees:
        expected = "; ".join(_text(model, said) for said in step.expected or ()) or "nothing"
        yield f"the reference answers otherwise: {expected}"


def _text(model: Model, said: BareAction) -> str:
    subject = said.request or ""
    if said.slot is not None and subject in model.request:
        subject = slot_text(model, subject, said.slot)
    origin = f" of {said.launch_rule}" if said.launch_rule and said.launch_rule != said.rule else ""
    why = f" [{said.rule}]" if said.rule else ""
    return f"{said.verb} {subject}".rstrip() + origin + why
