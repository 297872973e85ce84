"""Bindings: what is read, and every mistake with its place."""

import math
from decimal import Decimal

import pytest

from exover.diagnostics import render
from exover.gate.binding import RequestBinding
from exover.gate.fields import UnreadableField, ValueField
from exover.gate.mcp.results import own_call
from exover.gate.reading import read_binding
from exover.model import waiting
from exover.model.model import Model, Rule
from exover.model.reads import in_question
from exover.model.types import Bool, Enum, Int, Real, Value
from exover.source import Source
from tests.gate.carts import BIND, SPEC, binding_of, model_of
from tests.support.small import compiled, small_spec_of

MODEL = model_of(SPEC)


def mistakes(text: str) -> list[str]:
    source = Source("cart.bind.toml", text)
    return [render(each, source) for each in read_binding(source, MODEL)[1]]


def test_what_a_binding_says() -> None:
    found = binding_of(BIND, MODEL)
    move = found.of("base.move")
    assert move is not None and move.started and move.report.watch == "state" and move.wait == 30 and move.stop == 5
    assert move.meant({"command": "move", "speed_percent": 3}) and not move.meant({"command": "halt"})
    assert move.report.meaning("bumper") == "failed" and move.report.failure("bumper") == "blocked"
    assert move.report.meaning("dreaming") is None and move.report.meaning(["moving"]) is None
    assert [each.request for each in found.called("tool", "drive")] == ["base.move"]
    assert found.passes("get_state") and not found.passes("set_state")
    assert not mistakes(BIND)


