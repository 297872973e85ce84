"""NuSMV or nuXmv as an engine: its opinions of claims, and the runs that it shows."""

import re
from collections.abc import Collection, Sequence
from dataclasses import field
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.smv.names import claim_name
from exover.engines.smv.program import ProgramAnswers, ask
from exover.engines.smv.specs import is_of
from exover.engines.smv.text import Text, looped
from exover.engines.smv.traces import InvalidTrace, concrete, shown
from exover.loop.claim import (
    APPROXIMATE,
    CONTRADICTION,
    CONTRADICTORY,
    NO_FORMULA,
    UNFAIR,
    Claim,
    Opinion,
    Verdict,
    believed,
)
from exover.loop.finite.tested_bounds import TooLarge
from exover.loop.formula_classes import AtStart, ExistsUntil, Opposite, Stuck, question_of
from exover.model.property import Properties, momentary, until_of
from exover.model.trace import Disagreement, Trace
from exover.ocrd.compile import Compiled
from exover.ocrd.trace_replay import TraceReplay

METHOD = "NuSMV"
ANSWER = re.compile(r"^-- .*?  is (true|false)\s*$", re.DOTALL | re.MULTILINE)
"""The line that the program prints for a specification: its text (a `case` spans lines) and its truth value."""
SHOWING = 20.0
"""The seconds that the program may take to show runs, once it is known which specifications are false."""
SILENT = "NuSMV says nothing of it, so that it may be some other program"
ABOUT_NOTHING = f"{CONTRADICTORY}, so it is about nothing"


