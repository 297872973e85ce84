"""Every static rule of docs/language.md section 2: what breaks it is one mistake, of one code, at one place."""

import pytest

from exover.diagnostics import MAX_REPORTS
from exover.pipeline import load
from exover.source import Source
from tests.resolve.specs import WORLD, mistakes

# At the top level, behind the world; a mark stands where the mistake is.
ITEMS = [
    # names
    ("E201", "forbid active(m.a) and «batery > 3;"),
    ("E201", "define d = «nothing;"),
    ("E201", "const c = «nothing;"),
    ("E201", "poster p: int in 0 .. 3 = «nothing;"),
    ("E201", "poster p: int in «nothing .. 3 = 0;"),
    ("E201", "forbid active(m.c with x == 1) and «reach > 3;"),
    ("E202", "mutex «q.a, m.b;"),
    ("E202", "forbid active(m.a) and «q.s == 1;"),
    ("E202", "forbid active(«q.*);"),
    ("E202", "context «q.a { check hot; }"),
    ("E203", "mutex «m.aa, m.b;"),
    ("E203", "launch «m.q() when hot;"),
    ("E203", "context «m.q { check hot; }"),
    ("E203", "forbid active(«m.q with x == 1);"),
    ("E203", "forbid past(«m.q);"),
    ("E204", "forbid active(«bth);"),
    ("E204", "forbid active(«m);"),
    ("E205", "forbid active(m.a) and used(«pwer) > 3;"),
    ("E205", "forbid active(m.a) and level(«flm) > 3;"),
    ("E206", "poster p: «zon = base;"),
    ("E207", "forbid active(m.a) and «m.tol == none;"),
    ("E208", "forbid active(m.c with «y == 1);"),
    ("E208", "forbid active(m.c with «dist > 1);"),
    ("E209", "forbid active(m.c with at == «feild);"),
    ("E209", "forbid active(m.a) and m.tool in {none, «griper};"),
    ("E209", "launch m.c(1, 1, 1, «bse, true, 0) when hot;"),
    # names declared twice
    ("E210", "enum «zone { x }"),
    ("E210", "enum e { x, y, «x }"),
    ("E210", "poster p: {x, y, «x} = x;"),
    ("E210", "const «three = 4;"),
    ("E210", "define «three = hot;"),
    ("E210", "poster «calm: bool = true;"),
    ("E210", "latch «battery: when hot until m.a;"),
    ("E210", "poster «tripped: int in 0 .. 3 = 2;"),
    ("E210", "group «both = m.a;"),
    ("E210", "module «o { request e(); }"),
    ("E210", "module «o { request d(); poster p: bool = true; }"),
    ("E210", "module z { request r(); request «r(); }"),
    ("E210", "module z { poster p: bool = true; state «p: bool = true; }"),
    ("E210", "module z { request r(x: bool, «x: bool); }"),
    ("E210", "module z { request r() returns (x: bool, «x: bool); }"),
    ("E210", "module z { request r() fails (lost, «lost); }"),
    ("E210", "resource «power: 3;"),
    ("E210", "poster «film: int in 0 .. 3 = 3;"),
    ("E210", "poster gas: int in 0 .. 3 = 3; resource «gas: 4 consumable;"),
    ("E210", "latch gas: when hot until m.a; resource «gas: 4 consumable;"),
    ("E210", "resource gas: 4 consumable; latch «gas: when hot until m.a;"),
    ("E211", "mutex still: m.a, m.b; forbid «still: active(m.a) and hot;"),
    ("E211", "launch «power: m.a() when hot;"),
    ("E211", "forbid «film: active(m.a) and hot;"),
    ("E211", "context m.a { check calm: hot; } context m.a { fail «calm: when hot; }"),
    ("E211", "context m.a { after m.b; after «m.b; }"),
    ("E211", "context m.a { before m.b; before o.d, «m.b; }"),
    ("E211", "context m.a { interrupts m.b; interrupts «all; }"),
    ("E211", "context m.a { interrupts self; interrupts «self; }"),
    ("E212", "mutex «busy: m.a, m.b;"),
    ("E212", "forbid «superseded: active(m.a) and hot;"),
    ("E212", "launch «aborted: m.a() when hot;"),
    ("E212", "resource «abort: 3;"),
    ("E213", "module z { request r(x: bool) returns («x: bool); }"),
    ("E214", "define «d = not d;"),
    ("E214", "define «d = not e; define e = hot or f; define f = d and calm;"),
    ("E214", "const «c = d; const d = c;"),
    ("E214", "group «g = m.a, h; group h = g;"),
    # where names mean nothing
    ("E215", "forbid active(m.c with on == «self.on);"),
    ("E215", "define d = «self.x > 3;"),
    ("E216", "forbid active(m.c with x < «battery);"),
    ("E216", "forbid active(m.c with x == 1 and «m.tool == none);"),
    ("E216", "forbid active(m.c with «tripped);"),
    ("E217", "forbid active(m.c) and «v > 1;"),
    ("E217", "launch m.a() when «x > 1;"),
    ("E412", "define d = «x > 1;"),
    ("E218", "forbid active(m.a) and battery == «base;"),
    ("E218", "forbid active(m.a) and m.tool == «field;"),
    ("E218", "forbid active(m.a) and «none == none;"),
    ("E218", "forbid active(m.a) and battery in {1, «none};"),
    ("E219", "forbid active(«m.tool);"),
    ("E219", "forbid active(m.a) and «m.b == 1;"),
    ("E219", "forbid active(m.a) and «calm == true;"),
    ("E219", "forbid active(m.c with «calm);"),
    ("E219", "poster p: bool = «hot;"),
    # types
    ("E301", "forbid active(m.a) and «battery == true;"),
    ("E301", "forbid active(m.a) and «battery < 2.0;"),
    ("E301", "forbid active(m.a) and «battery < half;"),
    ("E301", "forbid active(m.a) and «battery == speed;"),
    ("E301", "forbid active(m.a) and «m.tool == 1;"),
    ("E301", "forbid active(m.a) and «hot == 1;"),
    ("E301", "poster p: {gripper, none} = none; forbid active(m.a) and «p == m.tool;"),
    ("E301", "forbid active(m.a) and «battery in {true, false};"),
    ("E302", "forbid active(m.a) and speed < «1 + 1;"),
    ("E302", "forbid active(m.a) and speed < «half * 2;"),
    ("E302", "forbid active(m.a) and «speed + 1 < 2;"),
    ("E302", "forbid active(m.a) and «0.5 + 0.25 < speed;"),
    ("E302", "forbid active(m.c with «v < v);"),
    ("E303", "forbid active(m.a) and «hot < true;"),
    ("E303", "forbid active(m.a) and «m.tool >= none;"),
    ("E303", "forbid active(m.a) and «m.tool in none .. gripper;"),
    ("E303", "forbid active(m.a) and «battery + hot + hot > 1;"),
    ("E303", "forbid active(m.a) and «battery + none > 1;"),
    ("E304", "forbid active(m.a) and «battery;"),
    ("E304", "forbid active(m.a) and «3;"),
    ("E304", "forbid active(m.a) and «m.tool;"),
    ("E304", "forbid active(m.a) and «none;"),
    ("E304", "define d = «battery + 1;"),
    ("E306", "poster p: int in «3 .. 2 = 3;"),
    ("E306", "poster p: real in «0.5 .. -0.5 = 0;"),
    ("E307", "poster p: int in 0 .. 3 = «4;"),
    ("E307", "poster p: int in 0 .. 3 = 3 else «-1;"),
    ("E307", "poster p: real = «1e999;"),
    ("E307", "poster p: real in «-1e999 .. 0 = 0;"),
    ("E307", "forbid active(m.a) and speed < «1e999;"),
    ("E307", "resource r: 3 consumable = «4;"),
    ("E307", "launch m.c(«10, 1, 1, base, true, 0) when hot;"),
    ("E307", "launch m.c(1, «2.5, 1, base, true, 0) when hot;"),
    ("E308", "poster p: bool = «1;"),
    ("E308", "poster p: int in 0 .. 3 = «2.0;"),
    ("E308", "poster p: int in 0 .. «2.0 = 1;"),
    ("E308", "poster p: int in «hm .. 3 = 1; const hm = true;"),
    ("E308", "poster p: int in «base .. 3 = 1;"),
    ("E308", "poster p: real = «true;"),
    ("E308", "poster p: zone = «3;"),
    ("E308", "poster p: zone = «gripper;"),
    ("E308", "poster p: bool = «base;"),
    ("E308", "launch m.c(«true, 1, 1, base, true, 0) when hot;"),
    ("E309", "forbid active(m.a) and «battery * battery > 1;"),
    ("E309", "forbid active(m.a) and 1 + «battery * 2 * m.reach > 1;"),
    ("E310", "poster p: int in 0 .. «9223372036854775808 = 0;"),
    ("E310", "forbid active(m.a) and battery < «9223372036854775808;"),
    ("E310", "forbid active(m.a) and «battery * 100000000000000000 < 0;"),
    ("E310", "forbid active(m.a) and «battery + 9223372036854775807 > 0;"),
    (
        "E310",
        "poster p: int in 0 .. 9223372036854775807 = 0; forbid active(m.a) and «p - 5 + p - 9223372036854775807 > 0;",
    ),
    (
        "E310",
        "poster p: int in 0 .. 9223372036854775807 = 0; poster q: int in -9 .. 9 = 0; forbid active(m.a) and «p > q;",
    ),
    (
        "E310",
        "poster p: int in 0 .. 9223372036854775807 = 0; poster q: int in 200 .. 300 = 200;"
        " forbid active(m.a) and «p + battery - q > 0;",
    ),
    ("E310", "resource r: «9223372036854775808;"),
    ("E310", "resource «r: 3; context m.a { uses r 9223372036854775807; }"),
    ("E311", "launch «m.a(1) when hot;"),
    ("E311", "launch «m.c(1, 1, 1) when hot;"),
    ("E312", "module z { state s: «real = 0; }"),
    ("E313", "forbid active(m.a) and «speed > top;"),
    ("E313", "launch m.a() when «speed > top;"),
    ("E313", "define d = speed > top; forbid active(m.a) and «d;"),
    # restrictions
    ("E401", "forbid «running(m.a);"),
    ("E401", "forbid active(m.a) and not «stopping(m.b);"),
    ("E401", "forbid active(m.a) and «waiting(both);"),
    ("E401", "forbid active(m.a) and «last(m.a) == ok;"),
    ("E401", "define d = hot or waiting(m.b); define e = not d; forbid active(m.a) and «e;"),
    ("E402", "latch l: when «active(m.a) until m.a;"),
    ("E402", "latch l: when «past(m.a) until m.a;"),
    ("E402", "latch l: when «used(power) > 3 until m.a;"),
    ("E402", "latch l: when «m.tool == none until m.a;"),
    ("E402", "latch l: when «l until m.a;"),
    ("E402", "latch l: when hot or «z until m.a; latch z: when hot until m.b;"),
    ("E402", "latch l: when «d until m.a; latch z: when hot until m.b; define d = hot and z;"),
    ("E402", "define d = active(m.a); latch l: when «d until m.a;"),
    ("E404", "forbid active(m.a) and hot by kill «m.b;"),
    ("E404", "forbid active(m.a) and hot by kill m.a, «m.b or reject;"),
    ("E404", "forbid active(m.a) and hot by kill «both;"),
    ("E404", "forbid past(m.a) and hot by kill «m.a;"),
    ("E404", "mutex m.a, m.b by kill «o.d;"),
    ("E404", "limit at most 1 of m.a, m.b by kill m.a or kill «o.d;"),
    ("E404", "resource r: 3 by kill «m.a;"),
    ("E404", "context m.a { uses power 3; } forbid active(m.b) and used(power) > 3 by kill m.a or kill «o.d;"),
    ("E404", "context m.a { consumes film 1; } forbid active(m.b) and level(film) < 1 by kill «m.a;"),
    ("E405", "forbid active(m.a) and «used(film) > 3;"),
    ("E406", "forbid active(m.a) and «level(power) > 3;"),
    ("E407", "resource r: 3 consumable by wait or «kill m.a;"),
    ("E408", "module z { request r() instances «0; }"),
    ("E409", "mutex m.a, m.b, «m.a;"),
    ("E409", "mutex m.a, «both;"),
    ("E409", "limit at most 1 of m.a, «m.a;"),
    ("E409", "forbid active(m.b, «both);"),
    ("E409", "forbid active(m.a) and hot by kill m.a, «m.a;"),
    ("E409", "group g = m.a, «m.*;"),
    ("E409", "latch l: when hot until m.a, «m.a;"),
    ("E409", "mutex m.a, «m.a over m.b;"),
    ("E410", "mutex m.a over m.b, «m.a;"),
    ("E410", "mutex both over «m.*;"),
    ("E413", "module e { } forbid hot and active(«e.*);"),
    ("E413", "module e { } group nobody = «e.*;"),
    ("E413", "context o.d { interrupts «all; }"),
    ("E415", "forbid active(m.c with x == 1 and «past(m.a));"),
    ("E416", "module z { request r() instances «65536; }"),
    # what can constrain nothing
    ("E421", "mutex «m.a;"),
    ("E421", "mutex «o.* by wait;"),
    ("E421", "group one = m.a; mutex «one;"),
    ("E421", "limit at most «2 of m.a, m.b;"),
    ("E421", "limit at most «9 of m.a, m.b;"),
    ("E421", "module z { request r() instances 3; } limit at most «4 of z.r, m.b;"),
    ("E421", "forbid «false;"),
    ("E421", "forbid «active(m.a) and three < 2;"),
    ("E421", "define never = not true; forbid «hot and never;"),
    ("E421", "forbid «active(m.c with half > 1);"),
    ("E421", "launch m.a() when «not (hot implies true);"),
    ("E421", "context «m.a { }"),
]

