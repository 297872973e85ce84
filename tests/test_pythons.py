"""What some Pythons get wrong, seen without them; `make pythons` runs the tests under those that are here."""

import ast
from pathlib import Path

import exover

ROOT = Path(exover.__file__).parent
Function = ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda
Comprehension = ast.ListComp | ast.SetComp | ast.DictComp | ast.GeneratorExp


class Scope(ast.NodeVisitor):
    """The names of one function: what it binds, what its comprehensions bind, and what is read elsewhere in it."""

    def __init__(self, function: Function) -> None:
        self.bound = {argument.arg for argument in ast.walk(function.args) if isinstance(argument, ast.arg)}
        self.in_comprehensions: set[str] = set()
        self.read: set[str] = set()
        self._targets: frozenset[str] = frozenset()
        for statement in function.body if isinstance(function.body, list) else [function.body]:
            self.visit(statement)

    def visit(self, node: ast.AST) -> None:
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                self.bound.add(name)
            case ast.Lambda():
                pass
            case ast.ListComp() | ast.SetComp() | ast.DictComp() | ast.GeneratorExp():
                self._comprehension(node)
            case ast.Name(id=name, ctx=context) if name not in self._targets:
                (self.read if isinstance(context, ast.Load) else self.bound).add(name)
            case ast.MatchAs(name=str(name)) | ast.MatchStar(name=str(name)) | ast.ExceptHandler(name=str(name)):
                self.bound.add(name)
                self.generic_visit(node)
            case _:
                self.generic_visit(node)

    def _comprehension(self, node: Comprehension) -> None:
        around = self._targets
        targets = (part for generator in node.generators for part in ast.walk(generator.target))
        names = {part.id for part in targets if isinstance(part, ast.Name)}
        self.in_comprehensions |= names
        self._targets = around | names
        self.generic_visit(node)
        self._targets = around

    def taken_for_local(self) -> set[str]:
        """Return what one comprehension binds and is read elsewhere as of outside: not found by all of 3.12 and 3.13.

        Comprehensions are part of the function since 3.12 (PEP 709; CPython issues 118513 and 156664).
        """
        return self.in_comprehensions & self.read - self.bound


def clashes(source: str) -> set[str]:
    """Return `taken_for_local` of all functions of a module."""
    nodes = list(ast.walk(ast.parse(source)))
    lines = [node.lineno for node in nodes if isinstance(node, Comprehension)]
    spans = ((node, range(node.lineno, (node.end_lineno or 0) + 1)) for node in nodes if isinstance(node, Function))
    functions = (node for node, span in spans if any(line in span for line in lines))
    return {name for function in functions for name in Scope(function).taken_for_local()}


def test_no_name_is_bound_by_a_comprehension_and_read_from_outside_in_one_function() -> None:
    found = {path.relative_to(ROOT).as_posix(): clashes(path.read_text("utf-8")) for path in ROOT.rglob("*.py")}
    assert {path: names for path, names in found.items() if names} == {}


def test_such_names_are_found() -> None:
    source = "def row(x): ...\ndef f(rows): return [row for row in rows], {n: [row(x) for x in rows] for n in 'ab'}\n"
    assert clashes(source) == {"row"}
    assert clashes(source.replace("[row for row in", "[each for each in")) == set()
