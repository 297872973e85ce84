"""`python -m benchmarks.ask SPEC [CHECK …]`: ask these checks, or all whose violation is an error; say what came out.

One line for each check, verdict and method: how many subjects, and the processor seconds that their answers took.
"""

import sys
from collections import Counter
from pathlib import Path
from time import process_time

from exover import pipeline
from exover.checks.finding import Verdict
from exover.checks.run import TaskRunner, questions
from exover.model.property import NO_PROPERTIES
from exover.report.summary import ERRORS
from exover.source import Source


def main(path: str, *wanted: str) -> int:
    """Print the answers; return 0 iff all hold."""
    loaded = pipeline.load(Source(path, Path(path).read_text(encoding="utf-8")))
    assert loaded.model is not None
    compiled = pipeline.build(loaded.model).compiled
    asked = tuple(questions(loaded.model, ERRORS, NO_PROPERTIES))
    runner = TaskRunner(compiled, NO_PROPERTIES, tuple(pair for pair in asked if not wanted or pair[0].name in wanted))
    counts: Counter[tuple[str, Verdict, str]] = Counter()
    seconds: dict[tuple[str, Verdict, str], float] = {}
    for number in range(len(runner.questions)):
        begin = process_time()
        finding = runner.answer("bdd", number, lambda what: None)
        key = finding.check, finding.verdict, finding.method
        counts[key] += 1
        seconds[key] = seconds.get(key, 0) + process_time() - begin
    for key, count in counts.items():
        print(f"{count} {' '.join(key)} ({seconds[key]:.1f} s)")
    return 0 if all(verdict == "holds" for _, verdict, _ in counts) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
