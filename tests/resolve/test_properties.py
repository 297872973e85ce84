"""Properties files: every form means its formula, every name what it means in the spec, every mistake has its place."""

import random
import re
from pathlib import Path

import pytest

from exover.diagnostics import CODES, Diagnostic
from exover.model.expression import TRUE as ALWAYS_TRUE
from exover.model.expression import And, Compare, Cond, Const, Level, Not, Or, Param, Past, Reading, Status, Used
from exover.model.model import Location
from exover.model.property import (
    Assumption,
    Atom,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Next,
    Properties,
    Property,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
    all_always,
    all_finally,
    all_next,
    all_until,
    always,
    finally_,
    implies,
    some_finally,
)
from exover.pipeline import load_properties
from exover.source import Source
from tests.resolve.specs import MARK, WORLD, model

MODEL = model(WORLD + "module bare { }")
A, B, C = "m.a", "m.b", "m.c"


def active(request: str, where: Cond | None = None) -> Atom:
    return Atom(Status("active", request, where))


P, Q = active(A), active(B)
NOT_P = Atom(Not(P.condition))


def loaded(text: str) -> Properties:
    """Return what a file without a mistake says."""
    found = load_properties(Source("w.prop", f"for world;\n{text}"), MODEL)
    assert found.properties is not None, found.diagnostics
    assert found.diagnostics == ()
    return found.properties


def formed(form: str) -> Property:
    return loaded(f"property p: {form};").properties[0]


def formula(form: str) -> Formula:
    return formed(form).formula


# ---- forms ----


@pytest.mark.parametrize(
    ("form", "kind", "meant", "premise"),
    [
        ("never active(m.a)", "never", Negation(some_finally(P)), None),
        ("never (active(m.a) and active(m.b))", "never",
         Negation(some_finally(Atom(And((P.condition, Q.condition))))), P),
        ("always active(m.a)", "always", all_always(P), None),
        ("always (active(m.a) implies active(m.b))", "always",
         all_always(Atom(Or((NOT_P.condition, Q.condition)))), P),
        ("possible active(m.a)", "possible", some_finally(P), None),
        ("always possible active(m.a)", "always possible", all_always(some_finally(P)), None),
        ("from active(m.a) possible active(m.b)", "from possible", all_always(implies(P, some_finally(Q))), P),
        ("always (active(m.a) leads to active(m.b))", "leads to", all_always(implies(P, all_finally(Q))), P),
        ("active(m.a) precedes active(m.b)", "precedes",
         Negation(SomeUntil(Negation(P), Conjunction((Q, Negation(P))))), Q),
        ("active(m.a) until active(m.b)", "until", all_until(P, Q), None),
        ("ltl G (active(m.a) -> F active(m.b))", "ltl", always(Disjunction((NOT_P, finally_(Q)))), P),
        ("ltl G (!active(m.a) & active(m.b) -> F active(m.b))", "ltl",
         always(Disjunction((Atom(Not(And((NOT_P.condition, Q.condition)))), finally_(Q)))),
         Atom(And((NOT_P.condition, Q.condition)))),
        ("ltl G (F active(m.a) -> active(m.b))", "ltl", always(Disjunction((Negation(finally_(P)), Q))), None),
        ("ltl active(m.a) -> F active(m.b)", "ltl", Disjunction((NOT_P, finally_(Q))), None),
        ("ctl AG (active(m.a) -> AF active(m.b))", "ctl", all_always(Disjunction((NOT_P, all_finally(Q)))), P),
        ("ctl AG (EX active(m.a) implies active(m.b))", "ctl",
         all_always(Disjunction((Negation(SomeNext(P)), Q))), None),
        ("ctl EF active(m.a)", "ctl", some_finally(P), None),
    ],
)  # fmt: skip
def test_forms(form: str, kind: str, meant: Formula, premise: Formula | None) -> None:
    assert formed(form) == Property("p", None, kind, meant, premise, Location("w.prop", 2, 10))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("ltl X active(m.a)", Next(P)),
        ("ltl active(m.a) U active(m.b)", Until(P, Q)),
        ("ltl active(m.a) R active(m.b)", Negation(Until(Negation(P), Negation(Q)))),
        ("ltl active(m.a) W active(m.b)", Negation(Until(Negation(Q), Conjunction((Negation(P), Negation(Q)))))),
        ("ltl active(m.a) U active(m.b) U active(m.a)", Until(P, Until(Q, P))),
        ("ltl !active(m.a) U active(m.b) & active(m.a)", Conjunction((Until(NOT_P, Q), P))),
        ("ltl G active(m.a) U active(m.b)", Until(always(P), Q)),
        ("ctl EX active(m.a)", SomeNext(P)),
        ("ctl EG active(m.a)", SomeAlways(P)),
        ("ctl AX active(m.a)", all_next(P)),
        ("ctl AF active(m.a)", all_finally(P)),
        ("ctl E [active(m.a) U active(m.b)]", SomeUntil(P, Q)),
        ("ctl A [active(m.a) U active(m.b)]", all_until(P, Q)),
        ("ctl A [active(m.a) R active(m.b)]", Negation(SomeUntil(Negation(P), Negation(Q)))),
        ("ctl E [active(m.a) R active(m.b)]", Negation(all_until(Negation(P), Negation(Q)))),
        ("ctl E [active(m.a) W active(m.b)]", Disjunction((SomeUntil(P, Q), SomeAlways(P)))),
        ("ctl A [active(m.a) W active(m.b)]",
         Negation(SomeUntil(Negation(Q), Conjunction((Negation(P), Negation(Q)))))),
        ("ctl active(m.a) <-> EX active(m.b)",
         Conjunction((Disjunction((NOT_P, SomeNext(Q))), Disjunction((Negation(SomeNext(Q)), P))))),
        ("ctl not active(m.a) or active(m.b) and EX active(m.a)",
         Disjunction((NOT_P, Conjunction((Q, SomeNext(P)))))),
        ("ctl active(m.a) & active(m.b) | !active(m.a)",
         Atom(Or((And((P.condition, Q.condition)), NOT_P.condition)))),
    ],
)  # fmt: skip
def test_raw_formulas(text: str, meant: Formula) -> None:
    assert formula(text) == meant