# Clauses of m.c, in a context.
CLAUSES = [
    ("E201", "check «nothing == 1;"),
    ("E208", "check «self.y == 1;"),
    ("E208", "check active(m.c with x == «self.y);"),
    ("E208", "check active(o.d with «x == 1);"),
    ("E209", "check at == «feild;"),
    ("E219", "check «calm == true;"),
    ("E301", "check «at == m.tool;"),
    ("E301", "check «x == v;"),
    ("E302", "check «v == v;"),
    ("E302", "check «v + w < 1;"),
    ("E305", "check active(m.c with v == «self.v);"),
    ("E305", "check active(m.c with big == «self.big);"),
    ("E303", "fail when «on > true;"),
    ("E401", "fail when «running(m.a);"),
    ("E401", "fail when «last(m.a) != ok;"),
    ("E403", "uses power 1 when «hot;"),
    ("E403", "uses power 1 when «m.tool == none;"),
    ("E403", "consumes film 1 when on and «active(m.a);"),
    ("E403", "produces film 1 when «level(film) > 1;"),
    ("E403", "produces film 1 when v < «speed;"),
    ("E403", "uses power 1 when «calm;"),
    ("E205", "uses «pwer 1;"),
    ("E205", "consumes «flm 1;"),
    ("E405", "uses «film 1;"),
    ("E406", "consumes «power 1;"),
    ("E406", "produces «power 1;"),
    ("E310", "uses power «9223372036854775808;"),
    ("E409", "after m.a, «m.a;"),
    ("E409", "before m.a, «both;"),
    ("E409", "interrupts m.a, «m.a;"),
    ("E409", "interrupts self, «self;"),
    ("E409", "on ok forget m.a, «m.a;"),
    ("E410", "after «m.c;"),
    ("E410", "before o.d, «m.c;"),
    ("E410", "after «m.*;"),
    ("E411", "interrupts «m.c;"),
    ("E411", "interrupts o.d, «m.*;"),
    ("E207", "on ok set «tol = none;"),
    ("E207", "on ok set «o.tool = none;"),
    ("E202", "on ok set «q.tool = none;"),
    ("E219", "on ok set «reach = 1;"),
    ("E219", "on ok set «hot = true;"),
    ("E219", "on ok set «m.c = 1;"),
    ("E219", "on ok set «c = 1;"),
    ("E308", "on ok set tool = «3;"),
    ("E209", "on ok set tool = «griper;"),
    ("E203", "on launch forget «m.q;"),
    ("E219", "on launch forget «m.tool;"),
    ("E219", "on launch forget m.a, «tripped;"),
    ("E204", "interrupts «bth;"),
    ("E421", "check «true;"),
    ("E421", "wait until «x - x == 0;"),
    ("E421", "settle until «hot or not false;"),
    ("E421", "fail when «hot and three > 3;"),
    ("E421", "uses power «0;"),
    ("E421", "consumes film «0;"),
    ("E421", "produces film «0;"),
    ("E421", "uses power 1 when «on and false;"),
    ("E421", "consumes film 1 when «false;"),
    ("E421", "produces film 1 when «1 == 2;"),
]


