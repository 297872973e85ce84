"""exover_config.h, which configures the C runtime for all tables in a folder and records what each of them needs."""

import re

from exover.bounds.sizes import Sizes, plain, shape, state_bytes, uses, word_bytes
from exover.dataclass import dataclass
from exover.ocrd.packing import HEADER, pack
from exover.ocrd.tables import Tables

FILE = "exover_config.h"
RECORD = re.compile(
    r"^ \*     (\w+): width (\d), state (\d), uses 0x([0-9a-f]+), plain ([01]),"
    r" tests (\d+), answers (\d+), passes (\d+)$",
    re.MULTILINE | re.ASCII,
)


@dataclass(frozen=True, slots=True)
class Needs:
    """What the tables of a spec need of the configuration of the runtime; `name`: of their files."""

    name: str
    width: int
    state: int
    """Bytes of an entry of the state vector."""
    uses: int
    """Bit i is set iff section i of the tables is not empty; more bits as in `exover.bounds.sizes.uses`."""
    plain: bool
    tests: int
    answers: int
    passes: int

    def record(self) -> str:
        """Return the line of exover_config.h from which `read` restores it."""
        most = f"tests {self.tests}, answers {self.answers}, passes {self.passes}"
        form = f"width {self.width}, state {self.state}, uses 0x{self.uses:07x}, plain {int(self.plain)}"
        return f" *     {self.name}: {form}, {most}"


def needs(tables: Tables, name: str, most: Sizes) -> Needs:
    """Return the needs of these tables."""
    form = word_bytes(tables), state_bytes(tables), uses(tables), plain(tables)
    return Needs(name, *form, most.tests, most.actions, most.passes)


def read(text: str) -> tuple[Needs, ...]:
    """Return the needs that are recorded in the text of a configuration; empty if it has no records."""
    return tuple(
        Needs(name, int(width), int(state), int(used, 16), alike == "1", int(tests), int(answers), int(passes))
        for name, width, state, used, alike, tests, answers, passes in RECORD.findall(text)
    )


def config(tables: Tables, name: str, beside: tuple[Needs, ...], most: Sizes) -> str:
    """Return the text of the configuration for these tables and those `beside`, which must have the same width."""
    own = needs(tables, name, most)
    served = sorted((own, *beside), key=lambda each: each.name)
    assert {each.width for each in served} == {own.width}
    used = 0
    for each in served:
        used |= each.uses
    records = "\n".join(each.record() for each in served)
    return f"""/* How exover.h is configured for the tables beside it. `exover emit` reads here what each of them needs:
{records}
 */
#ifndef EXOVER_CONFIG_H
#define EXOVER_CONFIG_H

#define EXOVER_WIDTH {own.width}
#define EXOVER_STATE {max(each.state for each in served)}
#define EXOVER_USES 0x{used:07x} /* sections of the tables that are not empty */
#define EXOVER_PLAIN {int(all(each.plain for each in served))} /* whether slots count alike, whatever their arguments */

/* What no event exceeds: asserted with EXOVER_DEBUG. */
#define EXOVER_TESTS {max(each.tests for each in served)}
#define EXOVER_ACTIONS {max(each.answers for each in served)}
#define EXOVER_PASSES {max(each.passes for each in served)}
{"" if beside else _only(tables)}
#endif
"""


def _only(tables: Tables) -> str:
    return f"""
/* Only the tables of this shape and checksum are taken; without these lines, all of that width. */
#define EXOVER_SHAPE \\
{_shape(tables)}
"""


def _shape(tables: Tables) -> str:
    _, _, _, _, checksum, *_ = HEADER.unpack_from(pack(tables))
    numbers = (*shape(tables), checksum)
    lines = [", ".join(f"{number}u" for number in numbers[i : i + 12]) for i in range(0, len(numbers), 12)]
    return ", \\\n".join(f"    {line}" for line in lines)
