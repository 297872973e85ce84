"""The abstract syntax tree: one class for each rule of the grammar (docs/language.md sections 2 and 8).

Every node has a ``span``, which equality ignores. Numbers keep the text of the literal, so that nothing is lost before
the type is known. Parentheses make no node; the shape of the tree shows them. Lists of operands are flat
(``a or b or c`` is one Or of three), so only brackets, `not`, `implies` and temporal operators add depth, which the
parser bounds.

The classes are in three files, because they are many; import them from this module.
"""

from exover.syntax.conditions import *  # noqa: F403
from exover.syntax.items import *  # noqa: F403
from exover.syntax.properties import *  # noqa: F403
