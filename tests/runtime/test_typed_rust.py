"""The typed API in Rust: every method answers as the generic API does, and cycles as their events one after another."""

import re
import subprocess
from collections.abc import Sequence
from pathlib import Path
from shutil import which

import pytest

from exover.bounds.events import bounds
from exover.emit import rust
from exover.emit.events import EventCall, Statuses, calls, structs
from exover.emit.identifiers import constants
from exover.emit.rustnames import START, variants
from exover.emit.rusttyped import method, taken, type_names
from exover.engines.compiler import compile_in
from exover.model.event import Abort, AbortWaiting, Ask, Event, Observe, Report
from exover.model.model import Parameter
from exover.model.types import Bool, Enum, Int, Real, Type, Value, ordinal
from exover.pipeline import Build, build
from exover.run.rust import FLAGS, build_crate, find_rustc
from tests.bounds.counting import random_events
from tests.emit.odd import ODD, speaking
from tests.runtime.compiling import ROOT, built, model_of

pytestmark = pytest.mark.skipif(which("rustc") is None, reason="rustc is not installed")
WORDS = """spec words; poster level: int in 0 .. 5 = 0; poster fn: bool = false;
module impl { request loop(type: int in -5 .. 5, in_: real, move: {self_, Self}) returns (ref: bool) fails (match)
    { wait until level < 3; interrupts self; } request r() instances 2; }"""
MAIN = """#![allow(unused)]
use native::{api::*, Action, Checker, Outcome, Poster, Request, Stock, Value, TABLES, TABLE_BYTES};

fn main() {
    let (mut typed, mut plain) = (Checker::new(&TABLES), Checker::new(&TABLES));
    let mut said: Vec<Action> = Vec::new();
    typed.load();
    plain.load();
    for step in [STEPS] {
        step(&mut typed, &mut plain, &mut said);
    }
    let mut cycled: Vec<Action> = Vec::new();
    let mut events: Vec<Event> = Vec::new();
    for part in [PARTS] {
        part(&mut events);
    }
    typed.load_stopped();
    typed.cycle(&events, |_, answers| cycled.extend(answers));
    assert_eq!(said, cycled);
    assert_eq!((TABLE_BYTES, Checker::BYTES), (std::mem::size_of_val(&TABLES), std::mem::size_of_val(&typed)));
    println!("{}", said.iter().filter(|action| matches!(action, Action::Launch { .. })).count());
}
"""
COMPARE = """
fn compare(typed: &Checker, plain: &Checker) {
ARGUMENTS
}
"""
STEP = """
fn stepNUMBER(typed: &mut Checker, plain: &mut Checker, said: &mut Vec<Action>) {
CALLS
}

fn partNUMBER(events: &mut Vec<Event>) {
    events.extend([EVENTS]);
}
"""
FEW = 10
"""Events in a function: what the compiler takes for one grows faster than its length."""


