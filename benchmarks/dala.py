"""Modules as large as those GenoM modules of the rover Dala whose freedom of deadlocks D-Finder proved.

The figures are those of Bensalem, de Silva, Gallien, Ingrand and Yan, "Rock solid software: a verifiable and
correct-by-construction controller" (2010, 2011). Their BIP models are not at hand: what stands here is a family of
specs of that size, written by a seeded generator, and the times compare two ways to put and to answer a question of
one kind, not two answers to one question. A component of theirs is here

- a service: a request, of 9 locations (idle, running or stopping, with its waiting place empty, waiting or clearing);
- the control task: an enum state, whose values are its locations;
- a poster: an enum, whose values are its locations.

Their booleans are bool states that services set and check, their integers are int posters that services watch.
"""

from dataclasses import dataclass
from random import Random

SERVICE = 9
"""Locations of a service."""


@dataclass(frozen=True, slots=True)
class Size:
    """A module of theirs: components, locations, booleans and integers, and the time that D-Finder took (min:s)."""

    name: str
    components: int
    locations: int
    booleans: int
    integers: int
    time: str

    @property
    def services(self) -> int:
        """So many services that two and a half locations are left for every other component."""
        return int((self.locations - 2.5 * self.components) / (SERVICE - 2.5))

    def enums(self) -> list[int]:
        """Return the numbers of locations of the control task and of the posters, as even as they can be."""
        count = self.components - self.services
        least, larger = divmod(self.locations - SERVICE * self.services, count)
        return [least + (number < larger) for number in range(count)]


SIZES = (
    Size("rflex", 56, 308, 30, 16, "9:39"),
    Size("ndd", 27, 152, 16, 10, "14:25"),
    Size("sick", 43, 213, 18, 10, "6:07"),
    Size("aspect", 29, 160, 16, 11, "1:00"),
    Size("battery", 30, 176, 21, 11, "4:43"),
    Size("heating", 26, 149, 18, 12, "0:39"),
    Size("platine", 37, 174, 16, 9, "8:47"),
)


def spec(size: Size) -> str:
    """Return the text of a module of this size."""
    task, *posters = size.enums()
    lines = [f"spec {size.name};", "module m {", f"    state task: {_enum(task)} = v0;"]
    lines += [f"    state b{number}: bool = false;" for number in range(size.booleans)]
    lines += [f"    poster p{number}: {_enum(count)} = v0;" for number, count in enumerate(posters)]
    lines += [f"    poster n{number}: int in 0 .. 9 = 5;" for number in range(size.integers)]
    lines += ["    request init() { on launch set task = v1; on failed set task = v0; }"]
    lines += ["    request stop() { interrupts all; on launch set task = v0; }"]
    writer = _Services(size, task, posters, Random(size.name))
    for number in range(size.services - 2):
        lines += writer.service(number)
    return "\n".join([*lines, "}", *writer.mutexes(), ""])


def _enum(count: int) -> str:
    return f"{{{', '.join(f'v{value}' for value in range(count))}}}"


@dataclass(frozen=True, slots=True)
class _Services:
    """Writes services that initialise, wait for posters and for each other, take over, fail and leave marks."""

    size: Size
    task: int
    posters: list[int]
    random: Random

    def service(self, number: int) -> list[str]:
        """Return the lines of one service."""
        random, others = self.random, self.size.services - 2
        poster, watched = random.sample(range(len(self.posters)), 2)
        clauses = ["after m.init", f"wait until p{poster} != v{random.randrange(self.posters[poster])}"]
        if number % 2:
            clauses.append(f"check not b{random.randrange(self.size.booleans)} or task != v0")
        if number % 3 == 0 and others > 1:
            clauses.append(f"settle until not active(m.s{_another(random, number, others)})")
        if number % 3 == 1 and others > 1:
            clauses.append(f"interrupts m.s{_another(random, number, others)} else wait")
        clauses.append(f"fail when p{watched} == v{self.posters[watched] - 1} else wait")
        clauses.append(f"fail when n{number % self.size.integers} < {1 + number % 4}")
        clauses.append(f"on launch set task = v{number % self.task}")
        clauses.append(f"on ok set b{number % self.size.booleans} = true")
        clauses.append(f"on interrupted set b{number % self.size.booleans} = false")
        return [f"    request s{number}() {{", *(f"        {clause};" for clause in clauses), "    }"]

    def mutexes(self) -> list[str]:
        """Return one mutex for each service, with another that it then waits for."""
        others = self.size.services - 2
        found = [(number, _another(self.random, number, others)) for number in range(others)]
        kept = dict.fromkeys(tuple(sorted(pair)) for pair in found)
        return [f"mutex m.s{first}, m.s{second} by wait;" for first, second in kept]


def _another(random: Random, number: int, count: int) -> int:
    """Return a random number below `count` that is not this one."""
    return (number + random.randrange(1, count)) % count
