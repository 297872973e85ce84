"""Broken texts: each mistake is told once, at its place."""

from pathlib import Path

import pytest

from exover.diagnostics import MAX_REPORTS, Diagnostic, render_all
from exover.source import Source
from exover.syntax.expect import advice, expectation
from exover.syntax.lex import tokens
from exover.syntax.parse import parse
from exover.syntax.unexpected import Unexpected
from tests.support.reported import places_of

SAMPLE = Path(__file__).with_name("sample.exo").read_text("utf-8")


def reports_on(text: str) -> tuple[Diagnostic, ...]:
    spec, reports = parse(Source("t", text))
    assert (spec is None) == bool(reports)
    return reports


def places(text: str) -> list[str]:
    return places_of(reports_on(text), text)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # the head of the file
        ("", ["E004 1:1"]),
        ("\n\n  // nothing\n", ["E004 1:1"]),
        ("spec", ["E106 1:5"]),
        ("spec s", ["E107 1:7"]),
        ("spec 3;", ["E106 1:6"]),
        ("spce s; forbid a;", ["E106 1:1"]),
        ("forbid a;", ["E106 1:1"]),
        ("module m {}\nforbid a b;", ["E106 1:1", "E106 2:10"]),
        ("hello world", ["E106 1:1"]),
        ("spec s; spec t;", ["E106 1:9"]),
        # `;`
        ("spec s\nforbid a;", ["E107 1:7"]),
        ("spec s;\nforbid a\nforbid b;", ["E107 2:9"]),
        ("spec s;\nforbid a\n\n\n", ["E107 2:9"]),
        ("spec s; module m { request a() request b(); state t: z = a }", ["E107 1:31", "E107 1:59"]),
        ("spec s; context m.r { check a check b; wait until c }", ["E107 1:30", "E107 1:52"]),
        ("spec s; mutex a, b c;", ["E106 1:20"]),
        ("spec s; forbid a;; forbid b;", ["E106 1:18"]),
        # brackets
        ("spec s; forbid (a or (b;", ["E108 1:22"]),
        ("spec s; forbid ((((a;\nforbid b c;", ["E108 1:19", "E106 2:10"]),
        ("spec s; forbid a);", ["E106 1:17"]),
        ("spec s; forbid active(m.r;", ["E108 1:22"]),
        ("spec s; module m { request r(x: bool; }", ["E108 1:29"]),
        ("spec s; module m { request r(x: bool { check x; } }", ["E108 1:29"]),
        ("spec s; module m { request r();\nmutex a, b;", ["E108 1:18"]),
        ("spec s; module m { request r() { check a;", ["E108 1:32"]),
        ("spec s; }", ["E106 1:9"]),
        ("spec s; module m {} }\nforbid a b;", ["E106 1:21", "E106 2:10"]),
        ("spec s; enum e { a, b\nforbid a;", ["E108 1:16"]),
        # keywords
        ("spec s; modul m { reqest r(); }\nmutx a, b;", ["E106 1:9", "E106 1:19", "E106 2:1"]),
        ("spec s; module m { request r() { chek a; use p 3 wen b; } }", ["E106 1:34", "E106 1:42", "E106 1:50"]),
        ("spec s; check a;\nmodule m { check a; }", ["E106 1:9", "E106 2:12"]),
        ("spec s; module m { mutex a, b; request r() { forbid a; } }", ["E106 1:20", "E106 1:46"]),
        ("spec s; foo bar baz; qux; { a; b } zap;", ["E106 1:9"]),
        # parts of statements
        ("spec s; enum e { }", ["E106 1:18"]),
        ("spec s; enum e { a, }", ["E106 1:21"]),
        ("spec s; const c = ;\nconst d = -x;", ["E106 1:19", "E106 2:12"]),
        ("spec s; define d a;", ["E106 1:18"]),
        ("spec s; poster p: bool;", ["E106 1:23"]),
        ("spec s; poster p: int = 3;", ["E106 1:23"]),
        ("spec s; poster p: int in 0 .. = 3;", ["E106 1:31"]),
        ("spec s; poster p: int in 0 ... 3 = 3;", ["E106 1:30"]),
        ("spec s; resource r: -3;", ["E106 1:21"]),
        ("spec s; resource r: 2.5;", ["E106 1:21"]),
        ("spec s; resource r: 3 by die;", ["E106 1:26"]),
        ("spec s; latch l: a until b;", ["E106 1:18"]),
        ("spec s; context m { check a; }", ["E106 1:19"]),
        ("spec s; context m.r { wait a; uses p; uses p 2.5; after ; }",
         ["E106 1:29", "E106 1:37", "E106 1:46", "E106 1:57"]),
        ("spec s; context m.r { on done set a = b; on ok a = b; }", ["E106 1:26", "E106 1:48"]),
        ("spec s; limit at most 1 a, b;", ["E106 1:25"]),
        ("spec s; launch m.r when a;", ["E106 1:20"]),
        ("spec s; launch m.r();", ["E106 1:21"]),
        ("spec s; launch m() when a;", ["E106 1:17"]),
        ("spec s; mutex m.r.x, b;", ["E106 1:18"]),
        ("spec s; mutex a over;", ["E106 1:21"]),
        ("spec s; forbid a by reject or;", ["E106 1:30"]),
        ('spec s; forbid a because x;', ["E106 1:26"]),
        ('spec s; forbid a because "x" by reject;', ["E106 1:30"]),
        ("spec s; module m { request r(x: zz zz) { check a b; chek c; } state t: {a b} = a; }",
         ["E106 1:36", "E106 1:50", "E106 1:53", "E106 1:75"]),
        # conditions
        ("spec s; forbid ;", ["E106 1:16"]),
        ("spec s; forbid a = 1;", ["E106 1:18"]),
        ("spec s; forbid a == ;", ["E106 1:21"]),
        ("spec s; forbid a == 1 == 2;", ["E106 1:23"]),
        ("spec s; forbid (a + b) == 2;", ["E106 1:24"]),
        ("spec s; forbid a * (b + 1) == 2;", ["E106 1:20"]),
        ("spec s; forbid (a) == 2;", ["E106 1:20"]),
        ("spec s; forbid a and;", ["E106 1:21"]),
        ("spec s; forbid last(m.r) < ok;", ["E106 1:26"]),
        ("spec s; forbid last(m.r) == done;", ["E106 1:29"]),
        ("spec s; forbid used(p) > x;", ["E106 1:26"]),
        ("spec s; forbid active();", ["E106 1:23"]),
        ("spec s; forbid active(m.r, n.r with a);", ["E106 1:32"]),
        ("spec s; forbid a in 1;", ["E106 1:22"]),
        ("spec s; forbid a in {};", ["E106 1:22"]),
        ("spec s; forbid self;", ["E106 1:20"]),
        ("spec s; forbid m.r.x;", ["E106 1:19"]),
        # reserved words, types, `all`
        ("spec s; module in { request true(); }", ["E110 1:16", "E110 1:29"]),
        ("spec s; enum bool { a } enum real { b }", ["E110 1:14", "E110 1:30"]),
        ("spec s; group all = m.r;", ["E111 1:15"]),
        ("spec s; context m.r { interrupts m.r, all; }", ["E111 1:39"]),
        ("spec s; module m { request r() { interrupts all, self; } }", ["E111 1:45"]),
        # tokens
        ("spec s; forbid a && b;", ["E101 1:18"]),
        ("spec s; forbid !a || b;", ["E101 1:16", "E101 1:19"]),
        ("spec s; forbid a $$$ $$ b;", ["E101 1:18", "E101 1:22"]),
        ("spec s; forbid \x01\x02\x7f a;", ["E101 1:16"]),
        ('spec s; mutex m.a, m.b because "a\tb";', ["E101 1:34"]),
        ('spec s; mutex m.a, m.b because "a\x85b";', ["E101 1:34"]),
        ("spec s; forbid vélo;\nforbid a b;", ["E101 1:17", "E106 2:10"]),
        ("spec s; forbid a / b;", ["E101 1:18"]),
        ("\0\0\0spec s;\0", ["E101 1:1"]),
        ('spec s; forbid a because "x;\nforbid b c;', ["E102 1:26", "E106 2:10"]),
        ('spec s; forbid a because "x\x07y";', ["E101 1:28"]),
        ('spec s; forbid a because "x\\', ["E102 1:26"]),
        ("spec s; /* forbid a;\nforbid b;", ["E103 1:9"]),
        ("spec s; forbid a /* /* */ */;", ["E101 1:28"]),
        ('spec s; forbid a because "\\q\\t\\\\q\\n\\"";', ["E104 1:27", "E104 1:29"]),
        ("spec s; forbid x > 2x;", ["E105 1:20"]),
        ("spec s; forbid x > 1.2.3;", ["E105 1:20"]),
        ("spec s; forbid x > 1e;", ["E105 1:20"]),
        ("spec s; forbid x > 1.;", ["E105 1:20"]),
        ("spec s; forbid x > .5;", ["E105 1:20"]),
        ("spec s; forbid x in 0...5;", ["E106 1:24"]),
        ("spec s; forbid x > 1e-99999;", ["E105 1:20"]),
        ("spec s; forbid x > 1e00000001;", []),
        ("spec s; forbid x > " + "1" * 1001 + ";", ["E105 1:20"]),
        ("spec s; forbid x > " + "1" * 1000 + ";", []),
        # nesting
        ("spec s; forbid " + "(" * 65 + "a" + ")" * 65 + ";\nforbid a b;", ["E109 1:80", "E106 2:10"]),
        ("spec s; forbid " + "(" * 64 + "a" + ")" * 64 + ";", []),
        ("spec s; forbid " + "not " * 65 + "a;", ["E109 1:272"]),
        ("spec s; forbid " + "a implies " * 65 + "a;", ["E109 1:658"]),
        ("spec s; forbid " + "(not a) and " * 500 + "a;", []),
        # lines
        ("spec s;\r\nforbid a b;\r\n\tforbid c d;", ["E106 2:10", "E106 3:11"]),
    ],
)  # fmt: skip
def test_mistakes(text: str, expected: list[str]) -> None:
    assert places(text) == expected