@pytest.mark.parametrize(("code", "text"), ITEMS, ids=[f"{code} {text}" for code, text in ITEMS])
def test_item(code: str, text: str) -> None:
    found, marks, diagnostics = mistakes(WORLD + text)
    assert found == [(code, mark) for mark in marks], diagnostics
    assert len(found) == 1


@pytest.mark.parametrize(("code", "text"), CLAUSES, ids=[f"{code} {text}" for code, text in CLAUSES])
def test_clause(code: str, text: str) -> None:
    found, marks, diagnostics = mistakes(f"{WORLD}context m.c {{ {text} }}")
    assert found == [(code, mark) for mark in marks], diagnostics
    assert len(found) == 1


def test_a_spec_without_requests_is_a_mistake() -> None:
    for text in ("spec «e;", "spec «e; module m { poster p: bool = true; } resource r: 3;"):
        found, marks, _ = mistakes(text)
        assert found == [("E422", marks[0])]


def test_what_can_constrain_nothing_is_told_where_nothing_else_is_wrong() -> None:
    found, marks, _ = mistakes(WORLD + "mutex m.a, «m.q; limit at most 1 of m.a, «m.r; forbid false;")
    assert found == [("E203", mark) for mark in marks]
    found, marks, _ = mistakes(WORLD + "mutex «m.a; forbid «false;")
    assert found == [("E421", mark) for mark in marks]


