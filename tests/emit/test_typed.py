"""The typed API: what is emitted compiles without a warning, reads alone, and answers as the reference does."""

import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from exover.emit import c
from exover.emit.identifiers import SpecIdentifiers, constants, fields
from exover.model.event import Abort, AbortWaiting, Ask, Event, Invalid, Observe, Report
from exover.model.model import Model, Parameter
from exover.model.semantics import Reference
from exover.model.types import Bool, Enum, Int, Real, Type, Value
from exover.model.wire_reading import read_event
from exover.pipeline import Build, build
from exover.run.native import NativeEngine
from tests.bounds.counting import random_events
from tests.emit.odd import ODD, speaking
from tests.runtime.compiling import COMPILERS, QUICK, ROOT, SPECS, WARNINGS, built, compile_c, model_of

HEADERS = (
    "aio", "arpa/inet", "assert", "complex", "ctype", "dirent", "errno", "fcntl", "fenv", "float", "grp", "inttypes",
    "iso646", "limits", "locale", "math", "mqueue", "net/if", "netdb", "netinet/in", "poll", "pthread", "pwd", "regex",
    "sched", "semaphore", "setjmp", "signal", "spawn", "stdalign", "stdarg", "stdatomic", "stdbool", "stddef",
    "stdint", "stdio", "stdlib", "stdnoreturn", "string", "strings", "sys/ipc", "sys/mman", "sys/msg", "sys/resource",
    "sys/select", "sys/sem", "sys/shm", "sys/socket", "sys/stat", "sys/time", "sys/times", "sys/types", "sys/uio",
    "sys/un", "sys/utsname", "sys/wait", "syslog", "termios", "tgmath", "threads", "time", "ucontext", "unistd",
    "utime", "wchar", "wctype", "wordexp",
)  # fmt: skip
"""Those of C and POSIX."""


class Translator:
    """Events as C: calls of the typed API, or elements of a buffer."""

    def __init__(self, model: Model, name: str) -> None:
        self.model = model
        self.known: SpecIdentifiers = constants(model, name)
        self.request = {request.name: index for index, request in enumerate(model.requests)}
        posters = [variable.name for variable in model.variables if variable.kind == "poster"]
        self.observe = dict(zip(posters, self.known.observe, strict=True))
        stocks = [resource.name for resource in model.resources if resource.consumable]
        self.level = dict(zip(stocks, self.known.level, strict=True))

    def parts(self, event: Event) -> tuple[str, str, list[str], list[str]]:
        """Return function, kind in a buffer, slot if there is one, and values."""
        match event:
            case Ask(name, args):
                request, names = self.model.request[name], self.known.typed[self.request[name]]
                return names.ask.function, names.ask.event, [], self._values(request.params, args)
            case Report(name, slot, outcome, results, status):
                request, names = self.model.request[name], self.known.typed[self.request[name]]
                call = {"ok": names.ok, "failed": names.failed, "interrupted": names.interrupted}[outcome]
                values = self._values(request.results, results) if outcome == "ok" else []
                if outcome == "failed" and request.statuses:
                    number = -1 if status is None else request.statuses.index(status)
                    values = [constant for constant, value in names.statuses.constants if value == number]
                return call.function, call.event, self._slot(name, slot), values
            case Observe(name, value) if name in self.level:
                return self.level[name].function, self.level[name].event, [], [str(value)]
            case Observe(name, value, broken):
                call, kind = self.observe[name], self.model.variable[name].type
                return call.function, call.event, [], [self._broken(kind) if broken else self._value(kind, value)]
            case Abort(name, slot):
                names = self.known.typed[self.request[name]]
                return names.abort.function, names.abort.event, self._slot(name, slot), []
            case AbortWaiting(name):
                names = self.known.typed[self.request[name]]
                return names.abort_waiting.function, names.abort_waiting.event, [], []

    def _slot(self, name: str, slot: int) -> list[str]:
        return [str(slot)] if self.model.request[name].instances > 1 else []

    def _values(self, params: Sequence[Parameter], values: Sequence[Value]) -> list[str]:
        return [self._value(parameter.type, value) for parameter, value in zip(params, values, strict=True)]

    def _value(self, kind: Type, value: Value) -> str:
        match kind:
            case Bool():
                return str(value).lower()
            case Enum(values):
                return self.known.enums[kind].constants[values.index(str(value))][0]
            case Int():
                return f"INT64_C({value})" if abs(int(value)) > 2**31 - 1 else str(value)
            case Real():
                return float(value).hex()

    def _broken(self, kind: Type) -> str:
        return "1.0 / zero" if isinstance(kind, Real) else str(kind.high + 1) if isinstance(kind, Int) else "2"

    def call(self, event: Event) -> str:
        function, _, slot, values = self.parts(event)
        return f"    (void){function}({', '.join(['&r2c', *slot, *values, '&answer'])}); print(&answer);"

    def element(self, event: Event, start: str) -> str:
        function, kind, slot, values = self.parts(event)
        given = ", ".join(values)
        given = (
            f"{{{given}}}" if isinstance(event, Ask) or (isinstance(event, Report) and event.outcome == "ok") else given
        )
        member = f", .of.{function.removeprefix(f'{start}_')} = {given}" if values else ""
        return f"        {{.kind = {kind}, .slot = {slot[0] if slot else 0}{member}}},"


