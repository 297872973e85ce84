"""LTL on explicit moments: is there a fair run that does not satisfy a formula?

The product of the moments with the tableau of the formula (Clarke, Grumberg, Hamaguchi 1994) is searched for a strongly
connected component that meets all constraints (Tarjan 1972). A node of the product is a moment and what is promised
of the next one; the promises at a moment follow from those at the next, so the product is built backwards.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import assert_never

from exover.model.property import (
    Atom,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Next,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
    parts_of,
)
from tests.support.moments import Moments

Node = tuple[int, int]
"""A moment, and the promises as bits."""
Truths = dict[Formula, bool]


@dataclass
class Tableau:
    """The product of moments and promises: `promises` are the formulas that say something of the next moment."""

    truths: dict[Node, Truths]
    promises: list[Formula]
    after: dict[Node, list[Node]]


def holds(of: Moments, formula: Formula) -> bool:
    """Return whether every fair run from the start satisfies a formula of LTL."""
    made = _tableau(of, formula)
    starts = [node for node, truths in made.truths.items() if node[0] == 0 and not truths[formula]]
    constraints = [{node for node in made.truths if node[0] in constraint} for constraint in of.constraints]
    for promise in made.promises:
        if isinstance(promise, Until):
            constraints.append({n for n, truths in made.truths.items() if truths[promise.right] or not truths[promise]})
    for component in _components(starts, made.after):
        lasting = len(component) > 1 or any(node in made.after[node] for node in component)
        if lasting and all(component & constraint for constraint in constraints):
            return False
    return True


def _tableau(of: Moments, formula: Formula) -> Tableau:
    ordered = list(dict.fromkeys(_postorder(formula)))
    promises = [part for part in ordered if isinstance(part, Next | Until)]
    labels = {part: of.true(part) for part in ordered if isinstance(part, Atom | Happened)}
    truths = {
        (moment, bits): _truths(moment, bits, ordered, promises, labels)
        for moment in range(len(of.moments))
        for bits in range(1 << len(promises))
    }
    after: dict[Node, list[Node]] = {node: [] for node in truths}
    for node, true in truths.items():
        kept = sum(
            1 << index
            for index, promise in enumerate(promises)
            if true[promise.part if isinstance(promise, Next) else promise]
        )
        for source in of.before[node[0]]:
            after[source, kept].append(node)
    return Tableau(truths, promises, after)


def _postorder(formula: Formula) -> Iterable[Formula]:
    for part in parts_of(formula):
        yield from _postorder(part)
    yield formula


def _truths(
    moment: int, bits: int, ordered: list[Formula], promises: list[Formula], labels: dict[Formula, set[int]]
) -> Truths:
    """Return what is true at a moment if these promises are kept: f U g is g, or f and the promise of f U g."""
    found: Truths = {}
    for part in ordered:
        match part:
            case Atom() | Happened():
                found[part] = moment in labels[part]
            case Negation(inner):
                found[part] = not found[inner]
            case Conjunction(parts):
                found[part] = all(found[each] for each in parts)
            case Disjunction(parts):
                found[part] = any(found[each] for each in parts)
            case Next():
                found[part] = bool(bits >> promises.index(part) & 1)
            case Until(left, right):
                found[part] = found[right] or (found[left] and bool(bits >> promises.index(part) & 1))
            case SomeNext() | SomeUntil() | SomeAlways():
                raise AssertionError("a formula of LTL has no path quantifier")
            case _:
                assert_never(part)
    return found


def _components(starts: list[Node], after: dict[Node, list[Node]]) -> Iterable[set[Node]]:
    """Yield the strongly connected components of what is reachable."""
    index: dict[Node, int] = {}
    low: dict[Node, int] = {}
    open_nodes: list[Node] = []
    is_open: set[Node] = set()
    for start in starts:
        if start in index:
            continue
        path = [(start, iter(after[start]))]
        index[start] = low[start] = len(index)
        open_nodes.append(start)
        is_open.add(start)
        while path:
            node, rest = path[-1]
            following = next(rest, None)
            if following is None:
                path.pop()
                if path:
                    low[path[-1][0]] = min(low[path[-1][0]], low[node])
                if low[node] == index[node]:
                    component: set[Node] = set()
                    while node not in component:
                        component.add(open_nodes.pop())
                    is_open -= component
                    yield component
            elif following not in index:
                index[following] = low[following] = len(index)
                open_nodes.append(following)
                is_open.add(following)
                path.append((following, iter(after[following])))
            elif following in is_open:
                low[node] = min(low[node], index[following])
