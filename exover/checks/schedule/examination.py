"""The closed loop that is asked about, as far as an answer has needed it, and the runs that answers show."""

from dataclasses import replace
from functools import cached_property

from exover.checks.finding import Counted, Finding
from exover.checks.lasso_shortening import guesses, shortened
from exover.checks.questions.question import Check, Context
from exover.dataclass import dataclass
from exover.engines.bdd.analysis import Analysis
from exover.loop.claim import Claim, Progress
from exover.loop.finite.tested_bounds import TooLarge
from exover.loop.plain_runs import PlainRuns
from exover.model.property import Properties
from exover.ocrd.compile import Compiled
from exover.ocrd.trace_replay import TraceReplay


@dataclass
class Examination:
    """The closed loop of a compiled model; what one answer has cost, the next need not pay."""

    compiled: Compiled
    properties: Properties
    _context: Context | None = None

    def context(self, progress: Progress) -> Context:
        """Return the loop as diagrams see it."""
        if self._context is None:
            analysis = Analysis(self.compiled, self._replay.reference, progress, self.properties)
            self._context = Context(self.compiled, analysis)
        return self._context

    def claim(self, check: Check, subject: str) -> Claim:
        """Return what a check says of a subject."""
        return check.claim(self.compiled.model, self.properties, subject)

    def confirmed(self, check: Check, finding: Finding) -> Finding:
        """Return a finding, its trace of plain numbers and confirmed on the tables."""
        trace, reference = finding.trace, self._replay.reference
        if trace:
            trace = self._plain.of(trace, reference)
            if trace.loop_start is not None:
                claim = self.claim(check, finding.subject)
                if finding.engine != "aig" or guesses(claim):  # else its own are as short
                    trace = shortened(trace, reference, claim, self.properties)
            self._replay.confirm(trace)
        return replace(finding, trace=trace)

    def state_bits(self, progress: Progress) -> int | None:
        """Return the number of bits of the state; None if it is more than can be followed."""
        return self.context(progress).analysis.state_bits

    def counted(self, progress: Progress) -> Counted:
        """Return the number of reachable states."""
        from exover.engines.bdd.count import count_states

        progress("number of states")
        try:
            return Counted(count_states(self.context(progress).analysis.stepper))
        except TooLarge as reason:
            return Counted(None, str(reason))

    @cached_property
    def _replay(self) -> TraceReplay:
        return TraceReplay(self.compiled.model, self.compiled.tables)

    @cached_property
    def _plain(self) -> PlainRuns:
        return PlainRuns(self.compiled.model, self.properties)
