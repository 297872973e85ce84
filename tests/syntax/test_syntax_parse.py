"""Every rule of the grammar, and the nodes that it makes."""

import pytest

from exover.source import Source, Span
from exover.syntax import tree as t
from exover.syntax.parse import parse

AT = Span(0, 0)


def spec_of(text: str) -> t.Spec:
    spec, reports = parse(Source("test.exo", text))
    assert reports == ()
    assert spec is not None
    return spec


def item_of(text: str) -> t.Item:
    (item,) = spec_of("spec s;\n" + text).items
    return item


def member_of(text: str) -> t.Member:
    module = item_of("module m { " + text + " }")
    assert isinstance(module, t.Module)
    (member,) = module.members
    return member


def clause_of(text: str) -> t.Clause:
    context = item_of("context m.r { " + text + " }")
    assert isinstance(context, t.Context)
    (clause,) = context.clauses
    return clause


def condition_of(text: str) -> t.Cond:
    rule = item_of(f"forbid {text};")
    assert isinstance(rule, t.Forbid)
    return rule.condition


def n(text: str) -> t.Name:
    return t.Name(text, AT)


def num(text: str, negative: bool = False) -> t.Number:
    return t.Number(text, negative, AT)


def use(text: str) -> t.NameUse:
    module, dot, name = text.rpartition(".")
    return t.NameUse(n(module) if dot else None, n(name), AT)


def ref(text: str) -> t.Ref:
    module, _, request = text.partition(".")
    return t.Ref(n(module), n(request), AT)


def group(text: str) -> t.GroupName:
    return t.GroupName(n(text), AT)


def word(text: str) -> t.Word:
    return t.Word(n(text), AT)


def span(low: t.Bound, high: t.Bound) -> t.Range:
    return t.Range(low, high, AT)


A, B, C, D = (use(name) for name in "abcd")
KILL = t.Kill((ref("m.r"), group("g")), AT)


@pytest.mark.parametrize(
    ("text", "item"),
    [
        ("enum e { a }", t.Enum(n("e"), (n("a"),), AT)),
        ("enum e { a, b };", t.Enum(n("e"), (n("a"), n("b")), AT)),
        ("const c = -2.50e-3;", t.Const(n("c"), num("2.50e-3", True), AT)),
        ("const c = true;", t.Const(n("c"), t.Truth(True, AT), AT)),
        ("const c = red;", t.Const(n("c"), word("red"), AT)),
        ("define d = a;", t.Define(n("d"), A, AT)),
        (
            "group g = m.r, m.*, h;",
            t.Group(n("g"), (ref("m.r"), t.ModuleAll(n("m"), AT), group("h")), AT),
        ),
        ("module m {}", t.Module(n("m"), None, (), AT)),
        (r'module m "a \"b\" \\ \n" {}', t.Module(n("m"), 'a "b" \\ \n', (), AT)),
        (
            "poster p: bool = true else false;",
            t.Poster(n("p"), t.BoolType(AT), t.Truth(True, AT), t.Truth(False, AT), AT),
        ),
        ("latch l: when a until m.r, g;", t.Latch(n("l"), A, (ref("m.r"), group("g")), AT)),
        ("resource r: 10;", t.Resource(n("r"), num("10"), False, None, (), None, AT)),
        (
            'resource r: 10 consumable by reject or wait because "x";',
            t.Resource(n("r"), num("10"), True, None, (t.Reject(AT), t.Wait(AT)), "x", AT),
        ),
        ("resource r: 9 consumable = 3;", t.Resource(n("r"), num("9"), True, num("3"), (), None, AT)),
        ("context m.r {}", t.Context(ref("m.r"), (), AT)),
        ("mutex a, b;", t.Mutex(None, (group("a"), group("b")), (), None, AT)),
        ("mutex l: a by kill m.r, g or wait;", t.Mutex(n("l"), (group("a"),), (KILL, t.Wait(AT)), None, AT)),
        ('mutex a over b, c because "x";', t.MutexOver(None, (group("a"),), (group("b"), group("c")), False, "x", AT)),
        ("mutex l: a over b else wait;", t.MutexOver(n("l"), (group("a"),), (group("b"),), True, None, AT)),
        ("limit at most 2 of a;", t.Limit(None, num("2"), (group("a"),), (), None, AT)),
        ("limit l: at most 2 of a by reject;", t.Limit(n("l"), num("2"), (group("a"),), (t.Reject(AT),), None, AT)),
        ("forbid a;", t.Forbid(None, A, (), None, AT)),
        ('forbid l: a by kill m.r, g because "x";', t.Forbid(n("l"), A, (KILL,), "x", AT)),
        ("launch m.r() when a;", t.Launch(None, ref("m.r"), (), A, None, AT)),
        (
            'launch l: m.r(-1, true, red) when a because "x";',
            t.Launch(n("l"), ref("m.r"), (num("1", True), t.Truth(True, AT), word("red")), A, "x", AT),
        ),
    ],
)
def test_items(text: str, item: t.Item) -> None:
    assert item_of(text) == item


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("bool", t.BoolType(AT)),
        ("int in 0..2", t.IntType(span(num("0"), num("2")), AT)),
        ("int in -3 .. top", t.IntType(span(num("3", True), word("top")), AT)),
        ("real", t.RealType(None, AT)),
        ("real in -0.5..1e3", t.RealType(span(num("0.5", True), num("1e3")), AT)),
        ("zone", t.NamedType(n("zone"), AT)),
        ("{a, b}", t.SetType((n("a"), n("b")), AT)),
    ],
)
def test_types(text: str, kind: t.Type) -> None:
    assert item_of(f"poster p: {text} = a;") == t.Poster(n("p"), kind, word("a"), None, AT)


