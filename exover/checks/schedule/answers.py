"""Answers that were given before, and when they may be given again (docs/checks.md, "The cache").

An answer is kept by what it depends on: the loop (the model and its tables, without texts and places, and who is
asked), the assumptions, and the question itself. What depends on places and texts is not kept: runs are answered anew.
"""

from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from functools import cached_property
from hashlib import sha256
from typing import Any, Protocol

from exover.checks.finding import Finding
from exover.checks.questions.property import named
from exover.checks.questions.question import Check, Question
from exover.checks.schedule.engines import EngineName, Engines
from exover.dataclass import dataclass
from exover.model.canonical import essence
from exover.model.event import Action, Event, Invalid
from exover.model.property import Properties, formulas
from exover.model.trace import Trace, run
from exover.model.wire import Json, event_json
from exover.model.wire_reading import read_entries
from exover.ocrd.compile import Compiled
from exover.ocrd.packing import pack
from exover.ocrd.trace_replay import TraceReplay

Asked = tuple[Check, Question]
OF_BYTES = ("tables", "consistency")
"""Checks that look at no step, so that no assumption counts."""
VACUITY = "vacuity"
OF_PROPERTIES = ("property", VACUITY)
"""Checks whose subjects are properties; those of all others are things of the model."""


class AnswerStore(Protocol):
    """Where answers are kept, by the digests of a loop and of a question; nothing in it need be true."""

    def find(self, loop: str) -> Mapping[str, Any]:
        """Return what is kept of a loop by question."""
        ...

    def keep(self, loop: str, answers: Mapping[str, Json]) -> None:
        """Keep what was answered about a loop, by question; where that cannot be, do nothing."""
        ...


class NoStore:
    """Keeps nothing."""

    def find(self, loop: str) -> Mapping[str, Any]:
        """Return nothing."""
        return {}

    def keep(self, loop: str, answers: Mapping[str, Json]) -> None:
        """Forget them."""


NO_STORE = NoStore()


@dataclass(frozen=True, slots=True)
class LoopFigures:
    """The engines in the order in which they are asked about a loop, and the bits of its state."""

    names: tuple[EngineName, ...]
    state_bits: int | None


@dataclass(frozen=True)
class StoredLoop:
    """What a store knows of a loop that these engines are asked about, in any order."""

    compiled: Compiled
    properties: Properties
    engines: Engines
    store: AnswerStore

    def find(self) -> Mapping[str, Any]:
        """Return what is kept, by question."""
        return self.store.find(self._key)

    def keep(self, answers: Mapping[str, Json]) -> None:
        """Keep answers by question, if any of these is new."""
        if answers.keys() - self.find().keys():
            self.store.keep(self._key, answers)

    def figures(self) -> LoopFigures | None:
        """Return the figures, if they are known."""
        match self.find().get(self.of_figures):
            case {"names": [*names], "state_bits": None | int() as bits} if sorted(names) == sorted(self.engines.names):
                return LoopFigures(tuple(names), bits)
        return None

    @cached_property
    def _key(self) -> str:
        """The digest of the loop: the model without its texts, the bytes of the tables without its digest, engines in
        any order."""
        plain = pack(replace(self.compiled.tables, digest=bytes(32), flags=0))
        engines = replace(self.engines, names=tuple(sorted(self.engines.names)))
        return _digest(essence(self.compiled.model), sha256(plain).hexdigest(), essence(engines))

    @property
    def of_figures(self) -> str:
        """The digest of what the figures depend on: all that the properties tell apart."""
        return _digest("figures", essence(tuple(formulas(self.properties))), self.assumed)

    @cached_property
    def assumed(self) -> str:
        """The assumptions, as they are told apart."""
        return essence((tuple(each.formula for each in self.properties.assumptions), int(self.properties.fair)))