@pytest.mark.parametrize(
    ("text", "message", "advice"),
    [
        ("forbid a\nforbid b;", "expected `;` after the `forbid` rule", ""),
        ("poster p: bool = true", "expected `;` after the `poster` declaration", ""),
        ("context m.r { check a }", "expected `;` after the `check` clause", ""),
        ("forbid (a;", "`(` is not closed", "`)` is missing before `;`"),
        ("module m {", "`{` is not closed", "`}` is missing"),
        ("mutx a, b;", "expected a declaration, a rule or the end of the file, found `mutx`", "did you mean `mutex`?"),
        ("forbid a = 1;", "expected an operator, `because`, `by` or `;`, found `=`", "compare with `==`"),
        ("forbid a ==;", "expected a term, found `;`", ""),
        ("forbid and;", "expected a condition, found `and`", ""),
        ("context m.r { wait a; }", "expected `:`, found `;`", "it reads `wait LABEL: until CONDITION;`"),
        ("context m.r { uses p x; }", "expected a whole number, found `x`",
         "a whole number is written out here; no `const` can stand for it"),
        ("context m.r { on x set a = b; }", "expected `failed`, `interrupted`, `launch` or `ok`, found `x`",
         "it reads `on OUTCOME set STATE = VALUE;`"),
        ("check a;", "expected a declaration, a rule or the end of the file, found `check`",
         "`check` is a clause: it stands in the block of a request or of a context"),
        ("request a();", "expected a declaration, a rule or the end of the file, found `request`",
         "`request` stands in the block of a module"),
        ("module m { mutex a, b; }", "expected a request, a poster, a state or `}`, found `mutex`",
         "`mutex` stands outside all blocks"),
        ("forbid x > 5.;", "`5.` is neither a number nor a name",
         "a fraction has digits on both sides of its point"),
        ("forbid (a + b) > 1;", "expected `and`, `because`, `by`, `implies`, `or` or `;`, found `>`",
         "parentheses group conditions, not terms"),
        ("poster p: = 1;", "expected a type, found `=`", "it reads `poster NAME: TYPE = VALUE else VALUE;`"),
        ("poster p: bool = ;", "expected a value, found `;`", "it reads `poster NAME: TYPE = VALUE else VALUE;`"),
        ("forbid a && b;", "unknown operator `&&`", "write `and`"),
    ],
)  # fmt: skip
def test_wording(text: str, message: str, advice: str) -> None:
    (report,) = reports_on("spec s; " + text)
    assert (report.message, report.help) == (message, advice)