@pytest.mark.parametrize(
    ("text", "member"),
    [
        ("state s: zone = a;", t.State(n("s"), t.NamedType(n("zone"), AT), word("a"), AT)),
        ("request r();", t.Request(n("r"), (), (), (), None, (), AT)),
        ("request r() {}", t.Request(n("r"), (), (), (), None, (), AT)),
        (
            "request r(x: bool, y: zone) returns (d: bool) fails (bad, worse) instances 2 { after g; }",
            t.Request(
                n("r"),
                (t.Param(n("x"), t.BoolType(AT), AT), t.Param(n("y"), t.NamedType(n("zone"), AT), AT)),
                (t.Param(n("d"), t.BoolType(AT), AT),),
                (n("bad"), n("worse")),
                num("2"),
                (t.After((group("g"),), None, AT),),
                AT,
            ),
        ),
    ],
)
def test_members(text: str, member: t.Member) -> None:
    assert member_of(text) == member


@pytest.mark.parametrize(
    ("text", "clause"),
    [
        ("check a;", t.Check(None, A, None, AT)),
        ('check l: a because "x";', t.Check(n("l"), A, "x", AT)),
        ("wait until a;", t.WaitUntil(None, A, None, AT)),
        ("wait l: until a;", t.WaitUntil(n("l"), A, None, AT)),
        ("settle until a;", t.SettleUntil(None, A, None, AT)),
        ("settle l: until a;", t.SettleUntil(n("l"), A, None, AT)),
        ("fail when a;", t.FailWhen(None, A, False, None, AT)),
        ('fail l: when a else wait because "x";', t.FailWhen(n("l"), A, True, "x", AT)),
        ("after m.r, g;", t.After((ref("m.r"), group("g")), None, AT)),
        ("before m.*;", t.Before((t.ModuleAll(n("m"), AT),), None, AT)),
        ("interrupts all;", t.Interrupts((t.AllTarget(AT),), False, None, AT)),
        ("interrupts self;", t.Interrupts((t.SelfTarget(AT),), False, None, AT)),
        ("interrupts all.x, self else wait;", t.Interrupts((ref("all.x"), t.SelfTarget(AT)), True, None, AT)),
        ("uses p 60;", t.Uses(n("p"), num("60"), None, None, AT)),
        ("uses p 60 when a;", t.Uses(n("p"), num("60"), A, None, AT)),
        ("consumes p 1 when a;", t.Consumes(n("p"), num("1"), A, None, AT)),
        ('produces p 1 because "x";', t.Produces(n("p"), num("1"), None, "x", AT)),
        ("on launch set s = -1;", t.OnSet("launch", use("s"), num("1", True), None, AT)),
        ("on ok set m.s = on;", t.OnSet("ok", use("m.s"), word("on"), None, AT)),
        ("on failed forget m.r, g;", t.OnForget("failed", (ref("m.r"), group("g")), None, AT)),
        ("on interrupted forget g;", t.OnForget("interrupted", (group("g"),), None, AT)),
    ],
)
def test_clauses(text: str, clause: t.Clause) -> None:
    assert clause_of(text) == clause