KEPT = [
    "limit at most 1 of m.a, m.b;",
    "limit at most 0 of m.a;",
    "module z { request r() instances 3; } limit at most 3 of z.r, m.b;",
    "forbid hot;",
    "forbid true;",
    "forbid active(m.a) and (hot or false);",
    "launch m.a() when true;",
    "context m.c { check false; fail when true; uses power 1 when true; }",
    "context m.c { check x >= 0; }",
]


@pytest.mark.parametrize("text", KEPT)
def test_what_can_act_is_kept(text: str) -> None:
    found, _, diagnostics = mistakes(WORLD + text)
    assert not found, diagnostics


def test_of_very_many_mistakes_the_first_are_told() -> None:
    text = "spec s; module m { request a(); } " + " ".join(f"mutex m.a, m.x{n};" for n in range(60))
    loaded = load(Source("s.exo", text))
    assert [each.code for each in loaded.diagnostics] == ["E203"] * MAX_REPORTS + ["E199"]
    assert loaded.diagnostics[-1].message == "10 more mistakes not shown"


def test_many_mistakes_are_all_told() -> None:
    found, marks, _ = mistakes(
        """spec t;
        poster p: int in «5 .. 2 = 3;
        module m { request a(x: «zon) { check «y > 1; uses «power 3; } request b() { after «m.b; } }
        mutex m.a, «m.c;
        forbid active(m.a) and «running(m.b) by kill m.a;
        launch m.b() when «3;
        """
    )
    assert found == list(zip(["E306", "E206", "E201", "E205", "E410", "E203", "E401", "E304"], marks, strict=True))


