"""Random specs as text, over the whole language of docs/language.md; every one is valid."""

import re
from dataclasses import dataclass, field
from functools import cache
from random import Random

from exover.model.types import Real
from exover.pipeline import load
from exover.source import Source
from tests.support.conditions import Conditions, define
from tests.support.scene import CONSTS, ENUMS, Field, Requested, Scene, Size

VERBS = ("stop", "wait", "fail", "kill", "launch", "past", "used", "go", "look", "grab", "when", "until")
"""Names of requests, keywords among them."""
OUTCOMES = ("launch", "ok", "failed", "interrupted")


@cache
def random_spec(seed: int, size: Size) -> str:
    """Return the text of a valid spec; equal seeds and sizes give equal texts."""
    return _useful(_Writer(Scene(Random(seed), size)).spec(seed))


def _useful(text: str) -> str:
    """Return a spec without what can constrain nothing, which is a mistake; nothing else changes."""
    while mistakes := load(Source("random.exo", text)).diagnostics:
        place = mistakes[0].span
        assert place is not None
        start, end = text.rfind("\n", 0, place.start) + 1, text.find("\n", place.end)
        line = text[start:end]
        match mistakes[0].code:
            case "E421" | "E413" if line.startswith("context"):
                text = text[:start] + text[text.index("}", end) + 1 :]
            case "E421" | "E413":
                text = text[:start] + text[end + 1 :]
            case "E404":  # what it kills used nothing of the resource
                text = text[:start] + re.sub(" by .*?(?= because|;)", "", line) + text[end:]
            case _:
                raise AssertionError(mistakes)
    return text


