"""Answers to single questions that `exover check` keeps beside a project (docs/checks.md, "The cache")."""

import argparse
import json
from collections.abc import Mapping
from dataclasses import field
from pathlib import Path
from typing import Any

from exover.cli.report_cache import digest, folder_of, helpers, is_off, program, write
from exover.dataclass import dataclass
from exover.model.wire import Json

FRESH = ("certificate", "timings", "timeout", "memory")
"""Options with which every question is asked: they write what is evidence, measure or limit."""
MOST = 4_000
"""Answers that are kept of one loop; of more, those are dropped that were not used last."""


def answers_of(arguments: argparse.Namespace, spec: str) -> "AnswerFiles | None":
    """Return where the answers about a spec are kept; None if they are not, or are not to be used."""
    if is_off(arguments) or spec == "-" or any(getattr(arguments, name) for name in FRESH):
        return None
    try:
        who = digest([*program(), *helpers(arguments)])
    except OSError:
        return None
    return AnswerFiles(folder_of(Path(spec)), who)


@dataclass
class AnswerFiles:
    """Answers in a folder, a file for each loop; `who` tells programs apart that might answer otherwise."""

    folder: Path
    who: str
    _known: dict[str, dict[str, Any]] = field(default_factory=dict)

    def find(self, loop: str) -> Mapping[str, Any]:
        """Return what is kept of a loop, by question; nothing if the file is damaged."""
        if loop not in self._known:
            self._known[loop] = self._read(loop)
        return self._known[loop]

    def keep(self, loop: str, answers: Mapping[str, Json]) -> None:
        """Keep answers, beside what others have kept meanwhile."""
        before = self._read(loop)
        together = {key: value for key, value in before.items() if key not in answers} | dict(answers)
        self._known[loop] = dict(list(together.items())[-MOST:])
        content = {"sha256": _seal(self.who, loop, self._known[loop]), "answers": self._known[loop]}
        write(self._file(loop), json.dumps(content))

    def _read(self, loop: str) -> dict[str, Any]:
        try:
            found = json.loads(self._file(loop).read_bytes())
            answers = found["answers"]
            if isinstance(answers, dict) and found["sha256"] == _seal(self.who, loop, answers):
                return answers
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            pass
        return {}

    def _file(self, loop: str) -> Path:
        return self.folder / f"answers-{digest([self.who, loop])[:32]}.json"


def _seal(who: str, loop: str, answers: Mapping[str, Json]) -> str:
    """Return what tells a damaged file: the digest of what it holds and of what it is for."""
    return digest([who, loop, json.dumps(answers)])
