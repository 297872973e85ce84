"""Specs that grow: each function returns the text of one with `size` requests. The same size gives the same text."""

from random import Random

DEGREE = 3
"""Mutexes for each request of a random spec: with the rules linear in the requests, so should be the tables."""


def _spec(size: int, rules: str, extra: str = "") -> str:
    requests = "".join(f"    request r{number}();\n" for number in range(size))
    return f"spec family;\nmodule m {{\n{requests}{extra}}}\n{rules}"


def _names(size: int) -> str:
    return ", ".join(f"m.r{number}" for number in range(size))


def pairs(size: int, count: int) -> list[tuple[int, int]]:
    """Return `count` random pairs of `size` requests, or all there are, none of them twice."""
    random = Random(size)
    found: dict[tuple[int, int], None] = {}
    while len(found) < min(count, size * (size - 1) // 2):
        first, second = sorted(random.sample(range(size), 2))
        found[first, second] = None
    return list(found)


def mutexes(size: int) -> str:
    """Return a spec with `DEGREE * size` random binary mutexes, no pair of requests in two of them."""
    return _spec(size, "".join(f"mutex m.r{first}, m.r{second};\n" for first, second in pairs(size, DEGREE * size)))


def guarded(size: int, count: int, failing: int) -> str:
    """Return a spec with `count` random binary mutexes, and `failing` requests that fail below a bound of a poster."""
    bounds = {number: 1 + bound % 90 for bound, number in enumerate(Random(size).sample(range(size), failing))}
    rules = "poster battery: int in 0 .. 100 = 100;\n"
    rules += "".join(f"context m.r{number} {{ fail when battery < {bound}; }}\n" for number, bound in bounds.items())
    return _spec(size, rules + "".join(f"mutex m.r{first}, m.r{second};\n" for first, second in pairs(size, count)))


def conflicts(size: int) -> list[tuple[int, int]]:
    """Return the edges of a random conflict graph of `size` requests, each with 2.5 neighbours on average."""
    return pairs(size, 5 * size // 4)


def queues(size: int) -> str:
    """Return a spec whose requests wait for their neighbours in the conflict graph."""
    return _spec(size, "".join(f"mutex m.r{first}, m.r{second} by wait;\n" for first, second in conflicts(size)))


def priorities(size: int) -> str:
    """Return the random mutexes as priorities: the request declared first wins."""
    random = Random(size)
    pairs = {tuple(sorted(random.sample(range(size), 2))): None for _ in range(DEGREE * size)}
    return _spec(size, "".join(f"mutex m.r{first} over m.r{second};\n" for first, second in pairs))


def stop(size: int) -> str:
    """Return a spec whose stop interrupts all others."""
    return _spec(size, "", "    request stop() { interrupts all; }\n")


def crowd(size: int) -> str:
    """Return a spec whose one guard asks whether any of all requests is active, and one rule forbids it."""
    group = f"group everyone = {_names(size)};\nposter door: bool = false;\n"
    request = "    request enter() { check not active(everyone); }\n"
    return _spec(size, f"{group}forbid active(everyone) and door by kill everyone;\n", request)


def limit(size: int) -> str:
    """Return a spec that lets three of all requests be active and kills the last ones for a newcomer."""
    last = ", ".join(f"m.r{number}" for number in range(max(0, size - 3), size))
    return _spec(size, f"limit few: at most 3 of {_names(size)} by kill {last} or wait;\n")


def limit_all(size: int) -> str:
    """Return a spec that lets three of all requests be active and kills every other one for a newcomer."""
    return _spec(size, f"limit few: at most 3 of {_names(size)} by kill {_names(size)};\n")


def power(size: int) -> str:
    """Return a spec whose requests share a resource, each with an amount of its own."""
    rules = "resource power: 1000 by wait;\n"
    requests = "".join(f"    request r{number}() {{ uses power {37 * number % 101 + 1}; }}\n" for number in range(size))
    return f"spec family;\nmodule m {{\n{requests}}}\n{rules}"


def contexts(size: int) -> str:
    """Return a spec with a fail context for every request, each on its own bound of one poster."""
    rules = "poster battery: int in 0 .. 1000000 = 1000000;\n"
    rules += "".join(f"context m.r{number} {{ fail when battery < {number + 1}; }}\n" for number in range(size))
    return _spec(size, rules)


def fleet(size: int) -> str:
    """Return a spec of a request with so many slots, killed by arguments, that share a resource with another."""
    survey = (
        f"request survey(x: int in 0 .. 9) instances {size} {{ uses power 2; fail when x > 5 and active(m.carry); }}"
    )
    carry = f"request carry() instances {size} {{ uses power 3; }}"
    return f"spec family;\nmodule m {{\n    {survey}\n    {carry}\n}}\nresource power: {3 * size} by wait;\n"


def convoy(size: int) -> str:
    """Return a spec of so many requests, killed by arguments, that share a resource with another."""
    clauses = "{ uses power 2; fail when x > 5 and active(m.carry); }"
    requests = "".join(f"    request r{number}(x: int in 0 .. 9) {clauses}\n" for number in range(size))
    carry = "    request carry() { uses power 3; }\n"
    return f"spec family;\nmodule m {{\n{requests}{carry}}}\nresource power: {size} by wait;\n"


def coupled(size: int) -> str:
    """Return a spec of `size` modules in a ring, each of 23 bits of state, that wait for and kill each other.

    Every module has a mode, a stock with thresholds, a poster that its neighbour reads, guards that wait and settle,
    and two launches of its own; all share one bus. It is written as people write specs, and has their flaws.
    """
    modules = "".join(_coupled(number, (number + 1) % size) for number in range(size))
    rules = "".join(_coupling(number, (number + 1) % size) for number in range(size))
    return f"spec coupled;\nresource bus: {45 * size} by wait;\n{modules}{rules}"


def _coupled(own: int, near: int) -> str:
    """Return the text of a module that looks at its neighbour."""
    return f"""
resource stock{own}: 3 consumable by reject;
module m{own} {{
    state mode: {{ready, jammed}} = ready;
    poster heat: int in 0 .. 100 = 0;
    request work(pace: int in 1 .. 9) fails (jam) {{
        check free: mode != jammed or pace <= 5;
        wait calm: until m{near}.mode != jammed;
        settle cool: until m{near}.heat <= 60;
        fail smoke: when m{near}.heat > 90 else wait;
        uses bus 30;
        uses bus 25 when pace > 5;
        consumes stock{own} 1;
        consumes stock{own} 2 when pace > 5;
        on ok set mode = ready;
        on failed set mode = jammed;
    }}
    request refill() {{
        wait cold: until heat <= 60;
        uses bus 15;
        produces stock{own} 2;
    }}
    request stop() {{ interrupts m{own}.work, m{own}.refill; on ok set mode = ready; }}
}}
"""


def _coupling(own: int, near: int) -> str:
    """Return the rules between a module and its neighbour."""
    return f"""
mutex hands{own}: m{own}.refill, m{near}.work by wait;
forbid fire{own}: m{own}.heat > 90 and active(m{own}.work, m{near}.refill) by kill m{own}.work, m{near}.refill;
launch cool{own}: m{own}.stop() when m{own}.heat > 90 and running(m{own}.work);
launch fill{own}: m{own}.refill() when level(stock{own}) < 1 and m{own}.mode == ready;
"""