@pytest.mark.parametrize(
    ("old", "new", "head", "place"),
    [
        ('spec = "cart"', "", "error[E702]: the binding does not say for which spec it is", ":1:2"),
        ('spec = "cart"', 'spec = "card"', "error[E703]: the binding is for `card`, and the spec is `cart`", ":2:1"),
        ('spec = "cart"', 'sepc = "cart"', "error[E602]: `gate` has no key `sepc`", ":2:1"),
        ("wait = 30", "wait = 0", "error[E603]: `wait` is not a number of seconds above 0", ":5:1"),
        ("wait = 30", "wait = nan", "error[E603]: `wait` is not a number of seconds above 0", ":5:1"),
        ("wait = 30", "wait = true", "error[E603]: `wait` is not a number of seconds above 0", ":5:1"),
        ("wait = 30", "", "error[E702]: `base.move` can wait, and nothing says how long", ":10:2"),
        ('start = "idle"', "", "error[E702]: nothing tells whether `base.stop` runs when the gate starts", ":26:2"),
        ('"base.stop"', '"base.stopp"', "error[E701]: the spec has no request `base.stopp`", ":26:2"),
        ('tool = "brake"', "", "error[E702]: `base.stop` has none of `tool`, `action`, `service`", ":26:2"),
        ('tool = "brake"', 'tool = ""', "error[E603]: `tool` is not a text that is not empty", ":27:1"),
        ('tool = "brake"', 'action = "brake"', "error[E702]: `base.stop` has no `type`", ":26:2"),
        ("v = {", "w = {", "error[E701]: `base.move` has no parameter `w`", ":13:15"),
        ("scale = 0.01 ", "scale = 0 ", "error[E603]: `scale` is not a finite number that is not 0", ":13:46"),
        ("values = { l", "scale = 2, values = { l", "error[E706]: `side` is no number: it has no `scale`", ":32:40"),
        ('r = "right"', 'r = "rihgt"', "error[E701]: there is no value `rihgt`", ":32:63"),
        ("started = true", "started = 1", "error[E603]: `started` is not true or false", ":14:1"),
        ('watch = "state"\nstatus', 'watch = "stats"\nstatus', "error[E704]: there is no watch `stats`", ":18:1"),
        ('running = ["moving"]', "", "error[E702]: a report with a watch has no `running`", ":17:2"),
        ('ok = ["arrived"]', 'ok = ["moving"]', "error[E705]: the status 'moving' has two meanings", ":21:1"),
        ("blocked =", "blokced =", "error[E701]: `base.move` does not fail as `blokced`", ":23:11"),
        ("distance =", "distanse =", "error[E701]: `base.move` has no result `distanse`", ":24:13"),
        ("[poster.paint]", "[poster.pant]", "error[E701]: the spec has no poster `pant`", ":44:2"),
        ('tool = "brake"', 'tool = "drive"\nwhen = {command = "move", x = 1}', "error[E705]: `base.stop` is never", ""),
        ('"stow", ends = true', '"stow"', "warning[E707]: a cancelled `arm.reach` may", ":30:2"),
        ('[poster."base.speed"]\nwatch', "[watch.x]\ntool", "warning[E708]: nothing reads `base.speed`", ""),
        ("[watch.state]", "[watch.state", "error[E601]: the file is not TOML", ":7:13"),
        ('tool = "get_state"', 'topic = "state"', "error[E702]: the topic of the watch `state` has no `type`", ":7:2"),
        (
            'tool = "brake"\ncancel = { tool = "release", ends = true }', 'service = "b"\ntype = "a/srv/B"',
            "error[E702]: nothing tells a client that `base.stop` was refused", ":26:2",
        ),
        ('tool = "brake"', 'action = "b"\ntype = "a/action/B"', "error[E706]: `base.stop` is no tool: it", ":29:1"),
        ('tool = "drive"', 'action = "d"\ntype = "a/action/D"', "error[E706]: `base.move` is an action: it", ":15:1"),
        ('tool = "brake"', 'tool = "brake"\nrefused = { x = 1 }', "error[E706]: `base.stop` is no service", ":28:1"),
        ('"halt" }', '"halt", since = 2026-01-01 }', "error[E603]: `arguments` is not a table of what JS", ":15:28"),
        ('"halt" }', '"halt", at = { x = [1, nan] } }', "error[E603]: `arguments` is not a table of what", ":15:28"),
        ('"halt" }', '"halt", ' + "a." * 100 + "a = 1 }", "error[E603]: `arguments` is not a table of what", ":15:28"),
        ('"get_state"', '"get_state"\narguments = { at = -inf }', "error[E603]: `arguments` is not a table of", ":9:1"),
        ("scale = 0.01", "default = 2020-01-01", "error[E603]: the default of `v` is read as 2020-01-01, n", ":13:46"),
        ("scale = 0.01", 'default = "x"', "error[E603]: the default of `v` is read as x, n", ":13:46"),
        ("scale = 0.01", "default = nan", "error[E603]: the default of `v` is read as nan, n", ":13:46"),
        ("scale = 0.01", "default = 1.3", "error[E603]: the default of `v` is read as 1.3, n", ":13:46"),
        ("0.01 }", "0.01, default = 130 }", "error[E603]: the default of `v` is read as 1.3, n", ":13:60"),
        ("0.01 }", "0.01, default = true }", "error[E603]: the default of `v` cannot be read: `speed", ":13:60"),
        ('"hand"', '"hand", default = "x"', "error[E701]: the default of `side` cannot be read: `hand`", ":32:40"),
        ('"hand"', '"hand", default = 3', "error[E603]: the default of `side` cannot be read: `hand`", ":32:40"),
        ('["get_*"]', '["get_*", "*"]', "error[E706]: `*` passes `release`, by which the gate carries out", ":3:18"),
        ('["get_*"]', '["st?w"]', "error[E706]: `st?w` passes `stow`, by which the gate carries out or stops", ":3:9"),
        ('"drive"\nwhen', '"get"\ninner = "get_go"\nwhen', "error[E706]: `get_*` passes `get_go`, by which", ":3:9"),
        ("[gate]", "gate = 3\n[gates]", "error[E603]: `gate` is not a table", ":1:1"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_with_its_place(old: str, new: str, head: str, place: str) -> None:
    assert BIND.count(old) >= 1
    told = mistakes(BIND.replace(old, new, 1))
    assert any(each.startswith(head) and f"--> cart.bind.toml{place}" in each for each in told), "\n".join(told)


@pytest.mark.parametrize(
    ("old", "new"),
    [("0.01 }", "0.01, default = 120 }"), ('"hand"', '"hand", default = "l"'), ("scale = 0.01", "default = 0")],
)
def test_a_default_that_is_a_value_is_taken(old: str, new: str) -> None:
    assert not mistakes(BIND.replace(old, new, 1))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (BIND.split("\n\n")[0], "gate = 3"),
        ("wait = 30", 'wait = "3"'),
        ('start = "idle"', 'start = "busy"'),
        ('status = "base.phase"', 'status = ""'),
        ('running = ["moving"]', 'running = "moving"'),
        ('[request."base.move".report]\nwatch = "state"', '[request."base.move".report]\nwatch = 3'),
        ('cancel = { tool = "open", ends = true }', "cancel = 3"),
        ('cancel = { tool = "open", ends = true }', 'cancel = { tool = "open", ends = "true" }'),
        ('[watch.state]\ntool = "get_state"', '[watch.state]\ntopic = "state"\ntype = 3'),
    ],
)
def test_a_value_of_the_wrong_type_is_one_mistake(old: str, new: str) -> None:
    assert BIND.count(old) == 1
    (told,) = mistakes(BIND.replace(old, new))
    assert told.startswith("error[E603]: ")


def test_a_status_with_two_meanings_is_not_told_apart_by_when() -> None:
    (told,) = mistakes(BIND.replace('ok = ["arrived"]', 'ok = ["arrived", "moving"]'))
    assert "= help: leave it in one list, as `ok` or as `running`" in told
    (told,) = mistakes(BIND.replace('blocked = ["bumper"]', 'blocked = ["bumper", "bumper"]'))
    assert "the status 'bumper' is listed twice" in told and "= help: leave it in one list, once" in told


def test_brackets_of_a_pattern_stand_for_themselves() -> None:
    found = binding_of(BIND.replace('["get_*"]', '["get[abc]", "[x]?"]'), MODEL)
    assert found.passes("get[abc]") and found.passes("[x]y")
    assert not any(map(found.passes, ("geta", "x", "[x]")))


def test_what_is_asked_with_true_and_with_1_is_told_apart() -> None:
    bind = BIND.replace('when = { command = "move" }', "when = { fast = 1 }")
    bind = bind.replace('tool = "brake"', 'tool = "drive"\nwhen = { fast = VALUE }')
    assert not mistakes(bind.replace("VALUE", "true"))
    (told,) = mistakes(bind.replace("VALUE", "1.0"))
    assert "`base.stop` is never meant: `base.move` is, by the same calls" in told


def test_no_client_calls_what_is_for_the_gate_alone() -> None:
    found = binding_of(BIND.replace('pass = ["get_*"]', 'unbound = "pass"'), MODEL)
    assert found.passes("get_state") and found.passes("other")
    assert not any(map(found.passes, ("release", "stow", "open")))
    passed = BIND.replace(
        'pass = ["get_*"]', 'pass = ["drive", "brake", "get_*"]'
    )  # they are bound: guarded all the same
    assert not mistakes(passed)


def test_a_watch_cannot_tell_instances_apart() -> None:
    text = BIND.replace('tool = "grip"', 'tool = "grip"\nreport = {watch = "state", status = "a", running = ["x"]}')
    assert any("E706" in each and "2 instances of `arm.grip`" in each for each in mistakes(text))


def test_who_is_rejected_for_what_ends_for_others_needs_no_time_to_wait() -> None:
    model = model_of("spec s; module m { request dock(); request stop(); } mutex m.stop over m.dock;")
    binding = """[gate]
spec = "s"
start = "idle"
[request."m.dock"]
tool = "dock"
cancel = { tool = "halt", ends = true }
[request."m.stop"]
tool = "stop"
cancel = { tool = "halt", ends = true }
"""
    told = [each.message for each in read_binding(Source("b", binding), model)[1] if each.code == "E702"]
    assert told == ["`m.stop` can wait, and nothing says how long"]


@pytest.mark.parametrize(
    "spec",
    [
        *range(60),
        "spec s; poster h: int in 0 .. 3 = 0; module m { request a(x: int in 0 .. 3) instances 2 { fail when x > h; }}",
        "spec s; resource r: 1 by kill m.a; module m { request a() instances 2 { uses r 1; } }",
    ],
)
def test_no_request_that_the_tables_let_wait_is_taken_for_one_that_never_does(spec: str | int) -> None:
    made = compiled(model_of(small_spec_of(spec) if isinstance(spec, int) else spec))
    found = waiting.may_wait(made.model)
    for request, waits in zip(made.model.requests, made.tables.may_wait(), strict=True):
        assert request.name in found or not waits, request.name


def test_what_may_wait_is_found_once_for_all_requests(monkeypatch: pytest.MonkeyPatch) -> None:
    """For each request it is a walk over all rules: 26 s for 400 requests and 1 200 rules."""
    walks: list[str] = []

    def walked(model: Model) -> dict[str, tuple[Rule, ...]]:
        walks.append(model.name)
        return in_question(model)

    monkeypatch.setattr(waiting, "in_question", walked)
    text = BIND.replace("wait = 30", "")
    assert len(read_binding(Source("b", text), MODEL)[1]) == 3
    assert walks == ["cart"]


def test_what_a_launch_rule_requires_is_bound() -> None:
    model = model_of(SPEC + "poster tired: bool = false; launch rest: base.stop() when tired;")
    cut = BIND.replace('[request."base.stop"]\ntool = "brake"\ncancel = { tool = "release", ends = true }\n', "")
    found = read_binding(Source("b", cut), model)[1]
    assert [each.code for each in found if each.severity == "error"] == ["E706"]


@pytest.mark.parametrize(
    ("old", "new", "clash"),
    [
        ('tool = "brake"', 'tool = "brake"\nconstants = { a = 1, "a.b" = 2 }', "base.stop"),
        ('tool = "brake"', 'tool = "brake"\nwhen = { a = 1 }\nconstants = { a = 2 }', "base.stop"),
        ('tool = "brake"', 'tool = "brake"\nwhen = { a = true }\nconstants = { a = 1 }', "base.stop"),
        ('tool = "brake"', 'tool = "brake"\nwhen = { a = 1 }\nconstants = { a = 1, "b.c" = 2, "b.d" = 3 }', ""),
        ('when = { command = "move" }', 'when = { command = "move" }\nconstants = { speed_percent = 9 }', "base.move"),
        ('tool = "reach"', 'tool = "reach"\nconstants = { hand = "l" }', ""),  # no launch rule makes its call
    ],
)
def test_the_call_of_a_launch_rule_can_be_made(old: str, new: str, clash: str) -> None:
    rules = "poster tired: bool = false; launch rest: base.stop() when tired; launch go: base.move(0.5) when tired;"
    found = read_binding(Source("b", BIND.replace(old, new)), model_of(SPEC + rules))[1]
    told = [each.message for each in found if each.severity == "error"]
    assert len(told) == bool(clash) and all(f"requires `{clash}`, whose call cannot have" in each for each in told)


def test_whatever_is_cut_or_spoilt_is_told_and_never_a_fault() -> None:
    for offset in range(0, len(BIND), 7):
        for text in (BIND[:offset], BIND[:offset] + "[" + BIND[offset:], BIND[:offset] + BIND[offset + 5 :]):
            read_binding(Source("b", text), MODEL)
    assert mistakes("a = " + "[" * 100_000)[0].startswith("error[E601]: the file is nested too deep")


@pytest.mark.parametrize(
    "number",
    ["9" * 5000, "-" + "9" * 400, "0x" + "f" * 400, "0o2" + "0" * 21, "9_223_372_036_854_775_808", "0b1" + "0" * 63],
)
@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("wait = 30", "wait = {}", ":5:8"),
        ("scale = 0.01 ", "scale = {} ", ":13:54"),
        ('{ command = "halt" }', '{{ command = ["0", {}], b = """\n9""" }}', ":15:58"),
    ],
)
def test_an_integer_that_is_too_long_is_told_with_its_place(old: str, new: str, place: str, number: str) -> None:
    (told,) = mistakes(BIND.replace(old, new.format(number)))
    assert told.startswith("error[E601]: the file is not TOML: an integer of more than 64 bits")
    assert f"--> cart.bind.toml{place}\n" in told


