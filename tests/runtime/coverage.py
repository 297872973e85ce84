"""Statement, branch and MC/DC coverage of exover.c and its parts by the tests of tests/runtime (`make coverage`).

No compiler here measures MC/DC (gcc from 14 on, clang from 18 on). So exover.c measures itself: clang tells where its
decisions and conditions are, each is wrapped in a call that notes what it was, and every evaluation of a decision
leaves a vector behind: which conditions were evaluated, what they were, and the outcome. A condition is shown if two
vectors of its decision have another outcome and another value of it, and all others that both evaluated are the same
(unique cause, where conditions that are not evaluated do not count). gcov counts statements.

`EXOVER_COVERAGE=FOLDER pytest …` collects, `python -m tests.runtime.coverage FOLDER` tells.
"""

import gzip
import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

RUNTIME = Path(__file__).parents[2] / "exover" / "runtime"
SOURCE = RUNTIME / "exover.c"
PART = re.compile(r'^#include "(exover_\w+\.h)"$', re.MULTILINE)
"""How exover.c includes what is a part of it."""
EXPLAINED = Path(__file__).parent / "gaps.toml"
BUILDS = (
    ("-DEXOVER_WIDTH=2",),
    ("-DEXOVER_WIDTH=8", "-DEXOVER_DEBUG"),
    ("-DEXOVER_WIDTH=2", f"-DEXOVER_SHAPE={','.join(['1u'] * 60)}"),
)
"""What is compiled differs: every decision of exover.c stands in one of these."""
MOST = 8
"""Conditions of a decision."""
PRELUDE = """
#include <stdio.h>
#include <stdlib.h>
#include <stdint.h>
enum { COVERED = @N@, VECTORS = 96 };
static struct { unsigned seen, value; } mcdc_now[COVERED];
static unsigned mcdc_vectors[COVERED][VECTORS];
static void mcdc_write(void)
{
    FILE *file = fopen(@FILE@, "a");
    for (int i = 0; file != NULL && i < COVERED; i++)
        for (int k = 0; k < VECTORS && mcdc_vectors[i][k] != 0; k++)
            fprintf(file, "%d %u\\n", i, mcdc_vectors[i][k]);
    if (file != NULL)
        fclose(file);
}
__attribute__((unused)) static int mcdc_note(int decision, int condition, int value)
{
    mcdc_now[decision].seen |= 1u << condition;
    mcdc_now[decision].value |= (unsigned)(value != 0) << condition;
    return value;
}
__attribute__((unused)) static int mcdc_decide(int decision, int outcome)
{
    static int begun;
    const unsigned had = mcdc_now[decision].seen | mcdc_now[decision].value << 8;
    const unsigned vector = had | (unsigned)(outcome != 0) << 16 | 1u << 17;
    if (!begun)
        begun = 1, atexit(mcdc_write);
    mcdc_now[decision].seen = mcdc_now[decision].value = 0;
    for (int k = 0; k < VECTORS; k++) {
        if (mcdc_vectors[decision][k] == 0)
            mcdc_vectors[decision][k] = vector;
        if (mcdc_vectors[decision][k] == vector)
            break;
    }
    return outcome;
}
"""

Json = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Decision:
    """Where a decision stands, and where its conditions do: offsets in the source."""

    begin: int
    end: int
    conditions: tuple[tuple[int, int], ...]


# ---- what decides ----


@cache
def whole() -> str:
    """Return exover.c with its parts where it includes them, and with directives that tell the lines of each file; also
    behind each end of a condition of the preprocessor, since what stands within may be left out with its directives.
    """
    written = [f'#line 1 "{SOURCE.name}"']
    for number, row in enumerate(SOURCE.read_text(encoding="utf-8").splitlines(), 1):
        part = PART.match(row)
        if part:
            written += [f'#line 1 "{part[1]}"', *(RUNTIME / part[1]).read_text(encoding="utf-8").splitlines()]
        else:
            written.append(row)
        if part or row.startswith(("#else", "#endif")):
            written.append(f'#line {number + 1} "{SOURCE.name}"')
    return "\n".join([*written, ""])


