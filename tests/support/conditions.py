"""Random conditions, each allowed where it stands (docs/language.md section 2)."""

from dataclasses import dataclass, field

from exover.model.types import Bool, Enum, Int, Real, Type
from tests.support.scene import CONSTS, Defined, Requested, Scene

ALLOWED: dict[str, tuple[str, ...]] = {
    "guard": ("phase", "active", "past", "last", "amount", "reading", "param", "define"),
    "launch": ("phase", "active", "past", "last", "amount", "reading", "define"),
    "fail": ("active", "past", "amount", "reading", "param", "define"),
    "forbid": ("active", "past", "amount", "reading", "define"),
    "latch": ("level", "reading", "define"),
    "amount": ("param",),
}
"""What a condition may read by where it stands."""
PAIRS = ("guard", "fail")
"""Where a real poster may be compared with another real."""
ORDERS = ("<", "<=", ">", ">=", "==", "!=")
SIMPLE_INTS = 5
"""Values that an int has at most to stand in a sum or as `self.p`: more make no new case, only larger diagrams."""


@dataclass(frozen=True, slots=True)
class Operand:
    """A term as text; `poster`: it is no parameter."""

    text: str
    type: Type
    poster: bool = False


@dataclass
class Conditions:
    """Makes conditions that stand somewhere, in a clause of `owner` if there is one; notes what they read."""

    scene: Scene
    standing: str
    owner: Requested | None = None
    latches: int | None = None
    """In a latch, how many latches it may read."""
    active: set[str] = field(default_factory=set)
    used: set[str] = field(default_factory=set)

    def phases(self) -> str:
        """Return a condition on what other requests do at this moment, for a guard."""
        kind = self.scene.random.choice(("active", "running", "stopping", "waiting", "waiting"))
        return self.scene.random.choice(("", "not ")) + self._status(kind)

    def engaged(self) -> str:
        """Return that a request is active while something is read, which a kill can mend."""
        other = f"not {self._status('active')}" if self.scene.chance(20) else self._of_kind("reading")
        parts = [self._status("active"), other or self._atom()]
        self.scene.random.shuffle(parts)
        return f"({parts[0]}) and ({parts[1]})"

    def narrow(self) -> str:
        """Return a condition that seldom holds."""
        return f"({self._atom()}) and ({self.make(0)})"

    def make(self, depth: int | None = None) -> str:
        """Return a condition."""
        depth = self.scene.random.randint(0, self.scene.size.depth) if depth is None else depth
        if depth == 0:
            return self._atom()
        match self.scene.random.randrange(6):
            case 0:
                return f"not ({self.make(depth - 1)})"
            case 1:
                return f"({self.make(depth - 1)}) implies ({self.make(depth - 1)})"
            case 2 | 3:
                return f"({self.make(depth - 1)}) and ({self.make(depth - 1)})"
            case _:
                return f"({self.make(depth - 1)}) or ({self.make(depth - 1)})"

    # ---- atoms ----

    def _atom(self) -> str:
        kinds = list(ALLOWED[self.standing])
        self.scene.random.shuffle(kinds)
        for kind in kinds:
            found = self._of_kind(kind)
            if found:
                return found
        return self.scene.random.choice(("true", "false", "yes", "1 < few", "not false"))

    def _of_kind(self, kind: str) -> str | None:
        match kind:
            case "phase":
                return self._status(self.scene.random.choice(("running", "stopping", "waiting", "waiting")))
            case "active" | "past":
                return self._status(kind)
            case "last":
                outcome = self.scene.random.choice(("none", "ok", "failed", "interrupted"))
                relation = self.scene.random.choice(("==", "!="))
                return f"last({self.scene.random.choice(self.scene.requests).full}) {relation} {outcome}"
            case "amount" | "level":
                return self._resource(kind == "level")
            case "reading":
                return self._compare(self._readings())
            case "param":
                return self._compare(self._params())
            case _:
                return self._define()

    def _status(self, kind: str) -> str:
        scene = self.scene
        if scene.chance(45):
            request = scene.random.choice(scene.requests)
            where = self._where(request, kind == "past")
            if where:
                self._read(kind, [request.full])
                return f"{kind}({request.full} with {where})"
        text, named = scene.listed(most=2)
        self._read(kind, named)
        return f"{kind}({text})"

    def _read(self, kind: str, requests: list[str]) -> None:
        if kind == "active":
            self.active.update(requests)

    def _resource(self, only_level: bool) -> str | None:
        scene = self.scene
        known = list(scene.consumable) if only_level else [*scene.renewable, *scene.consumable]
        if not known:
            return None
        name = scene.random.choice(known)
        relation = scene.random.choice(ORDERS)
        if name in scene.consumable:
            return f"level({name}) {relation} {scene.random.randint(0, scene.consumable[name])}"
        self.used.add(name)
        return f"used({name}) {relation} {scene.random.randint(0, scene.renewable[name])}"

    def _define(self) -> str | None:
        known = [define for define in self.scene.defines if self.standing in define.standings]
        if not known:
            return None
        define = self.scene.random.choice(known)
        self.active |= define.active
        self.used |= define.used
        return define.name

    # ---- what can be compared ----

    def _params(self) -> list[Operand]:
        owner = self.owner
        if owner is None:
            return []
        own = "self." if self.scene.chance(10) else ""
        found = [Operand(f"{own}{param.name}", param.type) for param in owner.params]
        return found + (self._readings() if self.standing in PAIRS and self.scene.chance(50) and found else [])

    def _readings(self) -> list[Operand]:
        scene, owner = self.scene, self.owner
        shadowed = {param.name for param in owner.params} if owner else set()
        found = []
        for module in ("", *scene.modules):
            for each in scene.posters.get(module, []) + scene.states.get(module, []):
                if self.standing == "latch" and each in scene.states.get(module, []):
                    continue
                bare = not module or (owner is not None and owner.module == module and scene.chance(60))
                if bare and each.name not in shadowed:
                    found.append(Operand(each.name, each.type, poster=True))
                elif module:
                    found.append(Operand(f"{module}.{each.name}", each.type, poster=True))
        known = scene.latches[: self.latches] if self.latches is not None else scene.latches
        return found + [Operand(name, Bool(), poster=True) for name in known]

    def _where(self, request: Requested, past: bool) -> str | None:
        """Return a condition on the arguments of a request, for `past` on its results too."""
        fields = request.params + request.results if past else request.params
        operands = [Operand(each.name, each.type) for each in fields]
        if self.owner and self.scene.chance(50):
            own = [param for param in self.owner.params if _few(param.type)]
            if self.owner.instances > 1:  # the copies for all slots choose together
                own = [param for param in own if not isinstance(param.type, Int)][:1]
            operands += [Operand(f"self.{param.name}", param.type) for param in own]
        first = self._compare(operands)
        if first is None or self.scene.chance(70):
            return first
        joined = self.scene.random.choice(("and", "or", "implies"))
        return f"{first} {joined} not ({self._compare(operands)})"

    # ---- comparisons ----

    def _compare(self, operands: list[Operand]) -> str | None:
        if not operands:
            return None
        left = self.scene.random.choice(operands)
        others = [other for other in operands if other.text != left.text and self._comparable(left, other)]
        right = self.scene.random.choice(others) if others and self.scene.chance(50) else None
        match left.type:
            case Bool() | Enum():
                return self._equate(left, right)
            case Int():
                return self._integers(left, right, others)
            case Real():
                return self._reals(left, right)

    def _comparable(self, left: Operand, right: Operand) -> bool:
        if isinstance(left.type, Int):
            return isinstance(right.type, Int) and _few(left.type) and _few(right.type)
        if isinstance(left.type, Real):
            allowed = self.standing in PAIRS or not (left.poster or right.poster)
            return isinstance(right.type, Real) and allowed
        return left.type == right.type

    def _equate(self, left: Operand, right: Operand | None) -> str:
        scene = self.scene
        if isinstance(left.type, Bool) and right is None and scene.chance(50):
            return left.text
        if scene.chance(25):
            return (
                f"{left.text} in {{{', '.join(scene.constant(left.type) for _ in range(scene.random.randint(1, 2)))}}}"
            )
        sides = [left.text, right.text if right else scene.constant(left.type)]
        scene.random.shuffle(sides)
        return f"{sides[0]} {scene.random.choice(('==', '!='))} {sides[1]}"

    def _integers(self, left: Operand, right: Operand | None, others: list[Operand]) -> str:
        scene = self.scene
        if right is None and scene.chance(30):
            low, high = sorted((scene.constant(left.type), scene.constant(left.type)), key=_number)
            return f"{left.text} in {low} .. {high}"
        if right is None and scene.chance(20):
            return f"{left.text} in {{{scene.constant(left.type)}, {scene.constant(left.type)}}}"
        relation = scene.random.choice(ORDERS)
        if right is None:
            if _few(left.type) and scene.chance(30):
                return f"{scene.random.randint(-2, 3)} * {left.text} - 1 {relation} {scene.random.randint(-3, 5)}"
            sides = [left.text, scene.constant(left.type)]
            scene.random.shuffle(sides)
            return f"{sides[0]} {relation} {sides[1]}"
        if scene.chance(40):
            return f"{left.text} {relation} {right.text}"
        sign = scene.random.choice("+-")
        factor = scene.random.choice(("", "2 * ", "few * "))
        rest = scene.random.choice(others).text if scene.chance(20) else str(scene.random.randint(-2, 5))
        return f"{factor}{left.text} {sign} {right.text} {relation} {rest}"

    def _reals(self, left: Operand, right: Operand | None) -> str:
        scene = self.scene
        relation = scene.random.choice(ORDERS)
        if right is not None:
            if scene.chance(15):
                return f"{left.text} in {scene.constant(left.type)} .. {right.text}"
            return f"{left.text} {relation} {right.text}"
        if scene.chance(25):
            low, high = sorted((scene.constant(left.type), scene.constant(left.type)), key=_number)
            return f"{left.text} in {low} .. {high}"
        if scene.chance(10):
            return f"{left.text} in {{{scene.constant(left.type)}, {scene.constant(left.type)}}}"
        sides = [left.text, scene.constant(left.type)]
        scene.random.shuffle(sides)
        return f"{sides[0]} {relation} {sides[1]}"


def define(scene: Scene, name: str) -> tuple[Defined, str]:
    """Return a define and its condition; it is of use where all that it reads may be read."""
    standing = scene.random.choice(("guard", "launch", "fail", "forbid", "forbid", "latch"))
    maker = Conditions(scene, standing, latches=0 if standing == "latch" else None)
    text = maker.make()
    usable = {
        "guard": {"guard"},
        "launch": {"guard", "launch"},
        "fail": {"guard", "fail"},
        "forbid": {"guard", "launch", "fail", "forbid"},
        "latch": {"guard", "launch", "fail", "forbid", "latch"},
    }
    return Defined(name, frozenset(usable[standing]), frozenset(maker.active), frozenset(maker.used)), text


def _few(kind: Type) -> bool:
    match kind:
        case Bool() | Enum():
            return True
        case Int(low, high):
            return high - low < SIMPLE_INTS
        case Real():
            return False


def _number(text: str) -> float:
    return float(CONSTS[text][1] if text in CONSTS else text)