class Writer:
    """Writes events as calls of both APIs, and as elements of a buffer."""

    def __init__(self, found: Build) -> None:
        self.model = found.model
        self.known = constants(found.model, START)
        self.types = type_names(self.known)
        every = [event for _, group in calls(found.model, bounds(found.tables), taken(self.known)) for event in group]
        self.calls = {(call.does, call.number): call for call in every}
        methods = [method(call, self.known) for call in every]
        self.variants = dict(zip(methods, variants(methods), strict=True))
        self.request = {request.name: number for number, request in enumerate(found.model.requests)}
        self.posters = [v.name for v in found.model.variables if v.kind == "poster"]
        self.stocks = [resource.name for resource in found.model.resources if resource.consumable]

    def typed(self, kind: Type, value: Value) -> str:
        match kind:
            case Bool():
                return str(value).lower()
            case Enum():
                return f"{self.types.enums[kind]}::ALL[{ordinal(kind, value)}]"
            case Int():
                return str(value)
            case Real():
                return f"{float(value)!r}"

    def plain(self, kind: Type, value: Value) -> str:
        number = f"{float(value)!r}" if isinstance(kind, Real) else f"{ordinal(kind, value)}_i64"
        return f"Value::from({number})"

    def both(self, params: Sequence[Parameter], values: Sequence[Value]) -> tuple[list[str], str]:
        pairs = list(zip((p.type for p in params), values, strict=True))
        return [self.typed(*pair) for pair in pairs], ", ".join(self.plain(*pair) for pair in pairs)

    def parts(self, event: Event) -> tuple[EventCall, int | None, list[str], str]:
        """Return the typed call with slot and values, and the generic one."""
        match event:
            case Ask(name, args):
                number = self.request[name]
                typed, plain = self.both(self.model.requests[number].params, args)
                return self.calls["ask", number], None, typed, f"ask(Request::ALL[{number}], &[{plain}])"
            case Report(name, slot, outcome, results, status):
                number, request = self.request[name], self.model.request[name]
                typed, plain, said = [], "Outcome::Interrupted", None
                if outcome == "ok":
                    typed, plain = self.both(request.results, results)
                    plain = f"Outcome::Ok(&[{plain}])"
                elif outcome == "failed":
                    said = None if status is None else request.statuses.index(status)
                    plain = f"Outcome::Failed({'None' if said is None else f'Some({said})'})"
                    kind = self.types.enums[Statuses(number)]
                    if request.statuses:
                        typed = ["None" if said is None else f"Some({kind}::ALL[{said}])"]
                return self.calls[outcome, number], slot, typed, f"report(Request::ALL[{number}], {slot}, {plain})"
            case Observe(name, value) if name in self.stocks:
                number = self.stocks.index(name)
                return self.calls["level", number], None, [str(value)], f"observe_level(Stock::ALL[{number}], {value})"
            case Observe(name, value):
                number, kind = self.posters.index(name), self.model.variable[name].type
                plain = f"observe(Poster::ALL[{number}], {self.plain(kind, value)})"
                return self.calls["observe", number], None, [self.typed(kind, value)], plain
            case Abort(name, slot):
                number = self.request[name]
                return self.calls["abort", number], slot, [], f"abort(Request::ALL[{number}], {slot})"
            case AbortWaiting(name):
                number = self.request[name]
                return self.calls["abort_waiting", number], None, [], f"abort_waiting(Request::ALL[{number}])"

    def call(self, event: Event) -> str:
        call, slot, typed, plain = self.parts(event)
        given = [*([str(slot)] if call.has_slot else []), *typed]
        said = "    said.extend(plain.actions());"
        return f"    assert_eq!(typed.{method(call, self.known)}({', '.join(given)}), plain.{plain});\n{said}"

    def element(self, event: Event) -> str:
        call, slot, typed, _ = self.parts(event)
        members = [*([f"slot: {slot}"] if call.has_slot else [])]
        members += [f"{field.name}: {value}" for field, value in zip(call.fields, typed, strict=True)]
        return f"Event::{self.variants[method(call, self.known)]} {{ {', '.join(members)} }}"

    def arguments(self) -> str:
        """Return the lines that compare what is told of the arguments of all slots."""
        lines = []
        for number, ((args, _), names) in enumerate(
            zip(structs(self.model, taken(self.known)), self.known.typed, strict=True)
        ):
            request = self.model.requests[number]
            for slot in range(request.instances if args.fields else 0):
                read = f"typed.{names.read.removeprefix('x_')}({slot if request.instances > 1 else ''})"
                bits = [
                    f"Value::from(at.{field.name}{'' if field.type in ('double', 'bool') else ' as i64'})"
                    for field in args.fields
                ]
                told = f"{read}.map(|at| vec![{', '.join(bits)}])"
                lines.append(
                    f"    assert_eq!({told}, plain.args(Request::ALL[{number}], {slot}).map(|at| at.to_vec()));"
                )
        return "\n".join(lines)


def crate(found: Build, folder: Path, *flags: str) -> None:
    build_crate(found.model, found.tables, "checked", folder, (*FLAGS, "-Dwarnings", *flags))


def program(writer: Writer, events: Sequence[Event]) -> str:
    """Return the program that takes events by both APIs, a few of them in a function."""
    numbers = range(len(range(0, len(events), FEW)))
    text = MAIN + COMPARE.replace("ARGUMENTS", writer.arguments())
    for number in numbers:
        few = events[number * FEW : (number + 1) * FEW]
        calls = "\n".join(f"{writer.call(event)}\n    compare(typed, plain);" for event in few)
        part = STEP.replace("NUMBER", str(number)).replace("CALLS", calls)
        text += part.replace("EVENTS", ", ".join(map(writer.element, few)))
    for name, function in (("STEPS", "step"), ("PARTS", "part")):
        text = text.replace(name, ", ".join(f"{function}{number}" for number in numbers))
    return text