@cache
def decisions() -> tuple[Decision, ...]:
    """Return the decisions of exover.c and of its parts in any build, in order."""
    found = {decision for flags in BUILDS for decision in _of_build(whole(), flags)}
    return tuple(sorted(found, key=lambda each: (each.begin, -each.end)))


def _of_build(text: str, flags: Sequence[str]) -> Iterator[Decision]:
    dumping = ["-Xclang", "-ast-dump=json", "-fsyntax-only", "-xc", "-"]
    command = ["clang", "-std=c99", "-O1", *flags, f"-I{RUNTIME}", *dumping]
    tree = json.loads(subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout)
    for each in tree["inner"]:
        here = each["kind"] == "FunctionDecl" and "includedFrom" not in each["loc"].get("expansionLoc", each["loc"])
        if here and any(part["kind"] == "CompoundStmt" for part in each.get("inner", ())):
            yield from _below(text, each)


def _below(text: str, node: Json) -> Iterator[Decision]:
    """Yield the decisions below a node: what branches, and what is joined by && or || elsewhere."""
    inner = [part for part in node.get("inner", ()) if part.get("kind")]
    kind = node.get("kind")
    if kind in ("IfStmt", "ConditionalOperator", "WhileStmt"):
        yield from _decision(text, inner[0])
    elif kind == "DoStmt":
        yield from _decision(text, inner[1])
    elif kind == "ForStmt":
        condition = node["inner"][2]
        if condition.get("kind"):
            yield from _decision(text, condition)
    for part in inner:
        joined = _bare(part)
        if joined.get("opcode") in JOINING and kind not in BRANCHING and node.get("opcode") not in JOINING:
            yield from _decision(text, part)
        yield from _below(text, part)


JOINING = ("&&", "||")
BRANCHING = (
    "IfStmt", "WhileStmt", "DoStmt", "ForStmt", "ParenExpr", "ImplicitCastExpr", "ConditionalOperator", "UnaryOperator",
)  # fmt: skip
"""What has its own decision, or only stands around one."""


def _bare(node: Json) -> Json:
    """Return an expression without parentheses, conversions and negations around it."""
    while node.get("kind") in ("ParenExpr", "ImplicitCastExpr") or node.get("opcode") == "!":
        node = node["inner"][0]
    return node


def _decision(text: str, node: Json) -> Iterator[Decision]:
    """Yield the decision of an expression; none if a macro stands for all of it, where nothing can be wrapped."""
    span = _span(text, node)
    macros = [node["range"][side].get("expansionLoc", {}).get("offset") for side in ("begin", "end")]
    if span is not None and (None in macros or macros[0] != macros[1]):
        spans = [_span(text, leaf) for leaf in _leaves(node)]
        conditions = tuple(each for each in spans if each is not None)
        if len(conditions) == len(spans) <= MOST:
            yield Decision(*span, conditions)


def _leaves(node: Json) -> Iterator[Json]:
    inside = _bare(node)
    if inside.get("opcode") in ("&&", "||"):
        for part in inside["inner"]:
            yield from _leaves(part)
    else:
        yield inside


def _span(text: str, node: Json) -> tuple[int, int] | None:
    """Return where an expression stands; None if that is in another file."""
    begin, end = node["range"]["begin"], node["range"]["end"]
    first, last = begin.get("expansionLoc", begin), end.get("expansionLoc", end)
    if "offset" not in first or "offset" not in last:
        return None
    stop = last["offset"] + last["tokLen"]
    if "expansionLoc" in end and text[stop : stop + 1] == "(":
        stop = _closing(text, stop)
    return first["offset"], stop


