"""The names of the text: legal, each once, and the same for the same spec.

Names of a spec are letters, digits and underscores; ours have a `$`, or a `#` for the dot of a full name, so that
the two never meet. A name that means something else to NuSMV gets a `$` at its end, a value of an enum always a `#`.
"""

import re
from collections.abc import Iterable
from functools import cached_property
from itertools import pairwise

from exover.engines.smv.expression import BOOLEANS, SmvSymbol
from exover.loop.claim import Claim
from exover.loop.finite.builder import ClosedLoop
from exover.model.event import Abort, AbortWaiting, Ask, Event, Observe, Report
from exover.model.index import ModelIndex
from exover.model.types import Bool, Enum, Int
from exover.ocrd.vector import LEFT, OUTCOMES, RIGHT

WORDS = frozenset(
    """
    MODULE DEFINE MDEFINE CONSTANTS VAR IVAR FROZENVAR INIT TRANS INVAR SPEC CTLSPEC LTLSPEC PSLSPEC COMPUTE
    NAME INVARSPEC FAIRNESS JUSTICE COMPASSION ISA ASSIGN CONSTRAINT SIMPWFF CTLWFF LTLWFF PSLWFF COMPWFF IN
    MIN MAX MIRROR PRED PREDICATES process array of boolean integer real word word1 bool signed unsigned
    extend resize sizeof uwconst swconst EX AX EF AF EG AG E F O G H X Y Z A U S V T BU EBF ABF EBG ABG case
    esac mod next init union in xor xnor self TRUE FALSE count abs max min toint itype FUN typeof floor
    clock time Word ITYPE READ WRITE CONSTARRAY ASYNC PARSYNTAX URGENT HRC LET bdd bmc pi sin cos tan exp ln asin acos
    atan pow
    """.split()  # noqa: SIM905 - a list of these would be one word a line
)
"""What NuSMV 2.6 and nuXmv 2 reserve."""
PHASES = ("idle", "running", "stopping")
PLACES = ("empty", "waiting", "clearing")
SIDES = ("less", "equal", "greater")
OWN = frozenset(
    {
        *PHASES,
        *PLACES,
        *SIDES,
        *OUTCOMES,
        "environment",
        "update",
        "enabled",
        "goes_on",
        "start",
        "live",
        "event",
        "runs",
        "reported",
        "before",
        "after",
    }
)
"""Words of the text itself."""


def word(name: str) -> str:
    """Return a name of a spec, without a dot, as one of the text."""
    return f"{name}$" if name in WORDS or name in OWN else name


def flat(name: str) -> str:
    """Return a full name of a spec as one name."""
    return word(name) if "." not in name else name.replace(".", "#")


def spec_name(check: str, subject: str) -> str:
    """Return the name of the specification that is this check's for this subject."""
    escaped = re.sub(r"\w+", lambda part: f"{part[0]}-" if part[0] in WORDS else part[0], subject)
    return f"{check}.{escaped.replace(', ', '--').replace(' ', '-')}"


def claim_name(claim: Claim) -> str:
    """Return the name of a claim's specification."""
    return spec_name(claim.check, claim.subject)