PRINTER = """#include "x_api.h"
#include <inttypes.h>
#include <stdio.h>

static x_checker r2c;
volatile double zero = 0;

static void show(const exover_action *action)
{
    printf("%d %d %d %d %d", (int)action->kind, (int)action->request, (int)action->slot, (int)action->reason,
           (int)action->launch_rule);
    if (action->kind == EXOVER_LAUNCH)
        switch (action->request) {
@        default: break;
        }
    printf(";");
}
"""
PRINT = """static void print(const x_answer *answer)
{
    for (size_t i = 0; i < answer->count; i++)
        show(&answer->actions[i]);
    printf("\\n");
}
"""


NOTHING = """int main(void)
{
    return x_start(&r2c) != EXOVER_READY || (0 && (show(NULL), 1));
}
"""
"""A program that calls nothing else, and has what prints."""


def printer(model: Model, known: SpecIdentifiers) -> str:
    """Return the functions that print answers as runner.c does, launched arguments by the typed readers."""
    cases = []
    for request, names, (constant, _) in zip(model.requests, known.typed, known.requests, strict=True):
        if request.params:
            slot = "(int32_t)action->slot, " if request.instances > 1 else ""
            cases.append(f"        case {constant}: {{")
            cases.append(f"            {names.args} args;")
            cases.append(f"            if ({names.read}(&r2c, {slot}&args)) {{")
            for parameter, field in zip(request.params, fields(request.params, known.taken), strict=True):
                value = ".real = args." if isinstance(parameter.type, Real) else ".integer = args."
                cases.append(f'                printf(" %016" PRIx64, ((exover_value){{{value}{field}}}).bits);')
            cases += ["            }", "            break;", "        }"]
    return PRINTER.replace("@", "".join(f"{line}\n" for line in cases))


def run(found: Build, main: str, folder: Path, compiler: str = QUICK) -> list[str]:
    """Return the lines that a program with the typed API prints."""
    for artefact in c.emit(found.model, found.tables, "x"):
        (folder / artefact.name).write_bytes(artefact.content)
    (folder / "main.c").write_text(printer(found.model, constants(found.model, "x")) + main)
    sources = [folder / name for name in ("main.c", "x_api.c", "x_tables.c", "exover.c")]
    compile_c(compiler, [*WARNINGS, "-O0", "-DEXOVER_DEBUG"], sources, folder / "main")
    return subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout.splitlines()


def events_of(path: Path) -> list[Event]:
    recorded = path.with_suffix(".events.jsonl")
    if path.stem == "diligent":
        recorded = ROOT / "specs" / "diligent.mission.jsonl"
    if not recorded.exists():
        return random_events(built(path).model, 3, 300)
    read = [read_event(built(path).model, line) for line in recorded.read_bytes().splitlines()]
    return [event for event in read if not isinstance(event, Invalid)]


def expected(model: Model, events: Sequence[Event]) -> list[object]:
    reference = Reference(model)
    state, answers = reference.start(), []
    for event in events:
        state, actions = reference.step(state, event)
        answers.append(actions)
    return answers


