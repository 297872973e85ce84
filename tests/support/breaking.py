"""Texts broken at random: words left out, doubled, exchanged, cut off."""

import re
from random import Random

_WORD = re.compile(r"\w+|\s+|[^\w\s]")
ODD = ("", "\0", "{", "}", ";", "(", ")", "::", '"', "é", "[", "<", "=", "9" * 30, "#", "/*", "'", "in", "all", "-")


def broken(text: str, seed: int) -> str:
    """Return a text with a few faults, the same for the same seed."""
    random = Random(seed)
    words = _WORD.findall(text)
    for _ in range(random.randint(1, 4)):
        place = random.randrange(len(words))
        match random.randrange(4):
            case 0:
                words[place] = random.choice(ODD)
            case 1:
                del words[place : place + random.randint(1, 4)]
            case 2:
                words[place] = random.choice(words)
            case _:
                words.insert(place, random.choice((*ODD, *words)))
    if seed % 10 == 0:
        words = words[: random.randrange(len(words))]
    return "".join(words)
