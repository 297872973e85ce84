"""Graphs as DOT, Mermaid and SVG: read back they are the graph."""

import re
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

import exover
from exover.graph import dot, mermaid, svg
from exover.graph.interactions import Interaction, InteractionGraph, Participant, interactions
from exover.graph.words import told
from exover.rendering import draw
from tests.support.command import Run, environment

ROOT = Path(__file__).resolve().parents[2]
SPECS = sorted((ROOT / "specs").glob("*.exo"))
STRING = r'"((?:[^"\\]|\\.)*)"'
ODD = InteractionGraph(
    'a"b\\',
    (Participant('m.x"\\', "request", 'say "#1" \\'), Participant("end", "poster", "end")),
    (Interaction("excludes", 'm.x"\\', "poster end", ('rule "1" #2',), True),),
)
"""Names that no spec can have today."""


def graph_of(path: Path | None) -> InteractionGraph:
    """Return the graph of a spec, or the odd one."""
    return ODD if path is None else interactions(exover.load(path).model)


def expected(graph: InteractionGraph) -> list[tuple[str, str, str]]:
    return [(edge.source, told(edge), edge.target) for edge in graph.interactions]


def from_dot(text: str) -> tuple[dict[str, str], list[tuple[str, str, str]]]:
    """Return the labels of the nodes by their names, and the edges with theirs."""
    plain = {
        f"{n}": re.sub(r"\\(.)", r"\1", label) for n, label in re.findall(rf"^ +{STRING} \[label={STRING}", text, re.M)
    }
    edges = re.findall(rf"^ +{STRING} -> {STRING} \[label={STRING}", text, re.M)
    clean = [
        tuple(re.sub(r"\\(.)", r"\1", word) for word in (source, label, target)) for source, target, label in edges
    ]
    return {re.sub(r"\\(.)", r"\1", name): label for name, label in plain.items()}, clean  # type: ignore[return-value]


@pytest.mark.parametrize("path", [*SPECS, None], ids=lambda path: path.stem if path else "odd")
def test_dot_says_what_the_graph_is(path: Path | None) -> None:
    graph = graph_of(path)
    nodes, edges = from_dot(dot.render(graph))
    assert nodes == {each.id: each.text for each in graph.participants}
    assert edges == expected(graph)


def entities(text: str) -> str:
    return text.replace("#quot;", '"').replace("#35;", "#")


@pytest.mark.parametrize("path", [*SPECS, None], ids=lambda path: path.stem if path else "odd")
def test_mermaid_says_what_the_graph_is(path: Path | None) -> None:
    graph = graph_of(path)
    text = mermaid.render(graph)
    lines = text.splitlines()
    assert lines[0] == "flowchart LR"
    nodes = {n: entities(label) for n, label in re.findall(r'^ +(n\d+)[\[({]+"([^"]*)"[\])}]+$', text, re.M)}
    named = {f"n{number}": each for number, each in enumerate(graph.participants)}
    assert nodes == {number: each.text for number, each in named.items()}
    found = re.findall(r'^ +(n\d+) (?:---|--x|-->|==>|--o|-\.-[>xo]?)\|"([^"]*)"\| (n\d+)$', text, re.M)
    assert [(named[source].id, entities(label), named[target].id) for source, label, target in found] == expected(graph)
    blocks = sum(line.startswith("    subgraph ") for line in lines), sum(line == "    end" for line in lines)
    assert blocks[0] == blocks[1]
    assert len(lines) == 1 + len(nodes) + len(found) + sum(blocks)


@pytest.mark.skipif(shutil.which(svg.PROGRAM) is None, reason="Graphviz is not installed")
@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_svg_draws_every_node_and_edge(path: Path) -> None:
    graph = graph_of(path)
    root = ET.fromstring(draw(graph, "svg"))
    titles = {"node": [], "edge": []}
    for group in root.iter("{http://www.w3.org/2000/svg}g"):
        if group.get("class") in titles:
            titles[group.get("class")].append(group.find("{http://www.w3.org/2000/svg}title").text)
    assert sorted(titles["node"]) == sorted(each.id for each in graph.participants)
    assert sorted(titles["edge"]) == sorted(f"{edge.source}->{edge.target}" for edge in graph.interactions)


def test_the_command_prints_and_writes(run: Run, tmp_path: Path) -> None:
    spec = ROOT / "specs" / "rover.exo"
    printed = run("graph", spec)
    assert (printed.returncode, printed.stderr) == (0, "")
    assert printed.stdout == draw(interactions(exover.load(spec).model), "dot")
    written = run("graph", spec, "--format", "mermaid", "--only", "excludes,wakes", "--out", "new/rover.mmd")
    assert (written.returncode, written.stdout, written.stderr) == (0, "", "")
    text = (tmp_path / "new" / "rover.mmd").read_text(encoding="utf-8")
    assert text == draw(interactions(exover.load(spec).model, ("excludes", "wakes")), "mermaid")
    assert "wakes: power" in text and "launches" not in text


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--only", "likes"), "invalid choice: 'likes'"),
        (("--format", "png"), "invalid choice: 'png'"),
        (("--out", "folder/"), "folder/ is a folder: --out names the file to write"),
        (("--out", "file/graph.dot"), "cannot write"),
    ],
)
def test_what_cannot_be_is_refused(run: Run, tmp_path: Path, arguments: tuple[str, str], said: str) -> None:
    (tmp_path / "file").write_text("")
    ended = run("graph", ROOT / "specs" / "rover.exo", *arguments)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert said in ended.stderr


def test_a_spec_with_a_mistake_is_not_drawn(run: Run, tmp_path: Path) -> None:
    (tmp_path / "wrong.exo").write_text("spec wrong; module m { request r(; }")
    ended = run("graph", "wrong.exo", "--out", "wrong.dot")
    assert ended.returncode == 2 and "wrong.exo:1:" in ended.stderr
    assert not (tmp_path / "wrong.dot").exists()


def test_svg_needs_graphviz(run: Run, tmp_path: Path) -> None:
    ended = run("graph", ROOT / "specs" / "rover.exo", "--format", "svg", env=environment(PATH=str(tmp_path)))
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr.endswith("no dot was found on PATH; install Graphviz, or take --format dot or mermaid\n")


def test_a_graphviz_that_fails_is_told(run: Run, tmp_path: Path) -> None:
    program = tmp_path / "dot"
    program.write_text("#!/bin/sh\necho no layout here >&2\nexit 3\n")
    program.chmod(0o755)
    path = f"{tmp_path}:/usr/bin:/bin"
    ended = run("graph", ROOT / "specs" / "rover.exo", "--format", "svg", env=environment(PATH=path))
    assert (ended.returncode, ended.stdout) == (2, "")
    assert "ended with status 3: no layout here" in ended.stderr


def test_more_edges_than_mermaid_draws_are_noted(run: Run, tmp_path: Path) -> None:
    requests = "".join(f"request r{number}();" for number in range(33))
    (tmp_path / "many.exo").write_text(f"spec many; module m {{ {requests} }} mutex m.*;")
    ended = run("graph", "many.exo", "--format", "mermaid")
    assert ended.returncode == 0
    assert "note: 528 edges: Mermaid draws 500" in ended.stderr
    assert run("graph", "many.exo").stderr == ""