CASCADES = {
    "an unknown module, however often": "mutex «q.a, m.b; mutex q.b over q.c; forbid active(q.*) and q.p > 1;",
    "an unknown request, however often": "mutex «m.q, m.b; mutex m.q over m.a; launch m.q() when hot;",
    "a poster whose type is wrong": "poster p: «zon = base; forbid active(m.a) and (p == base or p > 3 or p + 1 == 2);",
    "a poster whose range is empty": "poster p: int in «2 .. 1 = 5 else 7; forbid active(m.a) and p == 5;",
    "a define that is wrong": "define d = «nothing > 1; forbid active(m.a) and d; launch m.b() when d and hot;",
    "a circle of defines": "define «d = not e; define e = not d; forbid active(m.a) and d; define f = e;",
    "a const that is wrong": "const c = «nothing; poster p: int in 0 .. c = c; forbid active(m.a) and battery > c;",
    "a circle of consts": "const «c = d; const d = c; const e = c; forbid active(m.a) and battery > e;",
    "a parameter whose type is wrong": "module z { request r(x: «zon) { check x == 1; } } launch z.r(1) when hot;",
    "a group that is wrong": "group g = m.a, «m.q; forbid active(g) by kill g; mutex g over m.b;",
    "a module that stands twice": "module «m { request a(); request b(); request e(); } mutex m.a, m.e;",
    "a request that stands twice": "module z { request r(x: bool); request «r(y: bool) { check y; } }",
    "a poster that stands twice": "poster «battery: real = 0.5 else 1.5; forbid active(m.a) and battery == 3;",
    "a resource that stands twice": "resource «power: 3 consumable = 9; context m.a { uses power 3; }",
    "a result that is a parameter": "module z { request r(x: bool) returns («x: bool); } forbid past(z.r with x);",
    "a latch that is wrong": "latch l: when «m.tool == none until m.a; forbid active(m.a) and l;",
    "a context of nothing": "context «m.q { check nothing; fail when x > 1; } context m.q { check nothing; }",
}