@pytest.mark.parametrize("number", ["9_223_372_036_854_775_807", "0x007fff_ffff_ffff_ffff"])
def test_the_longest_integers_are_read(number: str) -> None:
    assert not mistakes(BIND.replace("wait = 30", f"wait = {number}"))


def test_fields_are_scaled_both_ways() -> None:
    speed = ValueField("v", Real(0, 2), ("drive", "percent"), Decimal("0.01"), Decimal("0.5"))
    assert speed.read({"drive": {"percent": 50}}) == 1.0 and speed.write(1.0) == 50
    assert ValueField("n", Int(0, 9), ("n",), Decimal("0.1")).read({"n": 30}) == 3
    side = ValueField("s", Enum(("left", "right")), ("0",), values={"l": "left", "r": "right"})
    assert side.read(["r"]) == "right" and side.write("left") == "l"
    flag = ValueField("f", Bool(), ("f",), values={"off": True, "true": False})
    assert flag.read({"f": "off"}) is True and flag.read({"f": True}) is False
    assert ValueField("d", Int(0, 9), ("d",), default=4).read({}) == 4
    assert ValueField("x", Real(), ("x",), Decimal(10)).read({"x": 1e308}) == math.inf


def test_numbers_are_scaled_as_they_are_written() -> None:
    percent = ValueField("v", Real(0, 1), ("v",), Decimal("0.01"))
    centimetres = ValueField("n", Int(0, 100), ("n",), Decimal(100))
    for number in range(101):
        assert percent.read({"v": number}) == float(f"{number // 100}.{number % 100:02}")
        assert centimetres.read({"n": number / 100}) == number == percent.write(number / 100)
    shifted = ValueField("i", Int(-(2**63), 2**63 - 1), ("i",), Decimal(1), Decimal(1))
    for number in (2**53 - 1, 2**53, 2**63 - 2, -(2**63)):
        assert shifted.read({"i": number}) == number + 1 and shifted.write(number + 1) == number
    for odd in (math.inf, -math.inf, math.nan):
        assert str(percent.read({"v": odd})) == str(odd)
        assert str(shifted.read({"i": odd})) == str(odd)
    assert shifted.read({"i": 10**400}) > 2**64


