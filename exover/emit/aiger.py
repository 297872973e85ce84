"""The closed loop and what the checks ask of it as AIGER, for model checkers of hardware (docs/engines.md)."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from exover.emit.artefact import Artefact
from exover.engines.aig.aiger import Document, Names, binary
from exover.engines.aig.encoder import Encoding
from exover.engines.aig.graph import Literal
from exover.engines.aig.questions import Denied, Either, Known, Question, Questions, Reach
from exover.loop.claim import Claim
from exover.model.property import Properties
from exover.ocrd.compile import Compiled

UNSETTLED = "unsettled"
"""The bad state on which all others rest."""
NOT_ASKED = "not asked: it is about endless runs, or what stays possible, or compares two things"
HEAD = (
    "The closed loop of {name}: a step is an event with all its settling; inputs that are no event change nothing.",
    f"{UNSETTLED}: if it can be reached, an event needs more passes than the circuit has, and no other answer counts.",
    "By finding, what it holds iff; a bad state of the same name is what is asked:",
)


@dataclass
class Asked:
    """The bad states, by name, and what is to be said of findings."""

    bad: dict[str, Literal] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)

    def ask(self, claim: Claim, question: Question | None) -> None:
        """Add the bad states of a claim, and the line that says what their answers mean."""
        name = f"{claim.check}.{claim.subject}".replace(" ", "-")
        reaches = [] if question is None else list(_reaches(question))
        if question is None or not _asks_only_reaches(question):
            self.lines.append(f"{name}: {NOT_ASKED}")
            return
        names = {reach: name if len(reaches) == 1 else f"{name}.{n}" for n, reach in enumerate(reaches, 1)}
        self.bad |= {each: reach.bad for reach, each in names.items()}
        words = names if len(names) > 1 else dict.fromkeys(names, "it")
        self.lines.append(f"{name}: {_said(question, words)}")


def emit(compiled: Compiled, properties: Properties, claims: Sequence[Claim], name: str) -> tuple[Artefact, ...]:
    """Return `name.aig`, in the binary form: a bad state for each finding that is about reaching one moment."""
    encoding = Encoding(compiled, properties)
    questions = Questions(encoding)
    asked = Asked({UNSETTLED: encoding.unsettled})
    for claim in claims:
        formula = None if claim.linear else claim.formula
        asked.ask(claim, None if formula is None else questions.of(formula, claim.fair))
    circuit = encoding.circuit(list(asked.bad.values()))
    names = Names(_inputs(encoding), _latches(encoding), tuple(asked.bad))
    head = [line.format(name=name) for line in HEAD]
    document = Document(circuit, names=names, comment=(*head, *asked.lines))
    return (Artefact(f"{name}.aig", binary(document)),)


def _asks_only_reaches(question: Question) -> bool:
    match question:
        case Reach() | Known():
            return True
        case Denied(part):
            return _asks_only_reaches(part)
        case Either(parts):
            return all(map(_asks_only_reaches, parts))
        case _:
            return False


def _reaches(question: Question) -> "dict[Reach, None]":
    """Return the moments that a question is about, each once, in order."""
    match question:
        case Reach():
            return {question: None}
        case Denied(part):
            return _reaches(part)
        case Either(parts):
            return {reach: None for part in parts for reach in _reaches(part)}
        case _:
            return {}


def _said(question: Question, names: dict[Reach, str]) -> str:
    """Return a question in words."""
    match question:
        case Reach():
            return f"{names[question]} can be reached"
        case Denied(Reach() as part):
            return f"{names[part]} cannot be reached"
        case Known(truth):
            return "true" if truth else "false"
        case Denied(part):
            return f"not ({_said(part, names)})"
        case Either(parts):
            return " or ".join(f"({_said(part, names)})" for part in parts) or "false"
        case _:
            raise TypeError("a question about something else than what can be reached")


def _inputs(encoding: Encoding) -> tuple[str, ...]:
    """Return the names of the inputs: the bits of the event's number, those of what comes with it, and of grids."""
    names = {node: f"event[{place}]" for place, node in enumerate(encoding.code)}
    names |= {node: f"place[{place}]" for place, node in enumerate(encoding.shifts)}
    return tuple(names.get(node, f"given[{node}]") for node in encoding.graph.inputs)


def _latches(encoding: Encoding) -> tuple[str, ...]:
    """Return the names of the latches: of a variable of several bits each with its place, the lowest first."""
    names: dict[int, str] = {}
    for variable, bits in encoding.latches.literals.items():
        for place, bit in enumerate(bits):
            names[bit >> 1] = variable if len(bits) == 1 else f"{variable}[{place}]"
    return tuple(names.get(node, f"memory {node}").replace(" ", "-") for node, _ in encoding.graph.latches)