@pytest.mark.parametrize(
    ("text", "condition"),
    [
        ("a", A),
        ("true", t.Truth(True, AT)),
        ("m.s", use("m.s")),
        ("self.p", t.SelfName(n("p"), AT)),
        ("not not a", t.Not(t.Not(A, AT), AT)),
        ("not a and b", t.And((t.Not(A, AT), B), AT)),
        ("a or b and c or d", t.Or((A, t.And((B, C), AT), D), AT)),
        ("(a or b) or c", t.Or((t.Or((A, B), AT), C), AT)),
        ("a implies b implies c", t.Implies(A, t.Implies(B, C, AT), AT)),
        ("(a implies b) implies c", t.Implies(t.Implies(A, B, AT), C, AT)),
        ("a or b implies not c", t.Implies(t.Or((A, B), AT), t.Not(C, AT), AT)),
        ("a <= -1", t.Compare(A, "<=", num("1", True), AT)),
        ("a in b..2", t.InRange(A, B, num("2"), AT)),
        ("a in {b}", t.InSet(A, (B,), AT)),
        ("a in {1, c}", t.InSet(A, (num("1"), C), AT)),
        (
            "a + 2 * b - -1 != c",
            t.Compare(
                t.Sum(
                    A,
                    (
                        t.Addend(False, t.Product((num("2"), B), AT), AT),
                        t.Addend(True, num("1", True), AT),
                    ),
                    AT,
                ),
                "!=",
                C,
                AT,
            ),
        ),
        ("past(m.r, g)", t.Predicate("past", (ref("m.r"), group("g")), None, AT)),
        ("active(m.r with a)", t.Predicate("active", (ref("m.r"),), A, AT)),
        ("running(g)", t.Predicate("running", (group("g"),), None, AT)),
        ("stopping(m.*)", t.Predicate("stopping", (t.ModuleAll(n("m"), AT),), None, AT)),
        ("waiting(m.r)", t.Predicate("waiting", (ref("m.r"),), None, AT)),
        ("last(m.r) == none", t.Last(ref("m.r"), True, "none", AT)),
        ("last(m.r) != interrupted", t.Last(ref("m.r"), False, "interrupted", AT)),
        ("used(p) >= 7", t.Used(n("p"), ">=", num("7"), AT)),
        ("level(p) < 7", t.Level(n("p"), "<", num("7"), AT)),
    ],
)
def test_conditions(text: str, condition: t.Cond) -> None:
    assert condition_of(text) == condition


def test_spans_cover_the_text_of_their_nodes() -> None:
    text = 'spec s;\n// c\nforbid far: active(m.r with x > 2.0) and m.s by kill m.r because "x";  // d'
    source = Source("t", text)
    (rule,) = spec_of(text).items
    assert isinstance(rule, t.Forbid)
    assert source.slice(rule.span) == text[text.index("forbid") : text.index("  // d")]
    assert rule.label is not None
    assert source.slice(rule.label.span) == "far"
    assert isinstance(rule.condition, t.And)
    assert source.slice(rule.condition.span) == "active(m.r with x > 2.0) and m.s"
    predicate, state = rule.condition.parts
    assert source.slice(predicate.span) == "active(m.r with x > 2.0)"
    assert isinstance(predicate, t.Predicate)
    assert [source.slice(request.span) for request in predicate.requests] == ["m.r"]
    assert source.slice(state.span) == "m.s"
    assert source.slice(rule.remedies[0].span) == "kill m.r"


@pytest.mark.parametrize("label", ["wait when: until a;", "wait until: until a;", "fail when: when a;"])
def test_the_span_of_a_label_ends_before_its_colon(label: str) -> None:
    text = "spec s; context m.r { " + label + " }"
    (context,) = spec_of(text).items
    assert isinstance(context, t.Context)
    (clause,) = context.clauses
    assert isinstance(clause, t.WaitUntil | t.FailWhen)
    assert clause.label is not None
    assert Source("t", text).slice(clause.label.span) == clause.label.text == label.split()[1].rstrip(":")


def test_literals_keep_their_text() -> None:
    literals = ["0.2", "2.0", "2", "02", "99999999999999999999999999", "1E+3", "1e-3"]
    assert [item_of(f"const c = {literal};") for literal in literals] == [
        t.Const(n("c"), num(literal), AT) for literal in literals
    ]


def test_comments_and_blanks_leave_nothing() -> None:
    plain = spec_of("spec s; forbid a; forbid b;")
    assert spec_of("/**/ spec s /* a; */;// x\r\n\tforbid a;/* // */ forbid/***/b;//") == plain


def test_a_slash_star_in_a_string_is_no_comment() -> None:
    assert item_of('forbid a because "/* // */";') == t.Forbid(None, A, (), "/* // */", AT)


def test_what_over_cannot_kill_waits_in_either_words() -> None:
    assert item_of("mutex a over b by wait;") == item_of("mutex a over b else wait;")
    assert item_of('mutex l: a over b by wait because "x";') == item_of('mutex l: a over b else wait because "x";')
