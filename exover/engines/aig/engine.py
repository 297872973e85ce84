"""The engine: all claims about one closed loop at once, as questions to one graph, with as many passes as it needs.

What a rule changes is asked of a graph of its own, in which the rules decide beside those that are left without it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from exover.engines.aig import abc
from exover.engines.aig.encoder import Encoding
from exover.engines.aig.exploration import LANES, Exploration, watched
from exover.engines.aig.inquiry import Inquiry, Said
from exover.engines.aig.miter import confirmed
from exover.engines.aig.portfolio import SHORT
from exover.engines.aig.redundancy import Contrasts
from exover.engines.aig.stimulus import RandomStimulus
from exover.loop.claim import NO_FORMULA, Claim, Opinion
from exover.model.property import Properties
from exover.ocrd.compile import Compiled

PASSES = range(2, 13)
"""Numbers of passes that are tried, until one is enough."""
BUDGET = 20_000_000
"""Propagations of the solver that a question may cost."""
FEW = 4
"""Rounds of random runs in which it is seen, as a rule, that a graph has not passes enough."""
UNSETTLED = f"a step may take more than {PASSES[-1]} passes"


@dataclass
class Aig:
    """Answers claims about one closed loop; `abc`: the program of Berkeley ABC, if it is to help."""

    compiled: Compiled
    properties: Properties
    abc: str = ""
    budget: int = BUDGET
    name: str = "aig"

    def judge_all(self, claims: Sequence[Claim], say: Said) -> None:
        """Say of each claim, by its index and as soon as it is known, whether it is true of every run."""
        left = list(range(len(claims)))
        said: set[int] = set()

        def heard(number: int, opinion: Opinion) -> None:
            said.add(left[number])
            say(left[number], opinion)

        for number, claim in enumerate(claims):
            if _is_wordless(claim):  # at once, for others are asked what we leave open
                heard(number, Opinion("unknown", "", NO_FORMULA))
        for passes in PASSES:
            left = [number for number in range(len(claims)) if number not in said]
            if not left or self._settles([claims[number] for number in left], heard, passes):
                return
        for number in range(len(claims)):
            if number not in said:
                say(number, Opinion("unknown", "", UNSETTLED))

    def _settles(self, claims: Sequence[Claim], say: Said, passes: int) -> bool:
        """Look into claims with so many passes, and return whether no run is known to need more.

        What a rule changes is asked of a graph of its own, which is twice as large.
        """
        encoding = Encoding(self.compiled, self.properties, passes)
        if exceeds(encoding):
            return False
        if self.abc:
            encoding.rewrite(lambda circuit: confirmed(circuit, abc.smaller(circuit, SHORT, self.abc)))
        others = [number for number, claim in enumerate(claims) if claim.check != "redundancy"]
        first = self._inquiry(encoding, others, claims, say)
        if not first.explore() or not first.prove():
            return False
        compared = [number for number, claim in enumerate(claims) if claim.check == "redundancy"]
        if compared:
            beside = Encoding(self.compiled, self.properties, passes, Contrasts(self.compiled))
            second = self._inquiry(beside, compared, claims, say)
            second.settled = first.settled
            if self.abc:
                second.simulated = abc.smaller(second.circuit, SHORT, self.abc)
            if not second.explore(first) or not second.prove():
                return False
            second.finish()
        first.finish()
        return True

    def _inquiry(self, encoding: Encoding, numbers: Sequence[int], claims: Sequence[Claim], say: Said) -> Inquiry:
        mine = [claims[number] for number in numbers]
        return Inquiry(encoding, mine, lambda place, opinion: say(numbers[place], opinion), self.abc, self.budget)


def exceeds(encoding: Encoding) -> bool:
    """Return whether a few random runs come to where the graph needs more passes."""
    stimulus = RandomStimulus(encoding, LANES).stimulus()
    return bool(Exploration(encoding.circuit([encoding.unsettled]), [0], stimulus, watched(encoding)).run(FEW))


def _is_wordless(claim: Claim) -> bool:
    """Return whether no question about runs says what is claimed; what a rule changes is asked without a formula."""
    return claim.formula is None and claim.check != "redundancy"
