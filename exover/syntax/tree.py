"""The syntax tree: one class for each rule of the grammar (docs/language.md sections 2 and 8), no meaning attached.

Every node has a ``span``, which equality ignores. Numbers keep the text they were written with, so that nothing of
a literal is lost before its type is known. Parentheses leave no node; the shape of the tree says where they stood.
Lists of operands are flat (``a or b or c`` is one Or of three), so depth grows with brackets, `not` and `implies`
alone, and the parser bounds it.

One vocabulary in three files, because it is long; this module is the name to import it from.
"""

from exover.syntax.conditions import *  # noqa: F403
from exover.syntax.items import *  # noqa: F403
from exover.syntax.properties import *  # noqa: F403