@pytest.mark.parametrize("text", CASCADES.values(), ids=CASCADES.keys())
def test_one_mistake_is_told_once(text: str) -> None:
    found, marks, diagnostics = mistakes(WORLD + text)
    assert [offset for _, offset in found] == marks, diagnostics
    assert len(found) == 1


HINTS = [
    ("mutex mm.a, m.b;", "did you mean `m`?"),
    ("mutex remote.a, m.b;", "known here: `m`, `o`"),
    ("mutex m.aa, m.b;", "did you mean `m.a`?"),
    ("forbid active(m.a) and batery > 3;", "did you mean `battery`?"),
    ("forbid active(m.a) and tool == none;", "did you mean `m.tool`?"),
    ("forbid active(bth);", "did you mean `both`?"),
    ("forbid active(m);", "did you mean `m.*`?"),
    ("forbid both;", "did you mean `active(both)`?"),
    ("forbid active(m.a) and film > 2;", "did you mean `level(film)`?"),
    ("forbid active(m.a) and used(film) > 2;", "did you mean `level(film)`?"),
    ("forbid active(m.c with at == feild);", "did you mean `field`?"),
    ("context m.c { check active(m.c with x == self.xx); }", "did you mean `self.x`?"),
    ("context m.c { check active(o.d with x == 1); }", "did you mean `self.x`?"),
    ("context m.c { on ok set tol = none; }", "did you mean `tool`?"),
    ("forbid active(m.a) and m.b;", "did you mean `active(m.b)`?"),
    ("poster p: zon = base;", "did you mean `zone`?"),
    (
        "const far = 3; const away = field; poster p: zone = nowhere;",
        "known here: `base`, `dock`, `field`, `home`, `away`",
    ),
    ("const away = field; const lost = nowhere;", "known here: `three`, `half`, `home`, `away`"),
    ("module z { state s: bool = true; request r(); } context z.r { after z.s; }", "known here: `z.r`"),
    (
        f"module z {{ state s: bool = true; {' '.join(f'request r{n}();' for n in range(7))} }} mutex z.s, m.a;",
        "name a request of module `z`, as `z.REQUEST`",
    ),
    ("context m.a { on ok forget m.tool; }", "a state gets a value: `on ok set m.tool = VALUE;`"),
    ("context m.a { on ok forget tool; }", "a state gets a value: `on ok set m.tool = VALUE;`"),
    ("context m.a { on ok forget tripped; }", "a latch is reset by the requests behind its `until`"),
]


@pytest.mark.parametrize(("text", "hint"), HINTS)
def test_help(text: str, hint: str) -> None:
    _, _, diagnostics = mistakes(WORLD + text)
    assert diagnostics[0].help == hint