@pytest.mark.parametrize(
    ("field", "inner", "outer"),
    [
        (ValueField("v", Real(0, 2), ("v",), Decimal("0.01")), 0.57, 57),
        (ValueField("v", Real(0, 2), ("v",), Decimal("0.5")), 0.375, 0.75),
        (ValueField("v", Real(0, 2), ("v",)), 2.0, 2),
        (ValueField("v", Real(0, 2), ("v",)), 1.9999999999999998, 1.9999999999999998),
        (ValueField("v", Real(), ("v",), Decimal(2)), 1e300, 5e299),
        (ValueField("n", Int(0, 9), ("n",), Decimal(2)), 6, 3),
        (ValueField("f", Bool(), ("f",), values={"true": False, "false": True}), True, False),
        (ValueField("f", Bool(), ("f",), values={"on": True, "false": False}), False, "false"),
        (ValueField("e", Enum(("a", "b")), ("e",), values={"true": "a", "false": "b"}), "a", True),
    ],
)
def test_what_a_launch_rule_sends_is_of_the_outer_type(field: ValueField, inner: Value, outer: object) -> None:
    written = field.write(inner)
    assert (written, type(written)) == (outer, type(outer))
    assert field.read({field.name: written}) == (inner if isinstance(inner, str) else pytest.approx(inner, 1e-12))


