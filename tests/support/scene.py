"""What a random spec declares: the names that its conditions and rules may use."""

from dataclasses import dataclass, field
from random import Random

from exover.model.types import Bool, Enum, Int, Real, Type

ENUMS = {"hue": ("red", "green", "blue"), "side": ("left", "right")}
"""The enums of every spec, by name; the text may also list the values in place."""
CONSTS: dict[str, tuple[Type, str]] = {
    "fast": (Real(), "1.25"),
    "tiny": (Real(), "1e-1"),
    "few": (Int(2, 2), "2"),
    "yes": (Bool(), "true"),
    "dye": (Enum(ENUMS["hue"]), "green"),
}
"""The consts of every spec: type and text."""
REALS = ("-0.5", "0", "0.1", "0.2", "0.3", "0.30000000000000004", "0.5", "1", "1.25", "2", "1e300", "5e-324")
"""What reals are compared with; few, so that the same one is met again."""


@dataclass(frozen=True, slots=True)
class Size:
    """How large a spec is: numbers of things, clauses a request at most, depth of conditions at most."""

    requests: int = 6
    modules: int = 3
    readings: int = 5
    latches: int = 1
    resources: int = 2
    rules: int = 6
    clauses: int = 4
    depth: int = 2
    instances: int = 3
    conflicts: int = 25
    """Percentage of clauses and rules by which requests get in each other's way."""
    launches: int = 0
    """Required launches beside the rules, which may be some, too."""
    types: tuple[Type, ...] = (
        Bool(),
        Int(0, 2),
        Int(-2, 2),
        Int(0, 1000),
        Real(0.0, 2.0),
        Real(-1.0, 1.0),
        Real(),
        Enum(("left", "right")),
        Enum(("red", "green", "blue")),
        Enum(("one", "two")),
    )


TINY = Size(
    requests=3,
    modules=2,
    readings=1,
    resources=1,
    rules=3,
    clauses=2,
    depth=1,
    instances=2,
    types=(Bool(), Int(0, 2), Real(0.0, 2.0), Enum(("left", "right"))),
)
"""Small enough for its states to be counted."""


@dataclass(frozen=True, slots=True)
class Field:
    """A parameter, result, poster, state or latch, by the name that it is declared under."""

    name: str
    type: Type


@dataclass(frozen=True, slots=True)
class Requested:
    """A request as far as conditions need to know it."""

    module: str
    name: str
    params: tuple[Field, ...]
    results: tuple[Field, ...]
    statuses: tuple[str, ...]
    instances: int

    @property
    def full(self) -> str:
        """The name with its module."""
        return f"{self.module}.{self.name}"


@dataclass(frozen=True, slots=True)
class Defined:
    """A define: its name, where it may be used, the requests that it reads by `active`, the resources by `used`."""

    name: str
    standings: frozenset[str]
    active: frozenset[str]
    used: frozenset[str]


@dataclass
class Scene:
    """Everything that is declared so far; `users`: the requests that use a resource."""

    random: Random
    size: Size
    modules: tuple[str, ...] = ()
    requests: list[Requested] = field(default_factory=list)
    posters: dict[str, list[Field]] = field(default_factory=dict)
    """By module; the top-level ones under the empty name."""
    states: dict[str, list[Field]] = field(default_factory=dict)
    latches: list[str] = field(default_factory=list)
    renewable: dict[str, int] = field(default_factory=dict)
    consumable: dict[str, int] = field(default_factory=dict)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)
    defines: list[Defined] = field(default_factory=list)
    users: dict[str, set[str]] = field(default_factory=dict)

    def chance(self, percent: int) -> bool:
        """Return true so often."""
        return self.random.randrange(100) < percent

    def type_text(self, kind: Type) -> str:
        """Return how a type is written."""
        match kind:
            case Bool():
                return "bool"
            case Int(low, high):
                return f"int in {low} .. {'few' if high == 2 and self.chance(30) else high}"
            case Real() if kind == Real():
                return "real"
            case Real(low, high):
                return f"real in {low:g} .. {high:g}"
            case Enum(values):
                names = [name for name, known in ENUMS.items() if known == values]
                return names[0] if names and self.chance(60) else f"{{{', '.join(values)}}}"

    def constant(self, kind: Type, inside: bool = False) -> str:
        """Return a constant opposite a term of this type; `inside`: one of its domain."""
        match kind:
            case Bool():
                return self.random.choice(("true", "false", "yes"))
            case Int(low, high):
                near = [low, high, low + 1, *(number for number in (0, 1, 2) if low <= number <= high)]
                if not inside:
                    near += [low - 1, high + 1]
                number = self.random.choice([number for number in near if not inside or number <= high])
                return "few" if number == 2 and self.chance(40) else str(number)
            case Real(low, high):
                texts = [text for text in REALS if not inside or low <= float(text) <= high]
                text = self.random.choice(texts)
                named = {"1.25": "fast", "0.1": "tiny"}
                return named[text] if text in named and self.chance(40) else text
            case Enum(values):
                value = self.random.choice(values)
                return "dye" if value == "green" and self.chance(40) else value

    def listed(self, banned: frozenset[str] = frozenset(), most: int = 3, least: int = 1) -> tuple[str, list[str]]:
        """Return the text of a list of requests, groups and modules, and the requests that it names, in order."""
        choices: list[tuple[str, tuple[str, ...]]] = [(r.full, (r.full,)) for r in self.requests]
        self.random.shuffle(choices)
        if self.chance(25):
            choices = [*self.groups.items(), *choices]
        if self.chance(10):
            module = self.random.choice(self.modules)
            choices.insert(0, (f"{module}.*", tuple(r.full for r in self.requests if r.module == module)))
        texts: list[str] = []
        named: list[str] = []
        wanted = self.random.randint(least, most)
        for text, requests in choices:
            if len(named) < wanted and requests and not ({*named, *banned} & set(requests)):
                texts.append(text)
                named += requests
        return ", ".join(texts), named

    def some_of(self, requests: list[str]) -> str:
        """Return the text of a list of one or two of the requests."""
        return ", ".join(self.random.sample(requests, min(len(requests), self.random.randint(1, 2))))