def test_every_single_token_left_out_or_doubled_is_told_at_most_twice() -> None:
    assert reports_on(SAMPLE) == ()
    for token in list(tokens(SAMPLE, []))[:-1]:
        without = SAMPLE[: token.start] + SAMPLE[token.end :]
        doubled = SAMPLE[: token.end] + " " + token.text + SAMPLE[token.end :]
        for text in (without, doubled):
            reports = reports_on(text)
            assert len(reports) <= 2, (token, reports)


def test_mistakes_of_distant_statements_are_all_told() -> None:
    lines = ["spec s;"] + [f"forbid r{i}: a ++ {i};" if i % 3 == 0 else f"forbid r{i}: a;" for i in range(60)]
    assert places("\n".join(lines)) == [f"E106 {i + 2}:{14 + len(str(i))}" for i in range(60) if i % 3 == 0]


def test_no_more_than_a_page_of_mistakes_is_shown() -> None:
    reports = reports_on("spec s;\n" + "forbid a b;\n" * 80)
    assert len(reports) == MAX_REPORTS + 1
    assert (reports[-1].code, reports[-1].message) == ("E199", "30 more mistakes not shown")
    assert len(reports_on("spec s;\n" + "forbid a b;\n" * MAX_REPORTS)) == MAX_REPORTS
    assert reports_on("spec s;\n" + "forbid a b;\n" * 51)[-1].message == "1 more mistake not shown"
    assert reports_on("spec s;\n" + "forbid a b;\n" * 9000)[-1].message == "at least 450 more mistakes not shown"
    assert reports_on("spec s; " + "$ " * 9000)[-1].message == "at least 450 more mistakes not shown"


