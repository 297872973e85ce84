"""The parts of programs that change readings of posters, levels and latches."""

from collections.abc import Iterable

from exover.loop.finite.observers import Observers
from exover.loop.finite.program import Assign, Choose, Op, Program, Switch, Walk
from exover.loop.finite.real_orders import feasible
from exover.loop.finite.variables import VariableKey
from exover.model.event import Observe
from exover.model.index import ModelIndex
from exover.model.types import Value
from exover.ocrd.tables import LatchRow


class Observations(Observers):
    """The parts of programs that change readings."""

    def observations(self, latched: Program) -> Iterable[tuple[Observe, Program]]:
        """Yield an observation for each class of values of each poster and consumable, with its program.

        The program is the update followed by `latched`.
        """
        index = ModelIndex(self.model)
        for number, variable in index.posters:
            for cell, value in enumerate(self.samples.get(number, [variable.initial])):
                update: Program = ()
                if number in self.samples:
                    update = (Assign(self.index["reading", number], cell), *self._compare(number, cell))
                yield Observe(variable.name, value), update + latched
        for number, resource in enumerate(index.consumables):
            var = self.index.get(("level", number))
            for level in range(resource.capacity + 1) if var is not None else [resource.initial]:
                update = () if var is None else (Assign(var, level),)
                yield Observe(resource.name, level), update + latched

    def _compare(self, poster: int, cell: int) -> Iterable[Op]:
        """Yield the updates of all comparisons with a real poster whose new value is in this cell."""
        for key, var in self.index.items():
            if key[0] == "pair" and poster in key[1:]:
                left, right = int(str(key[1])), int(str(key[2]))
                other = right if left == poster else left
                mine, others = self.posters[poster].samples[cell], self.posters[other].samples
                pairs = [(mine, its) if left == poster else (its, mine) for its in others]
                cases = [feasible(self.posters[left], self.posters[right], *pair) for pair in pairs]
                yield Switch(self.index["reading", other], tuple((Choose(var, case),) for case in cases))
        for request, (row, arguments) in enumerate(zip(self.tables.requests, self.arguments, strict=True)):
            for which, order in enumerate(arguments.poster_orders):
                if order.right != -1 - poster:
                    continue
                for slot in range(row.slots, row.slots + row.instances):
                    if ("order", slot, which) in self.index:
                        held = [kind.args[order.left] for kind in arguments.classes]
                        yield self._anew(("phase", slot), ("class", slot), ("order", slot, which), request, held, cell)
                if ("standing", request, which) in self.index:
                    held = [each.args[order.left] for each in arguments.cells]
                    standing = ("standing", request, which)
                    yield self._anew(("place", request), ("cell", request), standing, request, held, cell)

    def _anew(
        self, owner: VariableKey, kind: VariableKey, order: VariableKey, request: int, held: list[Value], cell: int
    ) -> Op:
        which = int(str(order[2]))
        chosen: list[Program] = [
            (Choose(self.index[order], self.orders[request].feasible(which, float(value), cell)),) for value in held
        ]
        taken = (Switch(self.index[kind], tuple(chosen)),) if kind in self.index else chosen[0]
        return Switch(self.index[owner], ((), taken, taken))

    def latch(self, row: LatchRow, clears: bool) -> Program:
        """Return what sets a latch where its condition holds, and elsewhere clears it if it `clears`."""
        if row.variable not in self.samples:
            return ()
        var = self.index["reading", row.variable]
        on = tuple((number, (Assign(var, 1),)) for number, _ in self._actions(row.condition))
        return (Walk(row.condition, (), on, (Assign(var, 0),) if clears else ()),)