def test_assumptions_and_texts() -> None:
    assert loaded("assume fair reports;") == Properties((), (), True)
    found = loaded('\nassume always hot;\n  assume never (asked(m.a) and hot);\nproperty p "why": possible hot;')
    hot = Atom(Compare("==", Reading("hot"), Const(True)))
    assert found.assumptions == (
        Assumption(hot, Location("w.prop", 3, 1)),
        Assumption(Negation(Conjunction((Happened("asked", A), hot))), Location("w.prop", 4, 3)),
    )
    assert (found.properties[0].text, found.properties[0].location) == ("why", Location("w.prop", 5, 10))
    assert not found.fair


# ---- names ----


@pytest.mark.parametrize(
    ("condition", "meant"),
    [
        ("battery < three", Compare("<", Reading("battery"), Const(3))),
        ("speed > half", Compare(">", Reading("speed"), Const(0.5))),
        ("speed > three", Compare(">", Reading("speed"), Const(3.0))),
        ("m.reach == 2", Compare("==", Reading("m.reach"), Const(2))),
        ("m.tool == gripper", Compare("==", Reading("m.tool"), Const("gripper"))),
        ("tripped", Compare("==", Reading("tripped"), Const(True))),
        ("calm", Compare("<=", Reading("speed"), Const(0.5))),
        ("not calm", Not(Compare("<=", Reading("speed"), Const(0.5)))),
        ("true", ALWAYS_TRUE),
        ("used(power) > 3", Compare(">", Used("power"), Const(3))),
        ("level(film) == 3", Compare("==", Level("film"), Const(3))),
        ("past(m.c with dist > 1 and at == home)",
         Past(C, And((Compare(">", Param("dist"), Const(1.0)), Compare("==", Param("at"), Const("base")))))),
        ("active(both)", Or((P.condition, Q.condition))),
        ("running(o.*)", Status("running", "o.d")),
    ],
)  # fmt: skip
def test_names_of_the_spec(condition: str, meant: Cond) -> None:
    assert formula(f"possible {condition}") == some_finally(Atom(meant))


def test_step_predicates() -> None:
    assert formula("possible ended(m.a)") == some_finally(Happened("ended", A))
    assert formula("possible killed(both)") == some_finally(Disjunction((Happened("killed", A), Happened("killed", B))))
    where = And((Compare("<=", Param("x"), Const(3)), Compare("==", Param("at"), Const("dock"))))
    assert formula("possible rejected(m.c with x <= three and at == dock)") == some_finally(
        Happened("rejected", C, where)
    )


def test_defines_of_the_file_may_use_each_other_and_those_of_the_spec() -> None:
    text = "define one = two and asked(m.a); property p: possible one; define two = calm or active(m.a);"
    two = Atom(Or((Compare("<=", Reading("speed"), Const(0.5)), P.condition)))
    assert loaded(text).properties[0].formula == some_finally(Conjunction((two, Happened("asked", A))))
    assert loaded("define one = active(m.a); property p: ltl G one;").properties[0].formula == always(P)


