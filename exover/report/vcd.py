"""A run as a value change dump (IEEE 1364-2005 section 18), for waveform viewers.

There is a scope for each module; in it a signal for each slot and each waiting place, each poster and each state.
Phases, values of enums, events and answers are of type `string`, which the standard lacks and the viewers read
(GTKWave's extension); blanks, which end such a value, are written as underscores. Time counts steps: #0 is the start.
"""

import re
from collections.abc import Iterator

from exover.dataclass import dataclass
from exover.model.evaluate import NOTHING, value_of
from exover.model.expression import Used
from exover.model.index import ModelIndex
from exover.model.model import Model
from exover.model.state import State
from exover.model.types import Bool, Enum, Int, Real, Type, Value
from exover.model.wording import action_text, event_text
from exover.report.story import Scene, Story, place_text

WORD = Enum(("",))
"""The type of a signal whose values are texts."""
SMALL = 1 << 31


@dataclass(frozen=True, slots=True)
class Signal:
    """A signal: its module (empty: none), its name, and its value at each moment."""

    module: str
    name: str
    type: Type
    values: tuple[Value, ...]


def render(title: str, version: str, story: Story) -> str:
    """Return the dump with a final newline; it has no date, so that equal runs have equal bytes."""
    signals = list(_signals(story))
    codes = [_code(index) for index in range(len(signals))]
    lines = [f"$version exover {version} $end", f"$comment {_comment(title)} $end"]
    if story.loop_start is not None:
        lines.append(f"$comment steps {story.loop_start + 1} to {len(story.scenes)} are repeated for ever $end")
    lines += ["$timescale 1 us $end", *_declarations(story.model, signals, codes), "$enddefinitions $end"]
    for moment in range(len(story.states)):
        changed = [
            _change(signal.type, signal.values[moment], code)
            for signal, code in zip(signals, codes, strict=True)
            if moment == 0 or signal.values[moment] != signal.values[moment - 1]
        ]
        lines += [f"#{moment}", *(["$dumpvars", *changed, "$end"] if moment == 0 else changed)]
    return "\n".join([*lines, f"#{len(story.states)}"]) + "\n"


# ---- signals ----


def _signals(story: Story) -> Iterator[Signal]:
    """Yield the signals, those outside modules first, the others in the order of the spec."""
    model, states = story.model, story.states
    yield Signal("", "event", WORD, ("-", *(event_text(model, scene.event) for scene in story.scenes)))
    yield Signal("", "answer", WORD, ("-", *(_answer(model, scene) for scene in story.scenes)))
    if story.loop_start is not None:
        inside = (moment > story.loop_start for moment in range(len(states)))
        yield Signal("", "loop", Bool(), tuple(inside))
    for name, kind in ModelIndex(model).typed_readings:
        module, _, short = name.rpartition(".")
        yield Signal(module, short, kind, tuple(state.readings[name] for state in states))
    for resource in model.resources:
        kind = Int(0, resource.capacity)
        if resource.consumable:
            yield Signal("", f"level_{resource.name}", kind, tuple(state.levels[resource.name] for state in states))
        else:
            used = tuple(value_of(model, state, Used(resource.name), NOTHING) for state in states)
            yield Signal("", f"used_{resource.name}", kind, used)
    for request in model.requests:
        module, _, short = request.name.rpartition(".")
        for slot in range(request.instances):
            name = short if request.instances == 1 else f"{short}_{slot}"
            yield Signal(module, name, WORD, tuple(_phase(state, request.name, slot) for state in states))
        places = tuple(place_text(state.places[request.name]) for state in states)
        yield Signal(module, f"{short}_place", WORD, places)


def _phase(state: State, request: str, slot: int) -> str:
    content = state.slots[request][slot]
    return content.phase if content else "idle"


def _answer(model: Model, scene: Scene) -> str:
    return "; ".join(action_text(model, action) for action in scene.actions) or "-"


# ---- text ----


def _declarations(model: Model, signals: list[Signal], codes: list[str]) -> Iterator[str]:
    """Yield the scopes with their signals; a name that its scope has already gets underscores."""
    yield f"$scope module {model.name} $end"
    modules = dict.fromkeys(signal.module for signal in signals)
    for module in sorted(modules, key=bool):
        taken: set[str] = set(modules) if not module else set()
        if module:
            yield f"$scope module {module} $end"
        for signal, code in zip(signals, codes, strict=True):
            if signal.module == module:
                name = signal.name
                while name in taken:
                    name += "_"
                taken.add(name)
                yield f"$var {_declared(signal.type)} {code} {name} $end"
        if module:
            yield "$upscope $end"
    yield "$upscope $end"


def _declared(kind: Type) -> str:
    """Return the type and the size of a signal."""
    match kind:
        case Bool():
            return "wire 1"
        case Int(low, high):
            return "integer 32" if low >= -SMALL and high < SMALL else "integer 64"
        case Real():
            return "real 64"
        case Enum():
            return "string 1"


def _change(kind: Type, value: Value, code: str) -> str:
    """Return the line that gives a signal a value."""
    match kind:
        case Bool():
            return f"{int(value)}{code}"
        case Int():
            size = 32 if _declared(kind) == "integer 32" else 64
            return f"b{int(value) % (1 << size):b} {code}"
        case Real():
            return f"r{float(value):.17g} {code}"
        case Enum():
            return f"s{_word(str(value))} {code}"


def _word(text: str) -> str:
    """Return a text with underscores in place of blanks and unprintable characters."""
    return "".join(character if character.isprintable() and not character.isspace() else "_" for character in text)


def _comment(text: str) -> str:
    """Return a text for a comment, which `$end` would end."""
    return re.sub(r"\$+end", "end", " ".join(text.split()))


def _code(index: int) -> str:
    """Return the identifier code of a signal: a number to the base of the 94 printable characters, from `!` on."""
    code = chr(33 + index % 94)
    while index >= 94:
        index = index // 94 - 1
        code = chr(33 + index % 94) + code
    return code
