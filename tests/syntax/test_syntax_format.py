"""Formatting: the text of a tree parses to that tree, and formatting it again changes nothing."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exover.source import Source, Span
from exover.syntax import tree as t
from exover.syntax.format import format_condition
from exover.syntax.parse import parse
from tests.support.format_spec import format_spec

AT = Span(0, 0)

# Trees of the shapes that the parser makes: sums of products, no sum in a product, `all` alone.

names = st.sampled_from(["a", "b", "active", "wait", "when", "until", "last", "_x1", "spec", "all2"]).map(
    lambda text: t.Name(text, AT)
)
optional_names = st.none() | names
counts = st.sampled_from(["0", "7", "100"]).map(lambda text: t.Number(text, False, AT))
numbers = st.builds(t.Number, st.sampled_from(["0", "0.2", "2.0", "1e-3", "07"]), st.booleans(), st.just(AT))
truths = st.builds(t.Truth, st.booleans(), st.just(AT))
words = st.builds(t.Word, names, st.just(AT))
values = numbers | truths | words
refs = st.builds(t.Ref, names, names, st.just(AT))
listed = refs | st.builds(t.ModuleAll, names, st.just(AT)) | st.builds(t.GroupName, names, st.just(AT))
because = st.none() | st.text(
    st.characters(exclude_categories=["Cs", "Cc"]) | st.sampled_from(["\n", '"', "\\"]), max_size=8
)


def some(items: st.SearchStrategy[object], least: int = 1) -> st.SearchStrategy[tuple[object, ...]]:
    return st.lists(items, min_size=least, max_size=least + 2).map(tuple)


units = (
    numbers
    | truths
    | st.builds(t.NameUse, optional_names, names, st.just(AT))
    | st.builds(t.SelfName, names, st.just(AT))
)
products = units | st.builds(t.Product, some(units, 2), st.just(AT))
addends = st.builds(t.Addend, st.booleans(), products, st.just(AT))
terms = products | st.builds(t.Sum, products, some(addends), st.just(AT))
relations = st.sampled_from(["==", "!=", "<", "<=", ">", ">="])
outcomes = st.sampled_from(["none", "ok", "failed", "interrupted"])
kinds = st.sampled_from(["active", "running", "stopping", "waiting", "past"])
atoms = (
    terms
    | st.builds(t.Compare, terms, relations, terms, st.just(AT))
    | st.builds(t.InRange, terms, terms, terms, st.just(AT))
    | st.builds(t.InSet, terms, some(terms), st.just(AT))
    | st.builds(t.Predicate, kinds, some(listed), st.none(), st.just(AT))
    | st.builds(t.Last, refs, st.booleans(), outcomes, st.just(AT))
    | st.builds(t.Used, names, relations, counts, st.just(AT))
    | st.builds(t.Level, names, relations, counts, st.just(AT))
)
conditions = st.recursive(
    atoms,
    lambda inner: (
        st.builds(t.Not, inner, st.just(AT))
        | st.builds(t.And, some(inner, 2), st.just(AT))
        | st.builds(t.Or, some(inner, 2), st.just(AT))
        | st.builds(t.Implies, inner, inner, st.just(AT))
        | st.builds(t.Predicate, kinds, st.tuples(refs), inner, st.just(AT))
    ),
    max_leaves=8,
)
optional_conditions = st.none() | conditions
targets = some(listed | st.builds(t.SelfTarget, st.just(AT))) | st.builds(t.AllTarget, st.just(AT)).map(
    lambda all: (all,)
)
remedies = some(
    st.builds(t.Reject, st.just(AT)) | st.builds(t.Wait, st.just(AT)) | st.builds(t.Kill, some(listed), st.just(AT)), 0
)
states = st.builds(t.NameUse, optional_names, names, st.just(AT))
moments = st.sampled_from(["launch", "ok", "failed", "interrupted"])
clauses = st.one_of(
    st.builds(t.Check, optional_names, conditions, because, st.just(AT)),
    st.builds(t.WaitUntil, optional_names, conditions, because, st.just(AT)),
    st.builds(t.SettleUntil, optional_names, conditions, because, st.just(AT)),
    st.builds(t.FailWhen, optional_names, conditions, st.booleans(), because, st.just(AT)),
    st.builds(t.After, some(listed), because, st.just(AT)),
    st.builds(t.Before, some(listed), because, st.just(AT)),
    st.builds(t.Interrupts, targets, st.booleans(), because, st.just(AT)),
    st.builds(t.Uses, names, counts, optional_conditions, because, st.just(AT)),
    st.builds(t.Consumes, names, counts, optional_conditions, because, st.just(AT)),
    st.builds(t.Produces, names, counts, optional_conditions, because, st.just(AT)),
    st.builds(t.OnSet, moments, states, values, because, st.just(AT)),
    st.builds(t.OnForget, moments, some(listed), because, st.just(AT)),
)
ranges = st.builds(t.Range, numbers | words, numbers | words, st.just(AT))
types = st.one_of(
    st.builds(t.BoolType, st.just(AT)),
    st.builds(t.IntType, ranges, st.just(AT)),
    st.builds(t.RealType, st.none() | ranges, st.just(AT)),
    st.builds(t.NamedType, names, st.just(AT)),
    st.builds(t.SetType, some(names), st.just(AT)),
)
params = some(st.builds(t.Param, names, types, st.just(AT)), 0)
requests = st.builds(
    t.Request, names, params, params, some(names, 0), st.none() | counts, some(clauses, 0), st.just(AT)
)
posters = st.builds(t.Poster, names, types, values, st.none() | values, st.just(AT))
members = requests | posters | st.builds(t.State, names, types, values, st.just(AT))
items = st.one_of(
    st.builds(t.Enum, names, some(names), st.just(AT)),
    st.builds(t.Const, names, values, st.just(AT)),
    st.builds(t.Define, names, conditions, st.just(AT)),
    st.builds(t.Group, names, some(listed), st.just(AT)),
    st.builds(t.Module, names, because, some(members, 0), st.just(AT)),
    posters,
    st.builds(t.Latch, names, conditions, some(listed), st.just(AT)),
    st.builds(t.Resource, names, counts, st.just(False), st.none(), remedies, because, st.just(AT)),
    st.builds(t.Resource, names, counts, st.just(True), st.none() | counts, remedies, because, st.just(AT)),
    st.builds(t.Context, refs, some(clauses, 0), st.just(AT)),
    st.builds(t.Mutex, optional_names, some(listed), remedies, because, st.just(AT)),
    st.builds(t.MutexOver, optional_names, some(listed), some(listed), st.booleans(), because, st.just(AT)),
    st.builds(t.Limit, optional_names, counts, some(listed), remedies, because, st.just(AT)),
    st.builds(t.Forbid, optional_names, conditions, remedies, because, st.just(AT)),
    st.builds(t.Launch, optional_names, refs, some(values, 0), conditions, because, st.just(AT)),
)
specs = st.builds(t.Spec, names, some(items, 0), st.just(AT))


@settings(max_examples=80, deadline=None)
@given(specs)
def test_the_text_of_a_tree_parses_to_the_tree(spec: t.Spec) -> None:
    text = format_spec(spec)
    parsed, reports = parse(Source("t", text))
    assert reports == ()
    assert parsed == spec
    assert format_spec(parsed) == text


@settings(max_examples=100, deadline=None)
@given(conditions)
def test_the_text_of_a_condition_parses_to_the_condition(condition: t.Cond) -> None:
    spec, reports = parse(Source("t", f"spec s; define d = {format_condition(condition)};"))
    assert reports == ()
    assert spec == t.Spec(t.Name("s", AT), (t.Define(t.Name("d", AT), condition, AT),), AT)


def test_the_canonical_layout() -> None:
    text = """spec s;forbid a;poster p:bool=true;poster q:int in 0..2=1 else 2;
    module m"x"{request r(x:bool,y:{a,b})returns(d:real)fails(f)instances 2{check l:((a));after m.*,g because"\\"";}
    request q();state t:e=a;}module e{}enum e{a,b};mutex a,b;mutex l:a over b else wait;context m.r{}
    resource c:3 consumable=1 by kill a,b or wait;
    launch m.r(-1,true)when(a or b)and not(c and d)implies(e implies f);"""
    spec, reports = parse(Source("t", text))
    assert reports == ()
    assert spec is not None
    assert (
        format_spec(spec)
        == """spec s;

forbid a;

poster p: bool = true;
poster q: int in 0 .. 2 = 1 else 2;

module m "x" {
    request r(x: bool, y: {a, b}) returns (d: real) fails (f) instances 2 {
        check l: a;
        after m.*, g because "\\"";
    }
    request q();
    state t: e = a;
}

module e {}

enum e { a, b }

mutex a, b;
mutex l: a over b else wait;

context m.r {}

resource c: 3 consumable = 1 by kill a, b or wait;

launch m.r(-1, true) when (a or b) and not (c and d) implies e implies f;
"""
    )


@pytest.mark.parametrize(
    "text",
    [
        "(a implies b) implies c",
        "a implies b implies c",
        "(a or b) or c",
        "a or (b or c)",
        "(a and b) and c",
        "(a or b) and c",
        "a or b and c",
        "(a implies b) or c",
        "not (a and b)",
        "not a and b",
        "not not a",
        "not a == b",
        "(not a implies b) and c",
        "active(m.r with a or b) or c",
    ],
)
def test_parentheses_stand_where_the_tree_needs_them_and_nowhere_else(text: str) -> None:
    spec, reports = parse(Source("t", f"spec s; define d = {text};"))
    assert reports == ()
    assert spec is not None
    assert format_spec(spec) == f"spec s;\n\ndefine d = {text};\n"