def test_operators_and_forms_are_names_where_no_formula_follows() -> None:
    spec = """spec world; poster G: int in 0 .. 9 = 0; poster possible: bool = false; poster U: bool = true;
        module F { poster X: bool = true; request U(G: int in 0 .. 9); } module asked { request A(); }"""
    one = model(spec)
    text = """for world;
        property always: ltl F.X U G > 3;
        property G: ltl G G > 3 & U;
        property U: (possible) until U;
        property F: possible asked(F.U with G > 3);
        property A: ctl A [U U U] | active(asked.A);
        property X: ltl G F F.X;
        property from: always G in 1 .. 3;"""
    found = load_properties(Source("w.prop", text), one).properties
    assert found is not None
    above = Atom(Compare(">", Reading("G"), Const(3)))
    inside = Atom(Compare("==", Reading("F.X"), Const(True)))
    true_u = Atom(Compare("==", Reading("U"), Const(True)))
    assert [each.formula for each in found.properties[:6]] == [
        Until(inside, above),
        Conjunction((always(above), true_u)),
        all_until(Atom(Compare("==", Reading("possible"), Const(True))), true_u),
        some_finally(Happened("asked", "F.U", Compare(">", Param("G"), Const(3)))),
        Disjunction((all_until(true_u, true_u), active("asked.A"))),
        always(finally_(inside)),
    ]


# ---- mistakes ----


def mistakes(text: str) -> tuple[list[tuple[str, int]], list[int], tuple[Diagnostic, ...]]:
    """Return code and offset of every mistake of a marked text, the offsets of its marks, and the mistakes."""
    pieces = text.split(MARK)
    marks = [sum(len(piece) for piece in pieces[: index + 1]) for index in range(len(pieces) - 1)]
    found = load_properties(Source("w.prop", "".join(pieces)), MODEL)
    assert (found.properties is None) == bool(found.diagnostics)
    spans = [(each.code, each.span.start) for each in found.diagnostics if each.span]
    assert len(spans) == len(found.diagnostics)
    assert all(code in CODES for code, _ in spans)
    return spans, marks, found.diagnostics


@pytest.mark.parametrize(
    ("text", "codes", "say"),
    [
        ("for «wrld; property p: never nonsense;", ["E419"], "the properties are for `wrld`, the spec is `world`"),
        ("for wrld; property p: never «;", ["E106"], "expected a condition, found `;`"),
        ("property p: never «nonsense;", ["E201"], "unknown name `nonsense`"),
        ("property p: never active(«m.z);", ["E203"], "unknown request `m.z`"),
        ("property p: never launched(«m.z with x > 1);", ["E203"], "unknown request `m.z`"),
        ("property p: never asked(m.c with «y > 1);", ["E208"], "`m.c` has no parameter `y`"),
        ("property p: never ended(m.c with «dist > 1);", ["E208"], "`m.c` has no parameter `dist`"),
        ("property p: never asked(m.c with «asked(m.a));", ["E415"], "a predicate cannot stand inside `with`"),
        ("property p: never active(«bare.*);", ["E413"], "`bare.*` names no request: module `bare` declares none"),
        ("property p: never asked(«bath);", ["E204"], "unknown group `bath`"),
        ("property p: never «x > 1;", ["E217"], "`x` is a parameter, which a property cannot read"),
        ("property p: never «self.x > 1;", ["E215"], "`self.x` stands outside the clauses of a request"),
        ("property p: never «speed > top;", ["E313"], "a property compares a real poster with a constant only"),
        ("property p: never «battery;", ["E304"], "a condition is needed, `battery` is an int"),
        ("property p: never «battery > 0.5;", ["E301"], "an int is compared with a real"),
        ("define d = hot; property p: never «d == true;", ["E219"], "define `d` is a condition, a value is needed"),
        ("property p: never «calm == true;", ["E219"], "define `calm` is a condition, a value is needed here"),
        ("define d = hot; property p: never asked(m.c with «d);", ["E219"], "define `d` cannot be used inside `with`"),
        ("define «a = b; define b = not a; property p: never a;", ["E214"], "define `a` is defined by itself"),
        ("define a = hot; define «a = calm;", ["E210"], "define `a` is declared twice"),
        ("define «calm = hot; define «hot = true; define «three = true; define «tripped = true;", ["E210"] * 4,
         "define `calm` is a name of the spec already"),
        ("property p: never hot; property q: never hot; property «p: possible hot;", ["E210"],
         "property `p` is declared twice"),
        ("assume fair reports; «assume fair reports;", ["E420"], "fair reports are assumed twice"),
        ("assume always hot; «assume always hot;", ["E420"], "this is assumed twice"),
        ("assume never hot; «assume always not hot;", ["E420"], "this is assumed twice"),
        ("assume always «true;", ["E421"], "this condition is true whatever happens, so nothing is assumed"),
        ("assume never «not true;", ["E421"], "this condition is false whatever happens, so nothing is assumed"),
        ("assume always «z; assume never «z2;", ["E201", "E201"], "unknown name `z`"),
        ("property p: ltl «EF hot;", ["E418"], "`EF` is an operator of `ctl`, this formula is `ltl`"),
        ("property p: ltl hot & «A [hot U calm];", ["E418"], "`A` is an operator of `ctl`, this formula is `ltl`"),
        ("property p: ctl «G hot;", ["E418"], "`G` is an operator of `ltl`, this formula is `ctl`"),
        ("property p: ctl hot «U calm;", ["E418"], "`U` has no path quantifier, which `ctl` needs"),
        ("property p: ctl A [hot U calm «R hot];", ["E418"], "`R` has no path quantifier, which `ctl` needs"),
        ("property p: ctl A [«G hot];", ["E418"], "`A [ ]` holds `U`, `R` or `W`"),
        ("property p: ctl E [«hot];", ["E418"], "`E [ ]` holds `U`, `R` or `W`"),
        ("property p: ltl «EF «z; property q: ctl «F «y U «x;", ["E418", "E201", "E418", "E201", "E217"],
         "`EF` is an operator"),
        ("property p: from «a possible «b; property q: «c precedes «d; property r: «e until «f;", ["E201"] * 6,
         "unknown name `a`"),
    ],
)  # fmt: skip
def test_mistakes(text: str, codes: list[str], say: str) -> None:
    found, marks, diagnostics = mistakes(text if text.startswith("for") else f"for world; {text}")
    if "U «x" in text:
        found.sort(key=lambda each: each[1])
        marks = [start for _, start in found]  # of `F y U x` the operator between is a mistake, too
        codes = ["E418", "E201", "E418", "E201", "E418", "E217"]
    assert found == list(zip(codes, marks, strict=True))
    assert diagnostics[0].message.startswith(say)