def _closing(text: str, opening: int) -> int:
    """Return the offset behind the parenthesis that closes one."""
    depth = 0
    for place in range(opening, len(text)):
        depth += (text[place] == "(") - (text[place] == ")")
        if depth == 0:
            return place + 1
    raise ValueError("a parenthesis is not closed")


# ---- what is compiled ----


def instrumented(folder: Path) -> Path:
    """Return exover.c with its decisions wrapped; what it notes goes to a file of the folder."""
    path = folder / "exover.c"
    if not path.exists():
        data = whole().encode()
        inserts: list[tuple[int, int, bytes]] = []
        for number, each in enumerate(decisions()):
            inserts.append((each.begin, -2 * each.end, b"mcdc_decide(%d, (" % number))
            inserts.append((each.end, 1, b") ? 1 : 0)"))
            for place, (begin, end) in enumerate(each.conditions):
                inserts.append((begin, -2 * end + 1, b"mcdc_note(%d, %d, (" % (number, place)))
                inserts.append((end, 0, b") ? 1 : 0)"))
        written = bytearray()
        at = 0
        for offset, _, insert in sorted(inserts, key=lambda each: (each[0], each[1])):
            written += data[at:offset] + insert
            at = offset
        written += data[at:]
        start = PRELUDE.replace("@N@", str(len(decisions()))).replace("@FILE@", f'"{folder / "vectors"}"')
        path.write_bytes(start.encode() + bytes(written))
    return path