@pytest.mark.parametrize("path", SPECS[:6], ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_a_recorded_mission_has_the_answers_of_the_reference(path: Path, tmp_path: Path) -> None:
    found, events = built(path), events_of(path)
    calls = "\n".join(map(Translator(found.model, "x").call, events))
    main = f"int main(void)\n{{\n    x_answer answer;\n    if (x_start(&r2c) != EXOVER_READY) return 1;\n{calls}\n}}\n"
    printed = run(found, PRINT + main, tmp_path)
    engine = NativeEngine(found.model, found.tables)
    answers = [engine._actions(line, event) for line, event in zip(printed, events, strict=True)]
    assert answers == expected(found.model, events) and len(events) > 30


CYCLE = """int main(void)
{
    static const x_event events[] = {
@    };
    static exover_action actions[X_ROOM + 2];
    size_t count = sizeof events / sizeof *events, done = 0;
    if (x_start(&r2c) != EXOVER_READY)
        return 1;
    while (done < count) {
        size_t said, taken = x_cycle(&r2c, events + done, count - done, actions, X_ROOM + 2, &said);
        if (taken == 0 || said > X_ROOM + 2)
            return 2;
        done += taken;
        for (size_t i = 0; i < said; i++)
            show(&actions[i]);
        printf("%zu\\n", taken);
    }
    return x_cycle(&r2c, events, count, actions, X_ROOM - 1, &done) != 0 || done != 0;
}
"""


def test_cycles_have_the_answers_of_their_events_one_after_another(tmp_path: Path) -> None:
    path = ROOT / "specs" / "diligent.exo"
    found, events = (
        built(path),
        [event for event in events_of(path) if not isinstance(event, Observe) or not event.broken],
    )
    translator = Translator(found.model, "x")
    elements = "".join(f"{translator.element(event, 'x')}\n" for event in events)
    printed = run(found, CYCLE.replace("@", elements), tmp_path)
    cycles = [line.rpartition(";") for line in printed]
    taken = [int(count) for _, _, count in cycles]
    assert sum(taken) == len(events) and 1 < len(taken) < len(events)
    engine = NativeEngine(found.model, found.tables)
    said = [actions for text, mark, _ in cycles for actions in engine._actions(text + mark, events[0])]
    due = [action for actions in expected(found.model, events) for action in actions]  # type: ignore[attr-defined]
    launched = [action for action in due if not isinstance(action, Invalid)]
    assert [action for action in said if not isinstance(action, Invalid)] == launched


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("text", [ODD, "spec least; module m { request r(); }"], ids=["odd", "least"])
def test_odd_names_compile(compiler: str, text: str, tmp_path: Path) -> None:
    found = build(model_of(text))
    assert run(found, NOTHING, tmp_path, compiler) == []


def test_identifiers_are_legal_and_each_once() -> None:
    known = constants(model_of(ODD), "_x")
    calls = [call for names in known.typed for call in (names.ask, names.ok, names.failed, names.interrupted)]
    calls += [call for names in known.typed for call in (names.abort, names.abort_waiting)] + [
        *known.observe,
        *known.level,
    ]
    names = [name for call in calls for name in (call.function, call.event)]
    names += [name for request in known.typed for name in (request.args, request.results, request.read)]
    for enumeration in [*known.enums.values(), *(request.statuses for request in known.typed)]:
        names += [enumeration.type, *(constant for constant, _ in enumeration.constants)]
    names += [constant for kind in (known.requests, known.posters, known.stocks, known.reasons) for constant, _ in kind]
    assert len(set(names)) == len(names)
    assert [name for name in names if not re.fullmatch(r"[Ss][Pp][Ee][Cc]_\w+", name, re.ASCII)] == []
    assert "spec_x_answer_2" in names and "spec_x_kind" in names
    params = model_of(ODD).requests[0].params
    assert fields(params, known.taken) == ("k", "int_", "p_r2c", "p__y", "p_EOF", "p_linux")


@pytest.mark.parametrize("compiler", COMPILERS)
def test_a_parameter_may_be_called_like_anything_that_the_emitted_code_uses(compiler: str, tmp_path: Path) -> None:
    found = build(model_of(speaking("abcde")))
    texts = [artefact.content.decode() for artefact in c.emit(found.model, found.tables, "x")]
    words = {word for text in texts for word in re.findall(r"[A-Za-z_]\w*", text, re.ASCII)}
    assert {"values", "answered", "exover_ask", "int64_t", "x_kind", "x_answer", "NULL", "begun"} < words
    found = build(model_of(speaking(word for word in words if len(word) < 40)))
    for artefact in c.emit(found.model, found.tables, "x"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    (tmp_path / "main.c").write_text(printer(found.model, constants(found.model, "x")) + NOTHING)
    for name in ("main.c", "x_api.c"):
        compile_c(compiler, [*WARNINGS, "-c", "-fsyntax-only"], [tmp_path / name], tmp_path / "main.o")


@pytest.mark.parametrize("compiler", COMPILERS)
def test_a_parameter_may_be_called_like_a_macro_of_a_standard_header(compiler: str, tmp_path: Path) -> None:
    text = "".join(f"#if __has_include(<{header}.h>)\n#include <{header}.h>\n#endif\n" for header in HEADERS)
    command = [compiler, "-D_GNU_SOURCE", "-dM", "-E", "-x", "c", "-"]
    told = subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout
    words = set(re.findall(r"^#define ([A-Za-z]\w*) ", told, re.MULTILINE))
    assert {"errno", "complex"} < words
    found = build(model_of(speaking(word for word in words if not word.isupper())))
    for artefact in c.emit(found.model, found.tables, "x"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    (tmp_path / "main.c").write_text(f'{text}#include "x_api.h"\n')
    command = [compiler, "-D_GNU_SOURCE", "-fsyntax-only", "main.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:4000]


def test_enums_may_be_called_like_functions_of_every_spec(tmp_path: Path) -> None:
    names = ("resume", "start_stopped", "cycle", "record")
    enums = " ".join(f"enum {name} {{ a{name}, b{name} }}" for name in names)
    requests = " ".join(f"request r_{name}(how: {name});" for name in names)
    found = build(model_of(f"spec x; {enums} module m {{ {requests} }}"))
    assert run(found, NOTHING, tmp_path) == []


def test_two_parameters_that_get_one_name_get_two() -> None:
    params = model_of("spec s; module m { request r(values: bool, p_values: bool, fn: bool, p_fn: bool); }").requests[0]
    assert fields(params.params, ()) == ("p_values", "p_values_", "fn", "p_fn")
    assert fields(params.params, {"fn"}) == ("p_values", "p_values_", "p_fn", "p_fn_")


def test_the_header_tells_ranges_types_and_bounds() -> None:
    found = built(ROOT / "specs" / "rover.exo")
    (text,) = [a.content.decode() for a in c.emit(found.model, found.tables, "rover") if a.name == "rover_api.h"]
    signature = (
        "exover_status rover_ask_nd_goto(rover_checker *r2c, double x, double y, double v, rover_answer *answer);"
    )
    assert (
        signature in text and "rover_ask_arm_move(rover_checker *r2c, rover_zone where, rover_answer *answer);" in text
    )
    above = text[: text.index(signature)].rstrip().splitlines()[-1]
    assert "x: -50 .. 50; y: -50 .. 50; v: 0 .. 1.5" in above and re.search(r"Bound: \d+ tests, \d+ answers", above)
    assert "ROVER_ZONE_FIELD = 2" in text and 'still: "calibration needs a rover that stands still"' in text
    functions = re.findall(r"^\w[^;{}]*\);$", text, re.MULTILINE)
    assert len(functions) > 40
    for function in functions:
        assert "Bound" in text[: text.index(function)].rpartition("/*")[2], function


ARGUMENTS = """
static void tell(void)
{
    x_m_r_args args = {-1, -1};
    bool known = x_args_m_r(&r2c, &args);
    printf("%d %d %g %d\\n", known, (int)args.n, args.v, x_slot_m_r(&r2c).phase == EXOVER_RUNNING);
}

int main(void)
{
    tell();
    (void)x_start(&r2c); tell();
    (void)x_ask_m_r(&r2c, 4, 1.5, NULL); tell();
    (void)x_report_m_r_ok(&r2c, NULL); tell();
    (void)x_start_stopped(&r2c); tell();
    return (0 && (show(NULL), 1));
}
"""


def test_arguments_are_those_of_the_last_launch(tmp_path: Path) -> None:
    found = build(model_of("spec x; module m { request r(n: int in 3 .. 9, v: real in 0.5 .. 2); }"))
    assert run(found, ARGUMENTS, tmp_path) == ["0 -1 -1 0", "1 0 0 0", "1 4 1.5 1", "1 4 1.5 0", "1 0 0 0"]
    (header,) = [a.content.decode() for a in c.emit(found.model, found.tables, "x") if a.name == "x_api.h"]
    said = " ".join(header.replace("\n *", "").split())
    assert "launched with last. They are kept when it has ended; before its first launch all are 0" in said


@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_names_can_be_left_out(compiler: str, tmp_path: Path) -> None:
    found = built(ROOT / "specs" / "rover.exo")
    for artefact in c.emit(found.model, found.tables, "rover"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    (tmp_path / "main.c").write_text(
        '#include "rover_api.h"\nstatic rover_checker r2c;\n'
        "int main(void) { return rover_start(&r2c) != EXOVER_READY; }\n"
    )
    sources = [tmp_path / name for name in ("main.c", "rover_api.c", "rover_tables.c", "exover.c")]
    compile_c(compiler, [*WARNINGS, "-O0"], sources, tmp_path / "without")
    compile_c(compiler, [*WARNINGS, "-O0"], [*sources, tmp_path / "rover_names.c"], tmp_path / "with")
    assert subprocess.run([tmp_path / "without"], check=False).returncode == 0
    without, with_names = ((tmp_path / name).read_bytes() for name in ("without", "with"))
    assert len(without) < len(with_names)
    assert b"stands still" in with_names and b"stands still" not in without
