"""The closed loop and what the checks claim of it as SMV text, for NuSMV and nuXmv (docs/engines.md)."""

from collections.abc import Sequence
from itertools import compress
from operator import not_

from exover.emit.artefact import Artefact
from exover.emit.describe import Description
from exover.engines.aig.passes import enough_passes
from exover.engines.smv.specs import is_of
from exover.engines.smv.text import Text, looped
from exover.loop.claim import Claim, believed
from exover.model.property import Properties
from exover.ocrd.compile import Compiled


def emit(compiled: Compiled, properties: Properties, claims: Sequence[Claim]) -> tuple[Artefact, ...]:
    """Return `NAME.smv` and, if there are claims for which it matters which runs are fair, `NAME.fair.smv`.

    Claims that are true of a loop with too many runs, and need not be, are named and not asked.
    Raises `TooLarge` if the loop distinguishes too many values to be written.
    """
    name = compiled.model.name
    words = Description(compiled.model, compiled.tables)
    nodes = [words.test(node) if node.code >= 0 else words.action(node) for node in compiled.tables.nodes]
    enough = enough_passes(compiled, properties)
    found = []
    for fair, file in ((False, f"{name}.smv"), (True, f"{name}.fair.smv")):
        mine = tuple(claim for claim in claims if claim.formula and is_of(claim, properties, fair))
        if mine or not fair:
            loop = looped(compiled, properties, mine)
            shown = [not loop.approximate or believed(each, "holds", shown=False) for each in mine]
            asked, unasked = tuple(compress(mine, shown)), tuple(compress(mine, map(not_, shown)))
            text = Text(loop, asked, fair, nodes, enough, unasked)
            found.append(Artefact(file, text.render().encode()))
    return tuple(found)
