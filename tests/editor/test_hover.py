"""What is told where one points at a name."""

from exover.editor.analysis import analyse_spec
from exover.editor.hover import hover
from exover.source import Source

SPEC = """spec s; resource fuel: 9 consumable because "no fuel left"; resource power: 3;
module m {
    request burn(hot: bool) { consumes fuel 2; consumes fuel 4 when hot because "hot burns take more"; uses power 1; }
    request fill() { produces fuel 9; }
}
"""


def told(name: str, text: str = SPEC) -> str:
    found = hover(analyse_spec(Source("s.exo", text)), text.index(name))
    assert found is not None
    return found[0]


def test_a_consumable_is_among_what_decides_about_a_request() -> None:
    _, decided = told("burn(").split("decided by:\n\n")
    assert decided.splitlines() == ["- `fuel`: no fuel left", "- `power`"]


def test_of_a_consumable_it_is_told_who_consumes_it() -> None:
    declared, consumed = told("fuel: 9").split("\n\nconsumed by:\n\n")
    assert declared.endswith("```")
    assert consumed.splitlines() == ["- `m.burn`: 2", "- `m.burn`: 4 when `hot`"]
    assert "consumed by" not in told("power: 3")


def test_a_declaration_is_told_without_its_comments() -> None:
    spec = """spec s; enum side { left, // the left one
        right } module m "a  {b" { request r(x: bool /* ) { */, // else
        y: side) { check x; } }"""
    assert told("side", spec).endswith("```exo\nenum side { left, right }\n```")
    assert "```exo\nrequest r(x: bool, y: side)\n```" in told("r(", spec)
    assert told('m "', spec).endswith('```exo\nmodule m "a  {b"\n```')


def test_the_text_of_a_rule_is_no_markdown() -> None:
    spec = SPEC.replace("no fuel left", "a_b_c <b> *d*\\n# e")
    assert "- `fuel`: a\\_b\\_c &lt;b&gt; \\*d\\*\ufffd\\# e\n" in told("burn(", spec)
