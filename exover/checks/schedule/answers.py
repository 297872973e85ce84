"""The cache of answers, and when an answer in it may be used again (docs/checks.md, "The cache").

The key of an answer is made of what it depends on: the loop (the model and its tables, without texts and locations, and
the engines), the assumptions, and the question. Of a trace only the events are kept, and they are replayed when read.
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
from exover.digest import digest_of
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
"""Checks that look at no step, so that their answers do not depend on assumptions."""
VACUITY = "vacuity"
OF_PROPERTIES = ("property", VACUITY)
"""Checks whose subjects are properties; those of all others are things of the model."""


class AnswerStore(Protocol):
    """A store of answers, by the digests of a loop and of a question; its contents are not trusted."""

    def find(self, loop: str) -> Mapping[str, Any]:
        """Return the answers about a loop, by question."""
        ...

    def keep(self, loop: str, answers: Mapping[str, Json]) -> None:
        """Store answers about a loop, by question; do nothing if they cannot be stored."""
        ...


class NoStore:
    """A store that is always empty."""

    def find(self, loop: str) -> Mapping[str, Any]:
        """Return nothing."""
        return {}

    def keep(self, loop: str, answers: Mapping[str, Json]) -> None:
        """Do nothing."""


NO_STORE = NoStore()


@dataclass(frozen=True, slots=True)
class LoopFigures:
    """The engines in the order in which they are asked about a loop, and the number of bits of its state."""

    names: tuple[EngineName, ...]
    state_bits: int | None


@dataclass(frozen=True)
class StoredLoop:
    """The part of a store that is about one loop and one set of engines, whatever their order."""

    compiled: Compiled
    properties: Properties
    engines: Engines
    store: AnswerStore

    def find(self) -> Mapping[str, Any]:
        """Return the stored answers, by question."""
        return self.store.find(self._key)

    def keep(self, answers: Mapping[str, Json]) -> None:
        """Store answers, by question, unless all of them are stored already."""
        if answers.keys() - self.find().keys():
            self.store.keep(self._key, answers)

    def figures(self) -> LoopFigures | None:
        """Return the figures if they are stored, else None."""
        match self.find().get(self.of_figures):
            case {"names": [*names], "state_bits": None | int() as bits} if sorted(names) == sorted(self.engines.names):
                return LoopFigures(tuple(names), bits)
        return None

    @cached_property
    def _key(self) -> str:
        """The digest of the loop: of the model without its texts, the bytes of the tables without their digest and
        flags, and the sorted engines."""
        plain = pack(replace(self.compiled.tables, digest=bytes(32), flags=0))
        engines = replace(self.engines, names=tuple(sorted(self.engines.names)))
        return digest_of(essence(self.compiled.model), sha256(plain).hexdigest(), essence(engines))

    @property
    def of_figures(self) -> str:
        """The digest under which the figures are stored: they depend on all formulas and assumptions."""
        return digest_of("figures", essence(tuple(formulas(self.properties))), self.assumed)

    @cached_property
    def assumed(self) -> str:
        """The assumptions, and whether reports are fair, as a text without locations."""
        return essence((tuple(each.formula for each in self.properties.assumptions), int(self.properties.fair)))


@dataclass
class KnownAnswers:
    """The stored answers to questions about one loop that are put to the engines of these `names` in their order."""

    loop: StoredLoop
    names: tuple[EngineName, ...]
    recalled: dict[str, Finding] = field(default_factory=dict)
    """The answers, by question, that were read from the store and confirmed."""

    def answered(self, asked: Iterable[Asked]) -> dict[int, Finding]:
        """Return the findings that are stored and confirmed, by the index of the question."""
        kept = self.loop.find()
        found: dict[int, Finding] = {}
        for number, (check, question) in enumerate(asked if kept else ()):
            key = self._key(check, question)
            finding = self._read(question, kept.get(key))
            if finding is not None:
                found[number] = self.recalled[key] = finding
        return found

    def keep(self, asked: Iterable[Asked], findings: Iterable[Finding], bits: int | None, replayed: bool) -> None:
        """Store the findings that are sure and are read back as they are written; write nothing if none of it is new.

        `replayed`: violations were replayed on the emitted C as well; otherwise they are not stored. `bits`: the number
        of bits of a state; None if it is not known, perhaps for lack of time.
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
        """Return the digest of a question: the check, the subject, the engines in order, the formula of a property, and
        the assumptions."""
        said, properties = "", self.loop.properties
        if check.name in OF_PROPERTIES and any(each.name == question.subject for each in properties.properties):
            prop = named(properties, question.subject)
            said = essence(prop.premise if check.name == VACUITY else (prop.form, prop.formula, prop.premise))
        assumed = "" if check.name in OF_BYTES else self.loop.assumed
        return digest_of(check.name, question.subject, *self.names, said, assumed)

    # ---- stored answers ----

    def _written(self, finding: Finding) -> Json:
        """Return a finding as JSON without locations and texts of the spec; of a trace the events and a digest."""
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
        """Return whether a finding is read back as it is written; with a reading out of range it is not, for one."""
        return self._read(question, self._written(finding)) == replace(finding, seconds=0.0)

    def _read(self, question: Question, kept: Any) -> Finding | None:
        """Return a stored finding with its trace replayed on the reference interpreter and the tables.

        None if it has another shape, or if the replay gives other answers than those stored.
        """
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
        """Return the trace of stored events; None if one is no event, the loop does not close, or the tables differ."""
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
    """Return whether the verdict is not `unknown` and, if it is a violation with a trace, that was `replayed`."""
    broken = finding.verdict == "violated" and bool(finding.trace)
    return finding.verdict != "unknown" and (replayed or not broken)


def _deeds(trace: Trace) -> str:
    """Return the digest of the actions of a trace, texts left out."""
    answers: tuple[tuple[Action, ...], ...] = tuple(moment.actions for moment in trace.moments)
    return digest_of(essence(answers))
