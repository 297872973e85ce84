"""A small robot and its binding, which tests change."""

import json
from collections.abc import Mapping
from typing import Any

from exover.gate.binding import Binding
from exover.gate.gate import Journal
from exover.gate.reading import read_binding
from exover.model.model import Model
from exover.pipeline import load
from exover.source import Source

SPEC = """spec cart;
module base {
    poster speed: real in 0 .. 2 = 0 else 2;
    request move(v: real in 0 .. 1.2) returns (distance: real in 0 .. 100) fails (blocked) { interrupts self; }
    request stop() { interrupts base.move; }
}
module arm {
    request reach(side: {left, right}) { wait until not active(base.move) because "reaching needs a base that stands"; }
    request grip(force: int in 0 .. 10) instances 2;
}
resource paint: 5 consumable;
"""
BIND = """[gate]
spec = "cart"
pass = ["get_*"]
start = "idle"
wait = 30

[watch.state]
tool = "get_state"

[request."base.move"]
tool = "drive"
when = { command = "move" }
arguments = { v = { field = "speed_percent", scale = 0.01 } }
started = true
cancel = { tool = "drive", arguments = { command = "halt" } }

[request."base.move".report]
watch = "state"
status = "base.phase"
running = ["moving"]
ok = ["arrived"]
interrupted = ["halted"]
fails = { blocked = ["bumper"] }
results = { distance = "base.metres" }

[request."base.stop"]
tool = "brake"
cancel = { tool = "release", ends = true }

[request."arm.reach"]
tool = "reach"
arguments = { side = { field = "hand", values = { l = "left", r = "right" } } }
cancel = { tool = "stow", ends = true }

[request."arm.grip"]
tool = "grip"
cancel = { tool = "open", ends = true }

[poster."base.speed"]
watch = "state"
field = "base.speed_mm"
scale = 0.001

[poster.paint]
watch = "state"
"""


def model_of(text: str) -> Model:
    """Return the model of a spec without mistakes."""
    loaded = load(Source("cart.exo", text))
    assert loaded.model is not None, loaded.diagnostics
    return loaded.model


def binding_of(text: str, model: Model) -> Binding:
    """Return a binding without errors."""
    binding, diagnostics = read_binding(Source("cart.bind.toml", text), model)
    assert binding is not None, diagnostics
    return binding


def kept_in(journal: list[Mapping[str, Any]]) -> Journal:
    """Return who keeps the entries of a gate as objects."""
    return lambda entry: journal.append(json.loads(entry))