@pytest.mark.parametrize(
    ("outer", "said"),
    [
        ({}, "`n` is missing"),
        ({"n": 3.5}, "no whole number"),
        ({"n": "3"}, "`n` is no number"),
        ({"n": True}, "no num"),
    ],
)
def test_a_field_that_cannot_be_read_says_why(outer: object, said: str) -> None:
    with pytest.raises(UnreadableField, match=said):
        ValueField("n", Int(0, 9), ("n",), Decimal("0.5")).read(outer)


def test_the_arguments_of_a_launch_rule_have_numbers_for_a_call() -> None:
    model = model_of(SPEC + "poster tired: bool = false; launch go: base.move(0.5) when tired;")

    def told(scale: str) -> list[str]:
        found = read_binding(Source("b", BIND.replace("scale = 0.01", f"scale = {scale}")), model)[1]
        return [each.message for each in found if each.severity == "error"]

    assert told("1e-320") == ["`go` requires `v` = 0.5, which no number stands for in a call, scaled back"]
    assert not told("1e-300")


def test_whole_numbers_that_are_too_large_for_a_double_are_mistakes() -> None:
    counted = SPEC.replace("v: real in 0 .. 1.2", "v: int in 0 .. 12")
    model = model_of(counted + "poster tired: bool = false; launch go: base.move(10) when tired;")

    def told(field: str) -> list[str]:
        found = read_binding(Source("b", BIND.replace("scale = 0.01", field)), model)[1]
        return [each.message for each in found if each.severity == "error"]

    assert told("scale = 1e-308") == ["`go` requires `v` = 10, which no number stands for in a call, scaled back"]
    (default,) = told("scale = 1e300, default = 1e300")
    assert default.startswith("the default of `v` is read as 1000000")


