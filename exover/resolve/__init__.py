"""From the tree of a spec to its model: resolves names, types and shorthand (docs/language.md sections 2 and 4)."""

from typing import assert_never

from exover.diagnostics import Diagnostic, quote
from exover.model.model import Model, Parameter, Request, Variable
from exover.model.types import Type
from exover.resolve.clauses import add_clauses
from exover.resolve.conditions import defines
from exover.resolve.declare import declare
from exover.resolve.draft import Draft, Parts
from exover.resolve.idle import note_context, note_requests
from exover.resolve.mistakes import Mistakes
from exover.resolve.names import QuantityName, Signature, find_request
from exover.resolve.rules import add_forbid, add_latch, add_launch, add_limit, add_mutex, add_over, add_resource
from exover.resolve.values import value
from exover.resolve.vocabulary import vocabulary
from exover.source import Source
from exover.syntax import tree

MAX_INSTANCES = 65_535
"""The most slots of one request."""


def resolve(spec: tree.Spec, source: Source) -> tuple[Model | None, tuple[Diagnostic, ...]]:
    """Return the model and all mistakes in the order of the text; the model is None iff there is a mistake."""
    mistakes = Mistakes(source)
    names = declare(spec, mistakes)
    parts = {name: Parts() for name in names.requests}
    draft = Draft(names, defines(names, mistakes), mistakes, parts)
    variables: list[Variable] = []
    for item in spec.items:
        if isinstance(item, tree.Poster):
            _add_variable(draft, names.quantities.get(item.name.text), item, variables)
        elif isinstance(item, tree.Module):
            _add_module(draft, item, variables)
        else:
            _add_item(draft, item)
    draft.check_kills()
    draft.check_totals()
    note_requests(mistakes, spec.name.text, names.requests, spec.name.span)
    requests = tuple(_request(draft, signature) for signature in names.requests.values())
    found = mistakes.in_order()
    if found:
        return None, found
    rules, launches = tuple(draft.rules), tuple(draft.launches)
    latches, resources = tuple(draft.latches), tuple(draft.resources)
    words = vocabulary(names, draft.meanings)
    return Model(spec.name.text, requests, tuple(variables), latches, resources, rules, launches, words), ()


def _add_item(draft: Draft, item: tree.Item) -> None:
    match item:
        case tree.Latch():
            add_latch(draft, item)
        case tree.Resource():
            add_resource(draft, item)
        case tree.Context(ref, clauses):
            request = find_request(draft.names, ref, draft.mistakes)
            if request:
                add_clauses(draft, request, clauses)
            if request and not clauses:
                note_context(draft.mistakes, request.name, ref.span)
        case tree.Mutex():
            add_mutex(draft, item)
        case tree.MutexOver():
            add_over(draft, item)
        case tree.Limit():
            add_limit(draft, item)
        case tree.Forbid():
            add_forbid(draft, item)
        case tree.Launch():
            add_launch(draft, item)
        case tree.Enum() | tree.Const() | tree.Define() | tree.Group() | tree.Module() | tree.Poster():
            pass  # these declare names, which `declare` has read
        case tree.Include():
            pass  # `gather` has put the items of that file here
        case _:
            assert_never(item)


def _add_module(draft: Draft, node: tree.Module, variables: list[Variable]) -> None:
    known = draft.names.modules[node.name.text]
    for member in node.members:
        if isinstance(member, tree.Request):
            signature = known.requests[member.name.text]
            if (
                draft.names.nodes[signature.name] is member
            ):  # a second request of the name is a mistake, noted by `declare`, and ignored
                add_clauses(draft, signature, member.clauses)
        else:
            _add_variable(draft, known.quantities[member.name.text], member, variables)


def _add_variable(
    draft: Draft, quantity: QuantityName | None, node: tree.Poster | tree.State, variables: list[Variable]
) -> None:
    """Add a poster or state with its values; a second one of a name, a mistake that `declare` notes, is ignored."""
    if quantity is None or quantity.span != node.name.span:
        return
    kind = quantity.type
    constants, mistakes = draft.names.constants, draft.mistakes
    initial = value(node.initial, kind, constants, mistakes)
    fallback = None
    if isinstance(node, tree.Poster) and node.otherwise is not None:
        fallback = value(node.otherwise, kind, constants, mistakes)
    if kind is None or initial is None:
        return
    is_poster = isinstance(node, tree.Poster)
    where = draft.where(node.name.span)
    variables.append(Variable(quantity.name, "poster" if is_poster else "state", kind, initial, fallback, where))


def _request(draft: Draft, signature: Signature) -> Request:
    """Return the request with all its clauses, those of contexts included."""
    node, parts = draft.names.nodes[signature.name], draft.parts[signature.name]
    return Request(
        signature.name,
        _parameters(signature.params),
        _parameters(signature.results),
        tuple(status.text for status in node.statuses),
        _instances(draft, node),
        parts.interrupts_self,
        tuple(parts.guards),
        tuple(parts.shares),
        tuple(parts.consumptions),
        tuple(parts.productions),
        parts.on("launch"),
        parts.on("ok"),
        parts.on("failed"),
        parts.on("interrupted"),
        draft.where(node.name.span),
    )


def _parameters(types: dict[str, Type | None]) -> tuple[Parameter, ...]:
    return tuple(Parameter(name, kind) for name, kind in types.items() if kind)


def _instances(draft: Draft, node: tree.Request) -> int:
    if node.instances is None:
        return 1
    number = int(node.instances.text)
    if number < 1:
        draft.mistakes.add("E408", f"instances are at least 1, not {quote(node.instances.text)}", node.instances.span)
    if number > MAX_INSTANCES:
        message = f"instances are at most {MAX_INSTANCES}, not {quote(node.instances.text)}"
        draft.mistakes.add("E416", message, node.instances.span)
    return number