@dataclass
class NuSmv:
    """The engine for the claims about one closed loop; `seconds`: how long the program may take for one text.

    `enough`: passes that settle every step, if that is known; without it no other engine is relied on.
    """

    compiled: Compiled
    properties: Properties
    program: str
    seconds: float | None = None
    enough: int | None = None
    _assumed: dict[bool, Opinion | None] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The engine, as findings name it."""
        return "nusmv"

    def judge(self, claim: Claim) -> Opinion:
        """Return whether the claim is true of every run that the assumptions leave."""
        return self.judge_all((claim,))[0]

    def judge_all(self, claims: Sequence[Claim]) -> list[Opinion]:
        """Return whether claims are true, each; the program reads the loop once for all, and once for fair runs."""
        found = {n: Opinion("unknown", "", NO_FORMULA) for n, claim in enumerate(claims) if claim.formula is None}
        for fair in (False, True):
            mine = {n: c for n, c in enumerate(claims) if n not in found and is_of(c, self.properties, fair)}
            found |= dict(zip(mine, self._judged(tuple(mine.values()), fair), strict=True)) if mine else {}
        return [found[number] for number in range(len(claims))]

    def _judged(self, claims: tuple[Claim, ...], fair: bool) -> list[Opinion]:
        """Return the opinions on claims that are made in the same text."""
        failed = self._coherent(fair)
        try:
            text = Text(looped(self.compiled, self.properties, claims), claims, fair, enough=self.enough)
            said = self._asked(text) if failed is None or failed.verdict == "violated" else ProgramAnswers({})
        except TooLarge as reason:
            return [Opinion("unknown", "", str(reason))] * len(claims)
        false = [name for name, printed in said.of.items() if _verdict(printed) == "violated"]
        runs = self._asked(text, false) if false else ProgramAnswers({})
        found = []
        for claim in claims:
            if failed is None:
                found.append(self._opinion(text, claim, said, runs))
            elif failed.verdict == "violated" and not claim.coherent:
                found.append(Opinion("unknown", "", ABOUT_NOTHING))
            else:
                found.append(failed)
        return found

    def _asked(self, text: Text, names: Collection[str] | None = None) -> ProgramAnswers:
        """Return what the program says of the specifications; of those called `names` alone, with the runs it shows."""
        kinds = {each.name: each.kind for each in text.specifications if names is None or each.name in names}
        seconds = self.seconds if names is None else min(self.seconds or SHOWING, SHOWING)
        return ask(self.program, text.render(), "\n".join([*text.order, ""]), kinds, seconds, names is not None)

    def _opinion(self, text: Text, claim: Claim, said: ProgramAnswers, runs: ProgramAnswers) -> Opinion:
        name = claim_name(claim)
        verdict = _verdict(said.of.get(name, ""))
        if verdict == "unknown":
            return Opinion(verdict, "", said.stopped or SILENT)
        trace, message = self._trace(text, runs.of.get(name, ""), _is_shown_by_one_moment(claim))
        if text.loop.approximate and not believed(claim, verdict, trace is not None):
            return Opinion("unknown", "", message or APPROXIMATE)
        return Opinion(verdict, METHOD, message, trace)

    def _trace(self, text: Text, printed: str, alone: bool) -> tuple[Trace | None, str]:
        """Return the run that was shown, and what is to be said of it. Raises `Disagreement` if it is none.

        `alone`: a run of no step shows it, if the start is as it must not be.
        """
        what = shown(text.names, printed)
        if what is None or not what.steps:
            return Trace(()) if what is not None and alone else None, ""
        try:
            trace = concrete(text.names, self._replay.reference, what)
        except InvalidTrace as reason:
            if text.loop.approximate:
                return None, f"no concrete run was found that goes as NuSMV shows: {reason}"
            raise Disagreement(str(reason)) from reason
        self._replay.confirm(trace)
        return trace, ""

    @cached_property
    def _replay(self) -> TraceReplay:
        return TraceReplay(self.compiled.model, self.compiled.tables)

    # ---- assumptions ----

    def _coherent(self, fair: bool) -> Opinion | None:
        """Return None iff the assumptions leave each state a step and, if `fair`, a fair run; else the opinion."""
        if not self.properties.assumptions:
            return None
        if fair and self._coherent(False) is not None:
            return self._coherent(False)
        if fair not in self._assumed:
            try:
                text = Text(looped(self.compiled, self.properties, ()), (), fair, enough=self.enough)
                said = self._asked(text)
            except TooLarge as reason:
                return Opinion("unknown", "", str(reason))
            (spec,) = text.specifications
            wanted: Verdict = "violated" if spec.opposite else "holds"
            verdict = _verdict(said.of.get(spec.name, ""))
            if verdict == "unknown":
                self._assumed[fair] = Opinion(verdict, "", said.stopped or SILENT)
            else:
                self._assumed[fair] = None if verdict == wanted else self._contradiction(text, spec.name)
        return self._assumed[fair]

    def _contradiction(self, text: Text, name: str) -> Opinion:
        """Return the opinion that the assumptions contradict each other, with the run to where they do."""
        if text.fair:
            return Opinion("violated", METHOD, UNFAIR, Trace(()))
        trace, message = self._trace(text, self._asked(text, [name]).of.get(name, ""), alone=True)
        if trace is None and text.loop.approximate:
            return Opinion("unknown", "", message or APPROXIMATE)
        return Opinion("violated", METHOD, CONTRADICTORY if trace is None else CONTRADICTION, trace)


def _verdict(printed: str) -> Verdict:
    """Return what the program printed of one specification; unknown if it is not whole."""
    if "<counter-example" in printed and "</counter-example>" not in printed:
        return "unknown"
    found = ANSWER.search(printed)
    if found is None:
        return "unknown"
    return "holds" if found[1] == "true" else "violated"


def _is_shown_by_one_moment(claim: Claim) -> bool:
    """Return whether one moment shows that a claim is false: it is as none may be, or has no way to the goal."""
    if claim.formula is None or claim.linear:
        return False
    if (until := until_of(claim.formula)) is not None:
        return all(map(momentary, until))
    match question_of(claim.formula):
        case AtStart() | Opposite(AtStart() | ExistsUntil(strict=False) | Stuck()):
            return True
        case _:
            return False