def test_what_a_wrong_argument_is_for_is_told() -> None:
    _, _, diagnostics = mistakes(
        WORLD + "module z { request r(x: bool, n: int in 0 .. 3); } launch z.r(1, 9) when hot;"
    )
    assert [each.label for each in diagnostics] == ["for `x` of `z.r`", "for `n` of `z.r`"]


MESSAGES = [
    ("context m.a { on ok forget tool; }", "`forget` empties the past of a request, `m.tool` is a state"),
    ("launch m.a(1) when hot;", "`m.a` takes 0 arguments, not 1"),
    ("module z { request r(x: bool); } launch z.r() when hot;", "`z.r` takes 1 argument, not 0"),
    ("poster p: int in 0 .. 3 = 4;", "`4` is not in 0 .. 3"),
    ("resource r: 3 consumable = 4;", "`4` is not in 0 .. 3"),
    ("poster p: zone = 3;", "a value of `{base, dock, field}` is needed, `3` is none"),
    (
        "resource r: 9223372036854775807; context m.a { uses r 1; }",
        "the capacity of `r` and the amounts of its clauses do not fit 64 bits together",
    ),
    ("forbid active(m.a) and battery;", "a condition is needed, `battery` is an int"),
    ("forbid active(m.a) and none;", "a condition is needed, `none` is an enum value"),
    ("define d = waiting(m.b); forbid d;", "`forbid` cannot read `waiting(m.b)`, as `d` does"),
    (
        "define d = speed > top; resource q: 3; module z { request r() { uses q 1 when d; } }",
        "this `when` cannot read `speed`, as `d` does",
    ),
]


@pytest.mark.parametrize(("text", "message"), MESSAGES)
def test_message(text: str, message: str) -> None:
    _, _, (only,) = mistakes(WORLD + text)
    assert only.message == message


def test_further_uses_of_an_unknown_name_are_listed() -> None:
    _, _, (only,) = mistakes(WORLD + "mutex q.a, m.a;\nmutex q.b, m.b;\n\nforbid active(q.*);")
    first = WORLD.count("\n") + 1
    assert only.label == f"used again on lines {first + 1}, {first + 3}"


def test_what_grows_too_large_is_a_mistake() -> None:
    doubling = "define d0 = hot;" + "".join(f"define d{i + 1} = d{i} or d{i};" for i in range(60))
    found, _, _ = mistakes(f"{WORLD}{doubling} forbid active(m.a) and d60;")
    assert [code for code, _ in found] == ["E414"]
    long = "define d0 = hot;" + "".join(f"define d{i + 1} = not d{i};" for i in range(3000))
    found, _, _ = mistakes(f"{WORLD}{long} forbid active(m.a) and d3000;")
    assert [code for code, _ in found] == ["E414"]
    many = "".join(f"request r{i}();" for i in range(2000))
    found, marks, _ = mistakes(f"{WORLD} module z {{ {many} }} «mutex z.*;")
    assert found == [("E414", marks[0])]


def test_a_define_counts_as_what_it_stands_for(monkeypatch: pytest.MonkeyPatch) -> None:
    doubling = "define d0 = hot;" + "".join(f"define d{i + 1} = d{i} or d{i};" for i in range(4))
    monkeypatch.setattr("exover.resolve.conditions.MAX_ATOMS", 16)
    assert mistakes(f"{WORLD}{doubling}")[0] == []
    monkeypatch.setattr("exover.resolve.conditions.MAX_ATOMS", 15)
    assert [code for code, _ in mistakes(f"{WORLD}{doubling}")[0]] == ["E414"]


def test_long_circles_and_chains_are_no_trouble() -> None:
    circle = "".join(f"define d{i} = not d{(i + 1) % 3000};" for i in range(3000))
    found, marks, _ = mistakes(f"{WORLD}{circle}".replace("define d0 ", "define «d0 "))
    assert found == [("E214", marks[0])]
    chain = "".join(f"group g{i} = g{i + 1};" for i in range(3000))
    found, _, _ = mistakes(f"{WORLD}{chain} group g3000 = m.a; const c0 = three; mutex g0, m.b;")
    assert found == []
