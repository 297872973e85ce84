"""The cache of answers to single questions of `exover check` (docs/checks.md, "The cache")."""

import argparse
import json
from collections.abc import Mapping
from dataclasses import field
from pathlib import Path
from typing import Any

from exover.cli.report_cache import folder_of, helpers, is_off, program, write
from exover.dataclass import dataclass
from exover.digest import digest_of
from exover.model.wire import Json

FRESH = ("certificate", "timings", "timeout", "memory")
"""The options with which every question is asked anew: they write evidence, measure or limit something."""
MOST = 4_000
"""The most answers that are kept of one loop; of more, those kept or used longest ago are dropped."""


def answers_of(arguments: argparse.Namespace, spec: str) -> "AnswerFiles | None":
    """Return the store of the answers about a spec; None if it is not to be used."""
    if is_off(arguments) or spec == "-" or any(getattr(arguments, name) for name in FRESH):
        return None
    try:
        who = digest_of(*program(), *helpers(arguments))
    except OSError:
        return None
    return AnswerFiles(folder_of(Path(spec)), who)


@dataclass
class AnswerFiles:
    """Answers in a folder, a file for each loop; `who`: a digest of the programs that give the answers."""

    folder: Path
    who: str
    _known: dict[str, dict[str, Any]] = field(default_factory=dict)

    def find(self, loop: str) -> Mapping[str, Any]:
        """Return the answers about a loop, by question; empty if there are none or the file is damaged."""
        if loop not in self._known:
            self._known[loop] = self._read(loop)
        return self._known[loop]

    def keep(self, loop: str, answers: Mapping[str, Json]) -> None:
        """Add answers to those in the file, which other processes may have changed since it was read."""
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
        return self.folder / f"answers-{digest_of(self.who, loop)[:32]}.json"


def _seal(who: str, loop: str, answers: Mapping[str, Json]) -> str:
    """Return the digest of the content and the purpose of a file, by which a damaged file is recognised."""
    return digest_of(who, loop, json.dumps(answers))