@pytest.mark.parametrize(
    "text",
    [*((ROOT / "tests" / "vectors" / f"{name}.exo").read_text("utf-8") for name in ("rover", "corners")), WORDS],
    ids=["rover", "corners", "words"],
)
def test_every_event_is_that_of_the_generic_api(text: str, tmp_path: Path) -> None:
    found = build(model_of(text))
    build_crate(found.model, found.tables, "native", tmp_path)
    events = [e for e in random_events(found.model, 7, 300) if not isinstance(e, Observe) or not e.broken]
    writer = Writer(found)
    (tmp_path / "main.rs").write_text(program(writer, events), encoding="utf-8")
    command = [*find_rustc(), "--edition=2021", "--extern=native=libnative.rlib", *FLAGS, "main.rs"]
    compile_in(tmp_path, command, "main", "Rust")
    ran = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True)
    assert int(ran.stdout) > 5
    kinds = {(type(event), getattr(event, "outcome", "")) for event in events}
    assert len(kinds) > 5


@pytest.mark.parametrize("text", [ODD, "spec least; module m { request r(); }"], ids=["odd", "least"])
def test_odd_names_compile(text: str, tmp_path: Path) -> None:
    """No code is made of them: all that is said of names is said before."""
    crate(build(model_of(text)), tmp_path, "--emit=metadata")


KEPT = (
    "as async await become box crate do dyn final gen impl let loop macro match mod move mut override priv pub ref "
    "super trait try type typeof unsafe unsized use virtual where yield union raw safe auto default macro_rules "
    "Self self_ None Some Ok Err Vec Box String Result Option drop Drop Fn FnMut Copy Clone Into From TryFrom"
)
"""Words of Rust, and names that are there without being imported."""
LIKE_THINGS = """spec x;
enum FnMut { ALL, Self, None, some, Ok } enum ALL { Err, all } enum Value { a } enum None { b } enum Clone { c }
poster ALL: ALL = all; poster Self: FnMut = some; resource None: 5 consumable; resource Some: 5 consumable;
module Self { request ALL(x: FnMut, y: Value, z: None, t: Clone) returns (u: ALL) fails (ALL, None, Self) instances 2;
    request None(); request Self(); }
module crate { request super(); request None(); } module ALL { request r(); } module None { request Some(); }
mutex ALL: Self.ALL, Self.None; mutex Self: Self.None, Self.Self;
"""


@pytest.mark.parametrize("flags", [(), ("--cfg", 'feature="names"', "--cfg", 'feature="black-box"')], ids=["", "all"])
def test_a_parameter_may_be_called_like_anything_that_the_emitted_code_uses(
    flags: tuple[str, ...], tmp_path: Path
) -> None:
    found = build(model_of(speaking("abcde")))
    texts = {artefact.name: artefact.content.decode() for artefact in rust.emit(found.model, found.tables, "x")}
    words = {word for name in ("api", "names") for word in re.findall(r"[A-Za-z_]\w*", texts[f"src/{name}.rs"])}
    assert {"Value", "self", "Some", "i64", "usize", "Kind"} < words
    crate(build(model_of(speaking(words | set(KEPT.split())))), tmp_path, "--emit=metadata", *flags)


def test_things_may_be_called_like_words_of_rust(tmp_path: Path) -> None:
    crate(build(model_of(LIKE_THINGS)), tmp_path, "--emit=metadata", "--cfg", 'feature="names"')


def test_the_module_tells_ranges_types_and_bounds() -> None:
    found = built(ROOT / "specs" / "rover.exo")
    (text,) = [a.content.decode() for a in rust.emit(found.model, found.tables, "rover") if a.name == "src/api.rs"]
    known = bounds(found.tables).asks[[r.name for r in found.model.requests].index("nd.goto")]
    assert (
        f"""    /// Somebody asks for nd.goto. `x`: -50 .. 50; `y`: -50 .. 50; `v`: 0 .. 1.5.
    /// Bound: {known.tests} tests, {known.answers} answers.
    pub fn ask_nd_goto(&mut self, x: f64, y: f64, v: f64) -> &[Action] {{"""
        in text
    )
    assert "pub fn report_nd_goto_failed(&mut self, status: Option<NdGotoStatus>) -> &[Action]" in text
    assert "pub fn args_nd_goto(&self) -> Option<NdGotoArgs>" in text
