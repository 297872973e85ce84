"""The engine: all claims about one closed loop at once, as questions to one graph, with as many passes as it needs.

Redundancy is asked of a graph of its own, in which each decision is also made without each of the rules.
"""

from collections.abc import Callable, Sequence

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import Circuit
from exover.engines.aig.circuit.kernel import compiled_beside
from exover.engines.aig.encoding.encoder import PASSES, Encoding
from exover.engines.aig.evidence import unproved
from exover.engines.aig.inquiry import Inquiry
from exover.engines.aig.portfolio import smaller
from exover.engines.aig.redundancy import Contrasts
from exover.engines.beside import Beside
from exover.loop.claim import NO_FORMULA, Claim, Opinion, SayOpinion
from exover.model.property import Properties
from exover.ocrd.compile import Compiled

BUDGET = 100_000_000
"""Propagations of the solver that a question may cost."""
UNSETTLED = f"a step may take more than {PASSES[-1]} passes"

NumberedOpinion = tuple[int, Opinion]
"""The index of a claim, and the opinion on it."""


@dataclass
class Aig:
    """Answers claims about one closed loop.

    `abc`: the program of Berkeley ABC, if it is to help; `spare`: whether there is a processor for a second process.
    """

    compiled: Compiled
    properties: Properties
    abc: str = ""
    budget: int = BUDGET
    spare: bool = False
    name: str = "aig"

    def judge_all(self, claims: Sequence[Claim], say: SayOpinion) -> None:
        """Say the opinion on each claim, by its index, as soon as it is known."""
        left = list(range(len(claims)))
        said: set[int] = set()

        def heard(number: int, opinion: Opinion) -> None:
            said.add(left[number])
            say(left[number], opinion)

        for number, claim in enumerate(claims):
            if _is_wordless(claim):  # at once: other engines are asked about it
                heard(number, Opinion("unknown", "", NO_FORMULA))
        known: Inquiry | None = None
        for passes in PASSES:
            left = [number for number in range(len(claims)) if number not in said]
            if not left:
                return
            known = self._look_into([claims[number] for number in left], heard, passes, known)
        for number in range(len(claims)):
            if number not in said:
                say(number, Opinion("unknown", "", UNSETTLED))

    def _look_into(self, claims: Sequence[Claim], say: SayOpinion, passes: int, before: Inquiry | None) -> Inquiry:
        """Judge claims on the graph with `passes` passes; if a run seems to need more, leave the rest unsaid.

        Return what is known then. `before`: the inquiry with fewer passes; from its runs those are looked for that need
        more still. Whether the passes are enough is asked first, while the graph is made smaller: no other proof is of
        use for a larger graph.
        """
        compared = [number for number, claim in enumerate(claims) if claim.check == "redundancy"]
        others = [number for number, claim in enumerate(claims) if claim.check != "redundancy"]
        with compiled_beside():
            known = self._inquiry(self._encoding(passes), others, claims, say)
        if not known.explore(before):
            return known

        def told(each: NumberedOpinion) -> None:
            say(each[0], each[1] if known.evidence.settled else unproved(each[1]))

        encoding = self._encoding(passes)
        with Beside[Circuit](lambda tell: tell(smaller(encoding, encoding.whole())), self.spare) as reduction:
            known.wander()
            if not known.settle(insist=passes > PASSES[0]):
                return known
            apart = self.spare and bool(compared)
            with Beside[NumberedOpinion](lambda tell: self._compare(known, compared, claims, tell), apart) as changes:
                reduction.hear(encoding.rewrite)
                left = [others[place] for place in known.left]
                rest = self._inquiry(encoding, left, claims, say)
                rest.follow(known)
                changes.overhear(told)
                rest.prove()
                rest.finish(self.spare, [(changes, told)])
                changes.hear(told)
        return known

    def _compare(
        self, known: Inquiry, numbers: Sequence[int], claims: Sequence[Claim], tell: Callable[[NumberedOpinion], None]
    ) -> None:
        """Tell opinions on redundancy that presume enough passes; they are found on a graph that is twice as large."""
        if numbers:
            passes = known.encoding.passes
            encoding = Encoding(self.compiled, self.properties, passes, Contrasts(self.compiled))
            inquiry = self._inquiry(encoding, numbers, claims, lambda number, opinion: tell((number, opinion)))
            inquiry.evidence.settled = True
            if inquiry.explore(known, cover=False):
                inquiry.prove(unroll=False)
                inquiry.finish()

    def _encoding(self, passes: int) -> Encoding:
        return Encoding(self.compiled, self.properties, passes)

    def _inquiry(self, encoding: Encoding, numbers: Sequence[int], claims: Sequence[Claim], say: SayOpinion) -> Inquiry:
        mine = [claims[number] for number in numbers]
        return Inquiry(encoding, mine, lambda place, opinion: say(numbers[place], opinion), self.abc, self.budget)


def _is_wordless(claim: Claim) -> bool:
    """Return whether a claim has no formula, and is not about redundancy, which needs none."""
    return claim.formula is None and claim.check != "redundancy"
