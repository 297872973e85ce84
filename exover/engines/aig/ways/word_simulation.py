"""Which words lead to which goals, from many states: parallel simulation of every word from every state."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit
from exover.engines.aig.simulation.evaluation import Evaluator
from exover.engines.aig.simulation.exploration import Seed, state_of
from exover.engines.aig.simulation.lanes import LaneState, LaneWord, lowest

WIDEST = 1 << 16
"""How many lanes are run at once, at most."""


@dataclass
class WordSimulation:
    """States, and which words lead from them to the goals of questions: the bad literals of the circuit.

    `cone` evaluates them and the latches.
    """

    circuit: Circuit
    cone: Evaluator
    samples: list[Seed] = field(default_factory=list)
    needed: dict[int, LaneWord] = field(default_factory=dict)
    """By question the samples, a bit for each, from which it needs a way."""
    leading: dict[Inputs, dict[int, LaneWord]] = field(default_factory=dict)
    """By word, by question, the samples from which the word leads to its goal."""

    def add(self, samples: Sequence[Seed], needed: Mapping[int, LaneWord]) -> None:
        """Take more states; `needed`: by question from which of them it needs a way."""
        first = len(self.samples)
        self.samples += samples
        for question, where in needed.items():
            self.needed[question] = self.needed.get(question, 0) | where << first
        self._run(list(self.leading), range(first, len(self.samples)))

    def learn(self, words: Iterable[Inputs]) -> None:
        """Take more words."""
        fresh = [word for word in dict.fromkeys(words) if word not in self.leading]
        self._run(fresh, range(len(self.samples)))

    def drop(self, question: int) -> None:
        """Forget a question."""
        self.needed.pop(question, None)

    def unhelped(self) -> dict[int, LaneWord]:
        """Return by question the samples from which it needs a way and none is known."""
        return {question: self._left(question, where) for question, where in self.needed.items()}

    def helps(self, question: int) -> bool:
        """Return whether some word leads to the goal of a question from every sample from which it needs a way."""
        return not self._left(question, self.needed[question])

    def _left(self, question: int, where: LaneWord) -> LaneWord:
        for found in self.leading.values():
            where &= ~found.get(question, 0)
        return where

    def chosen(self, question: int) -> list[Inputs]:
        """Return words for a question: one of them leads to its goal from each sample from which any does.

        The word that does so from most comes first (the greedy cover of a set, Johnson 1974).
        """
        left, found = self.needed[question], list[Inputs]()
        leading = {word: where[question] for word, where in self.leading.items() if question in where}
        while leading:
            best = max(leading, key=lambda word: ((leading[word] & left).bit_count(), -len(word)))
            if not leading[best] & left:
                break
            left &= ~leading.pop(best)
            found.append(best)
        return found

    def composed(self, sample: Seed, questions: Sequence[int]) -> dict[int, Inputs]:
        """Return, by place of a question, two known words in sequence that lead from a sample to its goal, if any."""
        known = sorted(self.leading, key=len)
        last = [word for word in known if self.leading[word].keys() & set(questions)]
        pairs = [(*one, *other) for one in known for other in last][:WIDEST]
        found = self._led(pairs, [sample]) if pairs else {}
        return {place: pairs[lowest(found[k])] for place, k in enumerate(questions) if found.get(k)}

    def _run(self, words: Sequence[Inputs], numbers: Sequence[int]) -> None:
        """Run words from samples, as many as fit side by side at once."""
        for word in words:
            self.leading.setdefault(word, {})
        size = max(1, WIDEST // max(1, len(words)))
        for first in range(0, len(numbers), size) if words else ():
            block = numbers[first : first + size]
            everywhere = (1 << len(block)) - 1
            for question, lanes in self._led(words, [self.samples[number] for number in block]).items():
                for place, word in enumerate(words):
                    here = lanes >> len(block) * place & everywhere
                    if here:
                        known = self.leading[word]
                        known[question] = known.get(question, 0) | here << block[0]

    def _led(self, words: Sequence[Inputs], samples: Sequence[Seed]) -> dict[int, LaneWord]:
        """Return by question in which lanes its goal is reached: for each word the samples, one after the other."""
        block = (1 << len(samples)) - 1
        turns = sum(1 << len(samples) * place for place in range(len(words)))
        state: LaneState = {node: word * turns for node, word in state_of(self.circuit.latches, samples).items()}
        found = dict.fromkeys(self.needed, 0)
        for step in range(max(map(len, words))):
            true: dict[int, LaneWord] = {}
            running = 0
            for place, word in enumerate(words):
                if step < len(word):
                    running |= block << len(samples) * place
                    for node in word[step]:
                        true[node] = true.get(node, 0) | block << len(samples) * place
            values = self.cone.values(state, true)
            for question in found:
                found[question] |= self.cone.read(values, self.circuit.bad[question], block * turns) & running
            state = self.cone.after(values, block * turns)
        return found
