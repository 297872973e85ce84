"""The closed loop and what the checks ask of it as AIGER, for model checkers of hardware (docs/engines.md)."""

from collections.abc import Mapping, Sequence
from dataclasses import field

from exover.dataclass import dataclass
from exover.emit.artefact import Artefact
from exover.engines.aig.circuit.aiger import Document, Names, binary
from exover.engines.aig.circuit.graph import Literal
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.questions import (
    Beyond,
    CutOff,
    Either,
    KnownAtStart,
    LassoQuestion,
    OppositeQuestion,
    Questions,
    Reach,
    RunQuestion,
    questions_in,
)
from exover.engines.aig.liveness.k_liveness import justice
from exover.engines.aig.liveness.tableau import staying
from exover.loop.claim import Claim
from exover.model.property import Properties
from exover.ocrd.compile import Compiled

UNSETTLED = "unsettled"
"""The name of the bad state that must be unreachable for any other answer to count."""
NOT_ASKED = "not asked: it is about what stays possible, or compares two things"
HEAD = (
    "The closed loop of {name}: a step is an event with all its settling; inputs that are no event change nothing.",
    f"{UNSETTLED}: if it can be reached, an event needs more passes than the circuit has, and no other answer counts.",
    "By finding, what it holds iff; what is asked bears the same name: a bad state of {name}.aig, or a justice",
    "property of {name}.live.aig, which a run satisfies that makes each of its literals true again and again:",
)
Asked = Reach | LassoQuestion


@dataclass
class Asking:
    """The questions to be written: bad states and infinite runs by name, and for each finding a line of comment."""

    bad: dict[str, Literal]
    endless: dict[str, LassoQuestion] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)

    def ask(self, claim: Claim, question: RunQuestion) -> None:
        """Add the questions of a claim, and the line that says how their answers decide it."""
        name = f"{claim.check}.{claim.subject}".replace(" ", "-")
        if _is_beyond(question):
            self.lines.append(f"{name}: {NOT_ASKED}")
            return
        asked = [leaf for leaf in dict.fromkeys(questions_in(question)) if isinstance(leaf, Asked)]
        names = {leaf: name if len(asked) == 1 else f"{name}.{n}" for n, leaf in enumerate(asked, 1)}
        for leaf, each in names.items():
            if isinstance(leaf, Reach):
                self.bad[each] = leaf.bad
            else:
                self.endless[each] = leaf
        words = names if len(names) > 1 else dict.fromkeys(names, "it")
        self.lines.append(f"{name}: {_said(question, words)}")


def emit(compiled: Compiled, properties: Properties, claims: Sequence[Claim]) -> tuple[Artefact, ...]:
    """Return `NAME.aig` with a bad state for each finding about reachable moments, and, if any is about infinite runs,
    `NAME.live.aig` with a justice property for each of those; both in the binary form.

    They are two files, since many programs, ABC among them, read no file with justice properties.
    """
    name, encoding = compiled.model.name, Encoding(compiled, properties)
    questions, asking = Questions(encoding), Asking({UNSETTLED: encoding.unsettled})
    for claim in claims:
        asking.ask(claim, questions.of_claim(claim))
    comment = (*(line.format(name=name) for line in HEAD), *asking.lines)

    def written(bad: Mapping[str, Literal], justice: Mapping[str, tuple[Literal, ...]]) -> bytes:
        names = Names(_inputs(encoding), _latches(encoding), tuple(bad), tuple(justice))
        return binary(Document(encoding.circuit(list(bad.values())), tuple(justice.values()), (), names, comment))

    found = [Artefact(f"{name}.aig", written(asking.bad, {}))]
    if asking.endless:
        endless = {
            each: justice(encoding, staying(encoding, question.path, question.fair))
            for each, question in asking.endless.items()
        }
        found.append(Artefact(f"{name}.live.aig", written({}, endless)))
    return tuple(found)


def _is_beyond(question: RunQuestion) -> bool:
    """Return whether some part of a question is not about single runs."""
    match question:
        case OppositeQuestion(part):
            return _is_beyond(part)
        case Either(parts):
            return any(map(_is_beyond, parts))
        case _:
            return isinstance(question, Beyond | CutOff)


def _said(question: RunQuestion, names: Mapping[Asked, str]) -> str:
    """Return a question in words."""
    match question:
        case Reach():
            return f"{names[question]} can be reached"
        case OppositeQuestion(Reach() as part):
            return f"{names[part]} cannot be reached"
        case LassoQuestion():
            return f"some run satisfies {names[question]}"
        case OppositeQuestion(LassoQuestion() as part):
            return f"no run satisfies {names[part]}"
        case KnownAtStart(truth):
            return "true" if truth else "false"
        case OppositeQuestion(part):
            return f"not ({_said(part, names)})"
        case Either(parts):
            return " or ".join(f"({_said(part, names)})" for part in parts) or "false"
        case _:
            raise TypeError("a question that is not about single runs")


def _inputs(encoding: Encoding) -> tuple[str, ...]:
    """Return the names of the inputs: bits of the event's number, of places on grids, of the values of the event, and
    of what is guessed of infinite runs."""
    names = {node: f"event[{place}]" for place, node in enumerate(encoding.code)}
    names |= {node: f"place[{place}]" for place, node in enumerate(encoding.shifts)}
    names |= {node: f"given[{node}]" for node in encoding.given if node not in names}
    return tuple(names.get(node, f"guess[{node}]") for node in encoding.graph.inputs)


def _latches(encoding: Encoding) -> tuple[str, ...]:
    """Return the names of the latches: NAME of a variable of one bit, else NAME[K] for its bit K, the lowest first."""
    names: dict[int, str] = {}
    for variable, bits in encoding.latches.literals.items():
        for place, bit in enumerate(bits):
            names[bit >> 1] = variable if len(bits) == 1 else f"{variable}[{place}]"
    return tuple(names.get(node, f"memory {node}").replace(" ", "-") for node, _ in encoding.graph.latches)
