"""The closed loop that is asked about, made as far as an answer needs it, and the confirmation of traces."""

from dataclasses import replace
from functools import cached_property

from exover.checks.finding import Counted, Finding
from exover.checks.lasso_shortening import at_rest, guesses, shortened
from exover.checks.questions.question import Check, Context
from exover.dataclass import dataclass
from exover.engines.bdd.analysis import Analysis
from exover.loop.claim import CONTRADICTORY, Claim, Progress
from exover.loop.finite.tested_bounds import TooLarge
from exover.loop.plain_runs import PlainRuns
from exover.model.property import Properties
from exover.model.types import Real
from exover.ocrd.compile import Compiled
from exover.ocrd.trace_replay import TraceReplay


@dataclass
class Examination:
    """The closed loop of a compiled model; what is computed for one answer is kept for the next."""

    compiled: Compiled
    properties: Properties
    _context: Context | None = None

    @cached_property
    def reads_reals(self) -> bool:
        """Whether a variable is real: where none is, the loop of the diagrams has no run too many."""
        return any(isinstance(variable.type, Real) for variable in self.compiled.model.variables)

    def context(self, progress: Progress) -> Context:
        """Return the loop as decision diagrams."""
        if self._context is None:
            analysis = Analysis(self.compiled, self._replay.reference, progress, self.properties)
            self._context = Context(self.compiled, analysis)
        return self._context

    def claim(self, check: Check, subject: str) -> Claim:
        """Return the claim of a check about a subject."""
        return check.claim(self.compiled.model, self.properties, subject)

    def confirmed(self, check: Check, finding: Finding) -> Finding:
        """Return the finding with its trace made of plain numbers, a lasso shortened, and confirmed on the tables.

        What is said of endless runs is shown by one, also where an engine had time for its beginning alone.
        """
        trace, reference = finding.trace, self._replay.reference
        if trace:
            trace = self._plain.of(trace, reference)
            claim = self.claim(check, finding.subject)
            if trace.loop_start is not None:
                if finding.engine != "aig" or guesses(claim):  # otherwise `aig` has shortened it already
                    trace = shortened(trace, reference, claim, self.properties)
            elif claim.linear and finding.verdict == "violated" and CONTRADICTORY not in finding.message:
                trace = at_rest(trace, reference, claim, self.properties)
            self._replay.confirm(trace)
        return replace(finding, trace=trace)

    def state_bits(self, progress: Progress) -> int | None:
        """Return the number of bits of a state; None if diagrams cannot follow the loop."""
        return self.context(progress).analysis.state_bits

    def counted(self, progress: Progress) -> Counted:
        """Return the number of reachable states, or why it is not known."""
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