@dataclass
class KnownAnswers:
    """What a store knows of the questions about one loop, put to the engines of these `names` in their order."""

    loop: StoredLoop
    names: tuple[EngineName, ...]
    recalled: dict[str, Finding] = field(default_factory=dict)
    """By question the answers that were in the store, and are believed."""

    def answered(self, asked: Iterable[Asked]) -> dict[int, Finding]:
        """Return by number the questions whose answers are known."""
        kept = self.loop.find()
        found: dict[int, Finding] = {}
        for number, (check, question) in enumerate(asked if kept else ()):
            key = self._key(check, question)
            finding = self._read(question, kept.get(key))
            if finding is not None:
                found[number] = self.recalled[key] = finding
        return found

    def keep(self, asked: Iterable[Asked], findings: Iterable[Finding], bits: int | None, replayed: bool) -> None:
        """Keep what is settled and can be read again as it is; nothing is written if none of it is new.

        `replayed`: what breaks something was shown on the emitted C as well; else it is not kept. `bits`: those of a
        state; None if that is not known, which may have been for want of time.
        """
        if self.loop.store is NO_STORE:
            return
        answers: dict[str, Json] = {}
        for (check, question), finding in zip(asked, findings, strict=True):
            key = self._key(check, question)
            if key in self.recalled or (is_sure(finding, replayed) and self._is_read(question, finding)):
                answers[key] = self._written(finding)
        if bits is not None:
            answers[self.loop.of_figures] = {"names": list(self.names), "state_bits": bits}
        self.loop.keep(answers)

    def _key(self, check: Check, question: Question) -> str:
        """Return the digest of a question: the check, the subject, who is asked in which order, the formula of a
        property, the assumptions."""
        said, properties = "", self.loop.properties
        if check.name in OF_PROPERTIES and any(each.name == question.subject for each in properties.properties):
            prop = named(properties, question.subject)
            said = essence(prop.premise if check.name == VACUITY else (prop.form, prop.formula, prop.premise))
        assumed = "" if check.name in OF_BYTES else self.loop.assumed
        return _digest(check.name, question.subject, *self.names, said, assumed)

    # ---- what is kept ----

    def _written(self, finding: Finding) -> Json:
        """Return an answer without what depends on places and texts."""
        trace = finding.trace
        return {
            "verdict": finding.verdict,
            "engine": finding.engine,
            "method": finding.method,
            "message": finding.message,
            "events": trace and [event_json(self.loop.compiled.model, event) for event in trace.events],
            "loop_start": trace and trace.loop_start,
            "answers": trace and _deeds(trace),
        }

    def _is_read(self, question: Question, finding: Finding) -> bool:
        """Return whether an answer is read as it was written: a reading out of range is not, for one."""
        return self._read(question, self._written(finding)) == replace(finding, seconds=0.0)

    def _read(self, question: Question, kept: Any) -> Finding | None:
        """Return an answer with its run as the reference and the tables answer it now; None if it is not believed."""
        match kept:
            case {
                "verdict": "holds" | "violated" as verdict,
                "engine": str(engine),
                "method": str(method),
                "message": str(message),
                "events": None,
            }:
                return question.answer(verdict, message, method, None, engine)
            case {
                "verdict": "holds" | "violated" as verdict,
                "engine": str(engine),
                "method": str(method),
                "message": str(message),
                "events": [*events],
                "loop_start": None | int() as loop_start,
                "answers": str(answers),
            }:
                trace = self._run(events, loop_start)
                if trace is not None and _deeds(trace) == answers:
                    return question.answer(verdict, message, method, trace, engine)
        return None

    def _run(self, lines: Iterable[Any], loop_start: int | None) -> Trace | None:
        """Return the run of events; None if they are none, if it is no lasso, or if the tables answer otherwise."""
        events: list[Event] = []
        for line in lines:
            event = read_entries(self.loop.compiled.model, line) if isinstance(line, dict) else Invalid("bad-event")
            if isinstance(event, Invalid):
                return None
            events.append(event)
        try:
            trace = run(self._replay.reference, tuple(events), loop_start)
        except ValueError:
            return None
        return trace if self._replay.agrees(trace) else None

    @cached_property
    def _replay(self) -> TraceReplay:
        return TraceReplay(self.loop.compiled.model, self.loop.compiled.tables)


def is_sure(finding: Finding, replayed: bool) -> bool:
    """Return whether an answer is one, and shown on the emitted C if it is a run that breaks something."""
    broken = finding.verdict == "violated" and bool(finding.trace)
    return finding.verdict != "unknown" and (replayed or not broken)


def _deeds(trace: Trace) -> str:
    """Return the digest of what a run answers, texts left out."""
    answers: tuple[tuple[Action, ...], ...] = tuple(moment.actions for moment in trace.moments)
    return _digest(essence(answers))


def _digest(*parts: str) -> str:
    """Return the sha256 of texts, as hexadecimal digits."""
    found = sha256()
    for part in parts:
        content = part.encode("utf-8", "surrogatepass")
        found.update(len(content).to_bytes(8, "little") + content)
    return found.hexdigest()
