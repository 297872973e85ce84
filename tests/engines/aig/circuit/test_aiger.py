"""Files in the format AIGER: what is written is read back, by us and by ABC; what is none is refused."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from exover.engines.aig.circuit import aiger
from exover.engines.aig.circuit.aiger import Document, Names, binary, text
from exover.engines.aig.circuit.graph import Circuit, Fanins, Graph, LatchNode
from exover.engines.process import run
from tests.support.aiger_reader import NoAiger, read
from tests.support.circuits import counter, random_circuit, reachable
from tests.support.needed import needs_abc

TOGGLE = b"aag 4 1 1 0 2 1\n2\n4 7 1\n8\n8 4 2\n6 4 2\ni0 go\nl0 on off\nb0 both\nc\nof two\nlines\n"


def named(circuit: Circuit) -> Document:
    """Return a document that says all that there is to say."""
    latches = [2 * latch.node for latch in circuit.latches]
    names = Names(
        tuple(f"in {place}" for place in range(len(circuit.inputs))), ("a", "", "c"), ("x.y",), ("comes", "goes")
    )
    return Document(circuit, ((latches[0], latches[1] ^ 1), (circuit.bad[0],)), (latches[2],), names, ("one", "two"))


@pytest.mark.parametrize("form", [binary, text])
@pytest.mark.parametrize("seed", range(20))
def test_what_is_written_is_read(seed: int, form: "type[binary]") -> None:
    document = named(random_circuit(seed))
    once = read(form(document))
    assert read(binary(once)) == read(text(once)) == once
    assert (once.names, once.comment) == (document.names, document.comment)
    assert [latch.initial for latch in once.circuit.latches] == [latch.initial for latch in document.circuit.latches]
    assert reachable(once.circuit) == reachable(document.circuit)
    assert list(map(len, once.justice)) == [2, 1] and len(once.fairness) == 1


def test_the_bytes_are_those_of_the_format() -> None:
    graph = Graph()
    go, on = graph.input(), graph.latch(True)
    both = graph.conjunction(go, on)
    document = Document(graph.circuit([both ^ 1], [both]), names=Names(("go",)), comment=("made",))
    assert text(document) == b"aag 3 1 1 0 1 1\n2\n4 7 1\n6\n6 4 2\ni0 go\nc\nmade\n"
    assert binary(document) == b"aig 3 1 1 0 1 1\n7 1\n6\n\x02\x02i0 go\nc\nmade\n"


def test_differences_of_many_digits() -> None:
    circuit = counter(14, 9000, 8191)
    padded = replace(circuit, fanins=Fanins.of([*circuit.fanins, *[None] * 20_000]))
    inputs = (*circuit.inputs, *range(len(circuit.fanins), len(padded.fanins)))
    document = Document(replace(padded, inputs=inputs))
    assert read(binary(document)) == read(text(document))


def test_conjunctions_may_stand_in_any_order() -> None:
    found = read(TOGGLE)
    assert found.names == Names(("go",), ("on off",), ("both",)) and found.comment == ("of two", "lines")
    assert found.circuit.latches == (LatchNode(2, True, 7),)
    assert reachable(found.circuit) == {0}


def test_outputs_are_bad_where_nothing_else_is() -> None:
    found = read(b"aag 1 1 0 1 0\n2\n3\no0 odd\n")
    assert found.circuit.bad == (3,) and found.names.bad == ("odd",)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"aag\n",
        b"aag 1 1 0 0\n2\n",
        b"nonsense 1 0 0 0 0\n",
        b"aag 1 1 0 1 0 1\n2\n2\n2\n",
        b"aag 1 1 0 0 0 0 1\n2\n2\n",
        b"aag 1 0 1 0 0\n2 3 2\n",
        b"aag 1 1 0 0 0 1\n2\n4\n",
        b"aag 2 2 0 0 0\n2\n2\n",
        b"aag 2 1 0 0 1 1\n2\n4\n4 5 2\n",
        b"aag 3 1 0 0 1 1\n2\n6\n4 2 2\n",
        b"aig 2 1 0 0 1 1\n4\n",
        b"aig 2 1 0 0 1 1\n4\n\x00\x00",
        b"aag 1 1 0 0 0\n2\nq0 what\n",
        b"aag 1 1 0 0 0\n2\ni7 where\n",
        b"aag 1 1 0 0 0 -1\n2\n",
        b"\xff\xfe\n",
    ],
)
def test_what_is_no_such_file_is_refused(data: bytes) -> None:
    with pytest.raises(NoAiger):
        read(data)


@pytest.mark.parametrize("form", [binary, text])
def test_no_part_of_a_file_is_a_file_of_the_same_circuit(form: "type[binary]") -> None:
    whole = form(Document(random_circuit(3)))
    for length in range(len(whole)):
        with pytest.raises(NoAiger):
            read(whole[:length])


def test_a_name_stands_in_one_line() -> None:
    with pytest.raises(ValueError, match="breaks the line"):
        binary(Document(counter(2, 3, 3), names=Names(("two\nlines",))))


@needs_abc
def test_abc_reads_what_is_written(tmp_path: Path) -> None:
    circuit = random_circuit(5)
    (tmp_path / "f.aig").write_bytes(aiger.binary(Document(circuit, names=Names((), ("a", "b c", "d")))))
    program = shutil.which("berkeley-abc") or shutil.which("abc") or ""
    printed = run([program, "-q", "read_aiger f.aig; print_stats"], tmp_path, seconds=60).printed
    assert f"i/o ={len(circuit.inputs):5d}/{len(circuit.bad):5d}  lat ={len(circuit.latches):5d}" in printed