@dataclass
class _Writer:
    """Writes one spec. `pairs`: what would give two rules one name, by kind, owner and target."""

    scene: Scene
    pairs: set[tuple[str, str, str]] = field(default_factory=set)
    labels: int = 0

    def spec(self, seed: int) -> str:
        """Return the text."""
        scene = self.scene
        self._declare()
        fixed = [f"const {name} = {text};" for name, (_, text) in CONSTS.items()]
        fixed += [f"enum {name} {{ {', '.join(values)} }}" for name, values in ENUMS.items()]
        items = [*fixed, *self._groups(), *self._posters()]
        latches = self._latches()
        items += self._defines()
        items += [self._module(module) for module in scene.modules]
        items += [self._context() for _ in range(scene.random.randint(0, 2))]
        items += self._resources()
        items += [self._rule() for _ in range(scene.size.rules)]
        items += [self._launch() for _ in range(scene.size.launches)]
        scene.random.shuffle(items)
        places = sorted(scene.random.randint(0, len(items)) for _ in latches)
        for moved, (place, latch) in enumerate(zip(places, latches, strict=True)):
            items.insert(place + moved, latch)  # in their order: each reads those before it
        return f"spec s{seed};\n" + "\n".join(items) + "\n"

    # ---- declarations ----

    def _declare(self) -> None:
        """Choose all names and types, so that conditions may read what stands further below."""
        scene = self.scene
        scene.modules = tuple(f"m{letter}" for letter in "abcdefgh"[: scene.size.modules])
        verbs = scene.random.sample(VERBS, len(VERBS))
        for number in range(scene.size.requests):
            module = scene.random.choice(scene.modules)
            name = verbs.pop() if verbs and scene.chance(15) else f"r{number}"
            statuses = ("bad", "worse") if scene.chance(30) else ()
            instances = scene.random.randint(1, scene.size.instances) if scene.chance(35) else 1
            params = self._fields(("v", "w", "z", "n"), 3 if scene.size.depth > 1 else 2)
            results = self._fields(("d", "e"), 1)
            scene.requests.append(Requested(module, name, params, results, statuses, instances))
        scene.requests.sort(key=lambda request: request.module)
        names = ["bat", "lim", "door", "v", "hot", "tilt"]
        for number in range(scene.size.readings):
            module = scene.random.choice(("", "", *scene.modules))
            kind = scene.random.choice(scene.size.types)
            name = names[number % len(names)] + str(number) * (scene.chance(70) or number >= len(names))
            if module and not isinstance(kind, Real) and scene.chance(50):
                scene.states.setdefault(module, []).append(Field(name, kind))
            else:
                scene.posters.setdefault(module, []).append(Field(name, kind))
        for number in range(scene.random.randint(0, scene.size.resources)):
            chosen = scene.renewable if scene.chance(60) else scene.consumable
            chosen[f"p{number}"] = scene.random.randint(1, 8 if scene.size.depth > 1 else 3)
        scene.latches = [f"alarm{number}" for number in range(scene.random.randint(0, scene.size.latches))]
        for number in range(scene.random.randint(0, 1 + scene.size.requests // 4)):
            text = [request.full for request in scene.requests]
            named = scene.random.sample(text, scene.random.randint(1, min(3, len(text))))
            scene.groups[f"g{number}"] = tuple(named)

    def _fields(self, names: tuple[str, ...], most: int) -> tuple[Field, ...]:
        scene = self.scene
        chosen = scene.random.sample(names, min(len(names), scene.random.randint(0, most)))
        return tuple(Field(name, scene.random.choice(scene.size.types)) for name in chosen)

    def _groups(self) -> list[str]:
        return [f"group {name} = {', '.join(requests)};" for name, requests in self.scene.groups.items()]

    def _defines(self) -> list[str]:
        found = []
        for number in range(self.scene.random.randint(0, 3)):
            made, text = define(self.scene, f"def{number}")
            self.scene.defines.append(made)
            found.append(f"define {made.name} = {text};")
        return found

    def _latches(self) -> list[str]:
        found = []
        for number, name in enumerate(self.scene.latches):
            text = Conditions(self.scene, "latch", latches=number).make()
            found.append(f"latch {name}: when {text} until {self.scene.listed(most=2)[0]};")
        return found

    def _posters(self) -> list[str]:
        return [self._poster(each) for each in self.scene.posters.get("", [])]

    def _poster(self, each: Field) -> str:
        scene = self.scene
        fallback = f" else {scene.constant(each.type, True)}" if scene.chance(30) else ""
        return f"poster {each.name}: {scene.type_text(each.type)} = {scene.constant(each.type, True)}{fallback};"

    def _resources(self) -> list[str]:
        """Return the resources; the clauses that use them have been written."""
        scene = self.scene
        found = []
        for name, capacity in scene.renewable.items():
            users = sorted(scene.users.get(name, set()))
            found.append(f"resource {name}: {capacity}{self._remedies(users)}{self._because()};")
        for name, capacity in scene.consumable.items():
            initial = f" = {scene.random.randint(0, capacity)}" if scene.chance(50) else ""
            found.append(f"resource {name}: {capacity} consumable{initial}{self._remedies([])}{self._because()};")
        return found

    # ---- modules and clauses ----

    def _module(self, module: str) -> str:
        scene = self.scene
        members = [self._poster(each) for each in scene.posters.get(module, [])]
        for each in scene.states.get(module, []):
            members.append(f"state {each.name}: {scene.type_text(each.type)} = {scene.constant(each.type, True)};")
        members += [self._request(request) for request in scene.requests if request.module == module]
        title = ' "a module"' if scene.chance(20) else ""
        return f"module {module}{title} {{\n" + "".join(f"    {member}\n" for member in members) + "}"

    def _request(self, request: Requested) -> str:
        scene = self.scene
        returns = f" returns ({self._declared(request.results)})" if request.results else ""
        fails = f" fails ({', '.join(request.statuses)})" if request.statuses else ""
        instances = f" instances {request.instances}" if request.instances > 1 or scene.chance(5) else ""
        head = f"request {request.name}({self._declared(request.params)}){returns}{fails}{instances}"
        clauses = [self._clause(request) for _ in range(scene.random.randint(0, scene.size.clauses))]
        clauses = [clause for clause in clauses if clause]
        if not clauses:
            return f"{head};"
        return f"{head} {{\n" + "".join(f"        {clause}\n" for clause in clauses) + "    }"

    def _declared(self, fields: tuple[Field, ...]) -> str:
        return ", ".join(f"{each.name}: {self.scene.type_text(each.type)}" for each in fields)

    def _context(self) -> str:
        request = self.scene.random.choice(self.scene.requests)
        clauses = [self._clause(request) for _ in range(self.scene.random.randint(1, 2))]
        return f"context {request.full} {{\n" + "".join(f"    {clause}\n" for clause in clauses if clause) + "}"

    def _clause(self, owner: Requested) -> str:
        """Return a clause, or nothing where the chosen kind has no object."""
        scene = self.scene
        if scene.chance(scene.size.conflicts):
            return self._conflict(owner)
        match scene.random.randrange(13):
            case 0:
                return f"check{self._label()} {self._condition('guard', owner)}{self._because()};"
            case 1 | 2:
                return f"wait{self._label()} until {self._condition('guard', owner)}{self._because()};"
            case 3:
                return f"settle{self._label()} until {self._condition('guard', owner)}{self._because()};"
            case 4 | 5:
                maker = Conditions(scene, "fail", owner)
                condition = maker.narrow() if scene.chance(60) else maker.make()
                return f"fail{self._label()} when {condition}{self._else_wait()}{self._because()};"
            case 6:
                return self._ordered(owner, scene.random.choice(("after", "before")))
            case 7 | 8:
                return self._interrupts(owner)
            case 9 | 10:
                return self._amount(owner)
            case _:
                return self._effect(owner)

    def _conflict(self, owner: Requested) -> str:
        """Return a clause by which the request gets in the way of others, or waits for them."""
        if self.scene.chance(40):
            return self._interrupts(owner)
        kind = self.scene.random.choice(("wait", "settle", "settle"))
        phases = Conditions(self.scene, "guard", owner).phases()
        return f"{kind}{self._label()} until {phases}{self._because()};"

    def _condition(self, standing: str, owner: Requested) -> str:
        return Conditions(self.scene, standing, owner).make()

    def _ordered(self, owner: Requested, kind: str) -> str:
        text, named = self.scene.listed(frozenset({owner.full}), most=2)
        if not named or not self._new(kind, owner.full, named):
            return ""
        return f"{kind} {text}{self._because()};"

    def _new(self, kind: str, owner: str, named: list[str]) -> bool:
        """Return whether none of these pairs stands yet; if so, they do now."""
        keys = {(kind, owner, each) for each in named}
        fresh = not keys & self.pairs
        if fresh:
            self.pairs |= keys
        return fresh

    def _interrupts(self, owner: Requested) -> str:
        scene = self.scene
        texts: list[str] = []
        named: list[str] = []
        if scene.chance(15):
            texts.append("all")
            named += [r.full for r in scene.requests if r.module == owner.module and r != owner]
        elif scene.chance(60):
            text, named = scene.listed(frozenset({owner.full}), most=2)
            texts += [text] if text else []
        if scene.chance(40) and "all" not in texts:
            texts.insert(scene.random.randint(0, len(texts)), "self")
            named.append("self")
        if not texts or not self._new("interrupts", owner.full, named):
            return ""
        return f"interrupts {', '.join(texts)}{self._else_wait()}{self._because()};"

    def _amount(self, owner: Requested) -> str:
        scene = self.scene
        known = [*scene.renewable, *scene.consumable]
        if not known:
            return ""
        name = scene.random.choice(known)
        when = f" when {self._condition('amount', owner)}" if scene.chance(40) else ""
        if name in scene.renewable:
            scene.users.setdefault(name, set()).add(owner.full)
            amount = scene.random.randint(0, scene.renewable[name] + 1)
            return f"uses {name} {amount}{when}{self._because()};"
        kind = scene.random.choice(("consumes", "produces"))
        return f"{kind} {name} {scene.random.randint(0, scene.consumable[name])}{when}{self._because()};"

    def _effect(self, owner: Requested) -> str:
        scene = self.scene
        moment = scene.random.choice(OUTCOMES)
        states = [(module, state) for module, known in scene.states.items() for state in known]
        if states and scene.chance(65):
            module, state = scene.random.choice(states)
            name = state.name if module == owner.module and scene.chance(60) else f"{module}.{state.name}"
            return f"on {moment} set {name} = {scene.constant(state.type, True)};"
        return f"on {moment} forget {scene.listed(most=2)[0]};"

    # ---- rules ----

    def _rule(self) -> str:
        scene = self.scene
        match scene.random.randrange(10):
            case 0 | 1:
                text, named = scene.listed(most=3, least=2)
                return f"mutex{self._label()} {text}{self._remedies(named)}{self._because()};"
            case 2 | 3:
                winners, named = scene.listed(most=2)
                losers, _ = scene.listed(frozenset(named), most=2)
                if not losers:
                    return ""
                return f"mutex{self._label()} {winners} over {losers}{self._else_wait()}{self._because()};"
            case 4:
                text, named = scene.listed(most=3)
                most = scene.random.choice((0, 1, 1, 2, 3))
                return f"limit{self._label()} at most {most} of {text}{self._remedies(named)}{self._because()};"
            case 5 | 6 | 7:
                maker = Conditions(scene, "forbid")
                condition = maker.engaged() if scene.chance(75) else maker.make()
                killable = maker.active.union(*(scene.users.get(name, set()) for name in maker.used))
                return f"forbid{self._label()} {condition}{self._remedies(sorted(killable))}{self._because()};"
            case _:
                return self._launch()

    def _launch(self) -> str:
        scene = self.scene
        request = scene.random.choice(scene.requests)
        values = ", ".join(scene.constant(param.type, True) for param in request.params)
        condition = Conditions(scene, "launch").make()
        return f"launch{self._label()} {request.full}({values}) when {condition}{self._because()};"

    def _remedies(self, killable: list[str]) -> str:
        """Return the remedies, with kills of what may be killed; often none, which means reject."""
        scene = self.scene
        chosen = []
        for _ in range(scene.random.randint(0, 3)):
            if killable and scene.chance(60):
                chosen.append(f"kill {scene.some_of(killable)}")
            else:
                chosen.append(scene.random.choice(("reject", "wait")))
        return f" by {' or '.join(chosen)}" if chosen else ""

    # ---- small parts ----

    def _label(self) -> str:
        self.labels += 1
        return f" x{self.labels}:" if self.scene.chance(30) else ""

    def _else_wait(self) -> str:
        return " else wait" if self.scene.chance(40) else ""

    def _because(self) -> str:
        return f' because "reason {self.scene.random.randint(1, 99)}"' if self.scene.chance(25) else ""