def measured(command: list[str], source: Path, folder: Path) -> Path:
    """Return exover.c, or a source that includes it, as an object that counts, compiled with the flags of a command."""
    number = len(list(folder.glob("*.o")))
    out = folder / f"{os.getpid()}.{number}.o"
    flags = [flag for flag in command[1:] if flag != "-Werror" and not flag.startswith("-fsanitize")]
    counting = instrumented(folder)
    compiled = counting if source.name == counting.name else source
    done = subprocess.run(
        [command[0], f"-I{folder}", *flags, "-w", "-O0", "--coverage", f"-I{source.parent}", "-c", compiled, "-o", out],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return out


# ---- what was seen ----


@dataclass(frozen=True, slots=True)
class Gap:
    """A condition that was not shown, or a line that was not run: what stands there, in which line, what is missing."""

    function: str
    text: str
    place: str
    missing: str


Vector = tuple[int, int, int]
"""Which conditions were evaluated, what they were (bits), and the outcome."""


def vectors(folder: Path) -> dict[int, set[Vector]]:
    """Return what was seen of each decision."""
    found: dict[int, set[Vector]] = {number: set() for number in range(len(decisions()))}
    for line in (folder / "vectors").read_text(encoding="ascii").splitlines():
        number, vector = map(int, line.split())
        found[number].add((vector & 255, vector >> 8 & 255, vector >> 16 & 1))
    return found


def shown(seen: set[Vector], condition: int) -> bool:
    """Return whether the condition alone is seen to turn the outcome."""
    bit = 1 << condition
    return any(
        one[2] != other[2] and one[0] & other[0] & bit and (one[1] ^ other[1]) & one[0] & other[0] == bit
        for one in seen
        for other in seen
    )


def values(seen: set[Vector], condition: int) -> set[bool]:
    """Return the values that a condition was seen to have."""
    return {bool(value >> condition & 1) for evaluated, value, _ in seen if evaluated >> condition & 1}


def conditions(folder: Path) -> Iterator[tuple[Gap, int, bool]]:
    """Yield every condition with how many of its two values were seen, and whether it was shown."""
    text, seen = whole(), vectors(folder)
    for number, decision in enumerate(decisions()):
        all_of_it = " ".join(text[decision.begin : decision.end].split())
        for place, (begin, end) in enumerate(decision.conditions):
            condition = " ".join(text[begin:end].split())
            had, alone = values(seen[number], place), shown(seen[number], place)
            missing = "never evaluated" if not had else f"always {str(had == {True}).lower()}" if len(had) == 1 else ""
            what = condition if len(decision.conditions) == 1 else f"{condition} in {all_of_it}"
            yield (
                Gap(_function(text, begin), what, _place(text, begin), missing or ("" if alone else "alone")),
                len(had),
                alone,
            )


def _place(text: str, offset: int) -> str:
    """Return the file and the line of an offset, as `exover.c:1`."""
    *_, told = re.finditer(r'^#line (\d+) "(.+)"\n', text[:offset], flags=re.MULTILINE)
    return f"{told[2]}:{int(told[1]) + text.count(chr(10), told.end(), offset)}"


def _function(text: str, offset: int) -> str:
    heads = re.findall(r"^[A-Za-z][^;{}=#]*?(\w+)\([^;{}]*\)\n\{", text[:offset], flags=re.MULTILINE)
    return str(heads[-1])


def statements(folder: Path) -> dict[str, bool]:
    """Return the lines of exover.c and its parts that hold statements, and whether one was run, over all builds."""
    names = {SOURCE.name, *PART.findall(SOURCE.read_text(encoding="utf-8"))}
    found: dict[str, bool] = {}
    for data in sorted(folder.glob("*.gcda")):
        done = subprocess.run(["gcov", "--json-format", "--stdout", data], cwd=folder, capture_output=True, check=True)
        raw = gzip.decompress(done.stdout) if done.stdout[:2] == b"\x1f\x8b" else done.stdout
        for file in json.loads(raw)["files"]:
            for line in file["lines"] if file["file"] in names else ():
                place = f"{file['file']}:{line['line_number']}"
                found[place] = found.get(place, False) or line["count"] > 0
    return found


def _never_run(lines: dict[str, bool]) -> Iterator[Gap]:
    text, offset = whole(), 0
    for row in text.splitlines(keepends=True):
        offset += len(row)
        place = "" if row.startswith("#line") else _place(text, offset - 1)
        if not lines.get(place, True):
            yield Gap(_function(text, offset), row.strip(), place, "never run")


def report(folder: Path) -> int:
    """Print the figures and every gap with its reason; return 1 if one has none, or a reason has no gap."""
    every = list(conditions(folder))
    lines = statements(folder)
    gaps = [gap for gap, _, alone in every if not alone] + list(_never_run(lines))
    print(_share("statements (lines)", sum(lines.values()), len(lines)))
    print(_share("branches (conditions, true and false)", sum(seen for _, seen, _ in every), 2 * len(every)))
    print(_share("MC/DC (conditions)", sum(alone for _, _, alone in every), len(every)))
    return _explain(gaps)


def _share(what: str, part: int, whole: int) -> str:
    return f"{what}: {part} of {whole}, {100 * part / whole:.1f} %"


def _explain(gaps: Sequence[Gap]) -> int:
    known = tomllib.loads(EXPLAINED.read_text(encoding="utf-8"))["gap"]
    used: set[int] = set()
    bare = 0
    for gap in gaps:
        why = [k for k, each in enumerate(known) if _meant(each, gap)]
        used.update(why[:1])
        reason = known[why[0]]["why"] if why else "NOT EXPLAINED"
        bare += not why
        print(f"{gap.place}: {gap.function}: {gap.text}: {gap.missing}: {reason}")
    stale = [known[k] for k in range(len(known)) if k not in used]
    for each in stale:
        print(f"gaps.toml: no gap any more: {each}")
    print(f"{len(gaps)} gaps, {bare} without a reason")
    return int(bool(bare or stale))


def _meant(known: Json, gap: Gap) -> bool:
    return bool(
        re.fullmatch(known.get("function", ".*"), gap.function) and re.search(known.get("text", ""), gap.text)
    ) and gap.missing in known.get("missing", gap.missing)


if __name__ == "__main__":
    sys.exit(report(Path(sys.argv[1]).resolve()))