def test_a_report_as_the_user_sees_it() -> None:
    text = "spec s;\n\tforbid nd.speed > ;\nmodule m {\n    request r() request q();\n}\n"
    assert render_all(reports_on(text), Source("specs/s.exo", text)) == (
        "error[E106]: expected a term, found `;`\n"
        "  --> specs/s.exo:2:20\n"
        "  |\n"
        "2 |     forbid nd.speed > ;\n"
        "  |                       ^\n"
        "  = help: write what the message lists; the grammar stands in docs/language.md, of specs in section 2, "
        "of properties in section 8\n"
        "\n"
        "error[E107]: expected `;` after the `request` declaration\n"
        "  --> specs/s.exo:4:16\n"
        "  |\n"
        "4 |     request r() request q();\n"
        "  |                ^\n"
        "  = help: end the statement with `;`\n"
        "\n"
        "`exover explain E106` tells more"
    )


def test_expectations_in_words() -> None:
    assert expectation(frozenset({"<name>"})) == "a name"
    assert expectation(frozenset({"<string>", "{"})) == "a string or `{`"
    assert expectation(frozenset({"<int>", "<number>", "-", "<name>"})) == "a number or a constant"
    assert expectation(frozenset({"until", "<name>"})) == "a name or `until`"


def test_no_advice_where_there_is_none() -> None:
    (token, *_) = tokens("zzzzzz", [])
    assert advice(Unexpected(token, None, frozenset({"and"}), "forbid")) == ""