def test_a_define_of_the_spec_that_compares_two_posters_cannot_be_used() -> None:
    text = WORLD + "define fast = speed > top; define twice = fast or hot;"
    found = load_properties(Source("w.prop", "for world; property p: never twice;"), model(text)).diagnostics
    assert [(each.code, each.message) for each in found] == [
        ("E313", "a property compares a real poster with a constant only, as `twice` does")
    ]


def test_what_grows_too_large_is_refused() -> None:
    doubling = "define d0 = asked(m.a);" + "".join(f"define d{n} = d{n - 1} and d{n - 1};" for n in range(1, 40))
    found, _, _ = mistakes(f"for world; {doubling} property p: never d39;")
    assert [code for code, _ in found] == ["E414"]
    for operator, start in (("A", "E414"), ("E", None)):
        text = f"for world; property p: ctl {f'{operator} [hot U ' * 12}hot{']' * 12};"
        found, _, _ = mistakes(text)
        assert [code for code, _ in found] == ([start] if start else [])
    found, _, _ = mistakes(f"for world; property p: ltl {'F ' * 60}hot;")
    assert [code for code, _ in found] == ["E414"]


def test_step_predicates_stand_in_no_spec() -> None:
    from tests.resolve.specs import mistakes as in_spec

    found, marks, _ = in_spec(
        WORLD + "forbid «asked(m.a); define d = «ended(m.c with x > 1); launch o.d() when «killed(both);"
    )
    assert found == [("E417", mark) for mark in marks]


TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[A-Za-z_]\w*|\d+\.\d+|\d+|\.\.|<->|->|[<>=!]=|\S')
WORDS = ["m", "a", "c", "hot", "calm", "battery", "three", "U", "EF", "G", "A", "x", "home", "0", "1e999", "self"]


def test_shuffled_words_give_properties_or_mistakes() -> None:
    sample = Path(__file__).parents[2] / "tests" / "syntax" / "sample.prop"
    pieces = TOKEN.findall(re.sub("//.*", "", sample.read_text()).replace("for rover", "for world"))
    chance = random.Random(8)
    names = [piece for piece in pieces if piece.isidentifier() or piece[0].isdigit()] + WORDS
    places = [index for index, piece in enumerate(pieces) if (piece.isidentifier() or piece[0].isdigit()) and index > 2]
    parsed = 0
    for _ in range(150):
        changed = list(pieces)
        for _ in range(chance.randint(1, 3)):
            changed[chance.choice(places)] = chance.choice(names)
        found, _, _ = mistakes(" ".join(changed))
        starts = [start for _, start in found]
        assert starts == sorted(starts)
        parsed += all(code >= "E2" for code, _ in found)
    assert parsed > 20, "almost nothing was parsed: the test looks at nothing"
