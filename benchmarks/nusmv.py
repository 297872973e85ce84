"""NuSMV 2.6 on requests that wait for their neighbours in a conflict graph: the same closed loop as SMV text.

One event a step: an ask, a report, an abort, or giving up what waits. Requests that wait are launched in their order as
soon as nothing in their way is active, in the step that made it so. The order of the variables is FORCE's (Aloul,
Markov, Sakallah 2003), without dynamic reordering: the best of those tried, which are as declared and breadth first,
each with and without dynamic reordering, and this one. The binary comes with the wheel of pyboolnet (`make setup`
installs it alone, without what it depends on).
"""

import tempfile
from pathlib import Path

from benchmarks.measure import Run, watched
from exover.engines.smv.program import environment

ROUNDS = 100
SCRIPT = """set on_failure_script_quits
read_model -i model.smv
flatten_hierarchy
encode_variables
build_model
compute_reachable
print_reachable_states
quit
"""


def reachable(program: Path, size: int, edges: list[tuple[int, int]], limit: float) -> tuple[Run, str]:
    """Return what it took to build the reachable set, and how many states NuSMV says it has; nothing if it did not."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "model.smv").write_text(model(size, edges))
        Path(folder, "script").write_text(SCRIPT)
        run = watched([str(program), "-source", "script"], limit, Path(folder), environment(Path(folder)))
        counts = [line for line in run.output.splitlines() if line.startswith("reachable states:")]
        return run, counts[0].split(":")[1].split("(")[0].strip() if counts else ""


def model(size: int, edges: list[tuple[int, int]]) -> str:
    """Return the SMV text of requests that wait for each other along these edges."""
    beside: dict[int, list[int]] = {number: [] for number in range(size)}
    for first, second in edges:
        beside[first].append(second)
        beside[second].append(first)
    lines = ["MODULE main", "IVAR", "  kind : {ask, report, abort, give};", f"  who : 0..{size - 1};", "VAR"]
    for number in order(beside):
        lines += [f"  s{number} : {{idle, run, stop}};", f"  w{number} : boolean;"]
    lines.append("DEFINE")
    for number, others in beside.items():
        free = [f"!busy{other}" for other in others] + [f"!go{other}" for other in others if other < number]
        asked = f"kind = ask & who = {number} & !w{number}"
        lines += [
            f"  ended{number} := kind = report & who = {number} & s{number} != idle;",
            f"  busy{number} := s{number} != idle & !ended{number};",
            f"  go{number} := {' & '.join([f'!busy{number}', *free])} & (w{number} & kind = report | {asked});",
        ]
    lines.append("ASSIGN")
    for number in beside:
        aborted = f"kind = abort & who = {number} & s{number} = run : stop"
        given = f"kind = give & who = {number} : FALSE"
        waits = f"kind = ask & who = {number} & s{number} = idle : TRUE"
        lines += [
            f"  init(s{number}) := idle;",
            f"  init(w{number}) := FALSE;",
            f"  next(s{number}) := case go{number} : run; ended{number} : idle; {aborted}; TRUE : s{number}; esac;",
            f"  next(w{number}) := case go{number} : FALSE; {given}; {waits}; TRUE : w{number}; esac;",
        ]
    return "\n".join([*lines, ""])


def order(beside: dict[int, list[int]]) -> list[int]:
    """Return the requests so that neighbours stand near each other, by FORCE."""
    found = best = list(beside)
    least = None
    for _ in range(ROUNDS):
        place = {number: position for position, number in enumerate(found)}
        span = sum(abs(place[one] - place[other]) for one, others in beside.items() for other in others)
        if least is None or span < least:
            best, least = found, span
        pull = {one: [place[one], *((place[one] + place[o]) / 2 for o in others)] for one, others in beside.items()}
        found = sorted(found, key=lambda number: (sum(pull[number]) / len(pull[number]), number))
    return best
