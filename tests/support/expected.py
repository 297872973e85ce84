"""What a spec expects of its checks: its lines `// expect: CHECK SUBJECT VERDICT`, those of included parts too."""

import re
from pathlib import Path

from exover.places import files_of

LINE = re.compile(r"^// expect: (.*?)\s*$", re.MULTILINE)


def expected(spec: Path) -> set[str]:
    """Return the lines of a spec and of what it includes, through others too."""
    return {line for file in files_of(str(spec)) for line in LINE.findall(Path(file).read_text(encoding="utf-8"))}