def test_the_arguments_of_a_launch_rule_have_names_for_a_call() -> None:
    model = model_of(SPEC + "poster tired: bool = false; launch go: arm.reach(right) when tired;")
    text = BIND.replace('l = "left", r = "right"', 'l = "left"')
    told = [each.message for each in read_binding(Source("b", text), model)[1] if each.severity == "error"]
    assert told == ["`go` requires `side` = right, which none of its `values` stands for"]


@pytest.mark.parametrize(
    ("field", "constants", "said"),
    [
        ("wheels.0.v", "", ""),
        ("wheels.0.v", 'constants = { "wheels.1.v" = 0, "wheels.2" = 3 }', ""),
        ("wheels.1.v", "", "whose call has not the whole list `wheels`"),
        ("wheels.0.v", 'constants = { "wheels.left" = 0 }', "whose call has not the whole list `wheels`"),
        ("wheels.00.v", "", "whose call has not the whole list `wheels`"),
    ],
)
def test_the_call_of_a_launch_rule_has_whole_lists(field: str, constants: str, said: str) -> None:
    model = model_of(SPEC + "poster tired: bool = false; launch go: base.move(0.5) when tired;")
    text = BIND.replace("speed_percent", field).replace("started = true", f"{constants}\nstarted = true")
    told = [each.message for each in read_binding(Source("b", text), model)[1] if each.code == "E706"]
    assert len(told) == bool(said) and all(said in each for each in told)


def test_numbers_in_paths_are_elements_of_lists_in_a_call() -> None:
    bound = RequestBinding("m.r", "tool", "t", "t", constants=((("a", "0", "x"), 1), (("a", "1"), 2), (("b", "x"), 3)))
    assert own_call(bound, ()) == {"name": "t", "arguments": {"a": [{"x": 1}, 2], "b": {"x": 3}}}