class SmvNames:
    """The names of the variables and events of a loop."""

    def __init__(self, loop: ClosedLoop) -> None:
        self.loop = loop
        index = ModelIndex(loop.model)
        self._stocks, self._slots = index.stocks, index.slots

    # ---- variables ----

    def owner(self, var: int) -> str | None:
        """Return the functional module that a variable is in; None if it is in none."""
        full, _ = self._place(var)
        return full.split(".")[0] if "." in full else None

    def inside(self, var: int) -> str:
        """Return the name of a variable in its module."""
        full, suffix = self._place(var)
        last = full.rpartition(".")[2]
        return f"{last}{suffix}" if suffix else word(last)

    def state(self, var: int) -> str:
        """Return the name of a variable of the state, as the whole text sees it."""
        owner = self.owner(var)
        return f"{word(owner) if owner else 'environment'}.{self.inside(var)}"

    def flat(self, var: int) -> str:
        """Return the name of a variable's value at the end of a part of a step."""
        full, suffix = self._place(var)
        return f"{full.replace('.', '#')}{suffix}" if suffix else flat(full)

    def _place(self, var: int) -> tuple[str, str]:
        """Return the full name that a variable is about, and what is put behind it."""
        loop, key = self.loop, self.loop.variables[var].key
        match key:
            case ("reading", int(number)):
                return loop.names[number], ""
            case ("level", int(number)):
                return self._stocks[number], "$level"
            case ("pair", int(left), int(right)):
                return "", f"{flat(loop.names[left])}$vs${flat(loop.names[right])}"
            case ("phase", int(number)):
                request, slot = self._slots[number]
                return request, f"${slot}"
            case ("class", int(number)):
                request, slot = self._slots[number]
                return request, f"${slot}$args"
            case ("order", int(number), int(which)):
                request, slot = self._slots[number]
                return request, f"${slot}$vs${which}"
            case ("cell", int(number)):
                return loop.model.requests[number].name, "$place$args"
            case ("standing" | "chosen" as kind, int(number), int(which)):
                return loop.model.requests[number].name, f"${kind}$vs${which}"
            case ("tried", int(number)):
                return "", f"tried${number}"
            case ("happened", int(number)):
                return "", f"did${number}"
            case (str(kind), int(number)):
                return loop.model.requests[number].name, f"${kind}"
            case _:
                raise AssertionError(f"a variable of no kind: {key}")

    @cached_property
    def literals(self) -> list[tuple[str, ...]]:
        """By variable how its values are written."""
        return [self._literals(var) for var in range(len(self.loop.variables))]

    def _literals(self, var: int) -> tuple[str, ...]:
        variable = self.loop.variables[var]
        match variable.key:
            case ("phase", _):
                return PHASES
            case ("place", _):
                return PLACES
            case ("last", _):
                return OUTCOMES
            case ("tried" | "fallen" | "happened", _):
                return BOOLEANS
            case ("order" | "standing" | "chosen" | "pair", _, _):
                assert (0, len(SIDES) - 1) == (LEFT, RIGHT)
                return SIDES
            case ("reading", int(number)):
                return self._readings(number, variable.size)
            case _:
                return tuple(str(value) for value in range(variable.size))

    def _readings(self, number: int, size: int) -> tuple[str, ...]:
        match self.loop.types[number]:
            case Bool() if size == len(BOOLEANS):
                return BOOLEANS
            case Int():
                return tuple(str(value) for value in self.loop.ordinals(number))
            case Enum():
                return tuple(f"{value}#" for value in self.loop.samples[number])
            case _:
                return tuple(str(value) for value in range(size))

    def symbol(self, var: int, name: str) -> SmvSymbol:
        """Return a symbol of this name with the values of a variable."""
        return SmvSymbol(name, self.literals[var])

    def value(self, var: int, value: int) -> SmvSymbol:
        """Return the literal of a value."""
        return SmvSymbol(self.literals[var][value], self.literals[var], value)

    def declared(self, var: int) -> str:
        """Return the type of a variable."""
        literals = self.literals[var]
        if literals == BOOLEANS:
            return "boolean"
        numbers = [int(literal) for literal in literals] if self.symbol(var, "").numeric else []
        if numbers and all(after - before == 1 for before, after in pairwise(numbers)):
            return f"{numbers[0]}..{numbers[-1]}"
        return f"{{{', '.join(literals)}}}"

    # ---- events ----

    @cached_property
    def events(self) -> list[str]:
        """The names of the events: what they are about, and which of its kind."""
        found = []
        counted: dict[str, int] = {}
        for each in self.loop.events:
            start = _event(each.event)
            counted[start] = counted.get(start, -1) + 1
            found.append(f"{start}${counted[start]}" if start[:3] in ("ask", "obs") or start.endswith("ok") else start)
        return found


def _event(event: Event) -> str:
    match event:
        case Ask(request):
            return f"ask${request.replace('.', '#')}"
        case Report(request, slot, outcome):
            return f"report${request.replace('.', '#')}${slot}${outcome}"
        case Observe(name):
            return f"observe${name.replace('.', '#')}"
        case Abort(request, slot):
            return f"abort${request.replace('.', '#')}${slot}"
        case AbortWaiting(request):
            return f"abort${request.replace('.', '#')}$waiting"


def modules(names: Iterable[str]) -> list[str]:
    """Return the functional modules that full names are in, each once, in their order."""
    return list(dict.fromkeys(name.split(".")[0] for name in names if "." in name))
