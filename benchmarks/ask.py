"""`python -m benchmarks.ask SPEC [CHECK …]`: ask these checks, or all whose violation is an error; say what came out.

One line for each check, verdict and method: how many subjects, and the processor seconds that their answers took.
"""

import sys
from collections import Counter
from pathlib import Path

from exover import pipeline
from exover.checks.questions import CHECKS
from exover.checks.run import check_all
from exover.checks.schedule.engines import DIAGRAMS
from exover.checks.schedule.plan import CheckPlan
from exover.source import Source


def main(path: str, *wanted: str) -> int:
    """Print the answers; return 0 iff there is one to each question."""
    loaded = pipeline.load(Source(path, Path(path).read_text(encoding="utf-8")))
    assert loaded.model is not None
    names = wanted or [check.name for check in CHECKS if check.severity == "error"]
    plan = CheckPlan(names, engines=DIAGRAMS)
    findings = check_all(pipeline.build(loaded.model).compiled, lambda what: None, plan).findings
    counts = Counter((finding.check, finding.verdict, finding.method) for finding in findings)
    for key, count in counts.items():
        seconds = sum(each.seconds for each in findings if (each.check, each.verdict, each.method) == key)
        print(f"{count} {' '.join(key)} ({seconds:.1f} s)")
    return 3 if any(finding.verdict == "unknown" for finding in findings) else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
