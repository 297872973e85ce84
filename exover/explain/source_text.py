"""The texts of the rules and clauses of a spec, by their locations."""

from collections.abc import Iterator

from exover.model.model import Location
from exover.source import Source, Span
from exover.syntax import tree
from exover.syntax.format import format_clause, format_resource, format_rule
from exover.syntax.includes import gather, parts_of


def written(source: Source) -> dict[Location, str]:
    """Return rules, clauses and resources of a spec without mistakes, a line each, by their locations in the model."""
    spec = gather(source, parts_of(source)).spec
    found = _texts(spec) if spec else iter(())
    return {Location(*source.place(span.start)): text for span, text in found}


def _texts(spec: tree.Spec) -> Iterator[tuple[Span, str]]:
    for item in spec.items:
        match item:
            case tree.Module(members=members):
                for member in members:
                    if isinstance(member, tree.Request):
                        yield from ((clause.span, format_clause(clause)) for clause in member.clauses)
            case tree.Context(clauses=clauses):
                yield from ((clause.span, format_clause(clause)) for clause in clauses)
            case tree.Resource():
                # The model has a renewable one as a rule, at its start; a consumable as a resource, at its name.
                yield item.name.span if item.consumable else item.span, format_resource(item)
            case tree.Mutex() | tree.MutexOver() | tree.Limit() | tree.Forbid() | tree.Launch():
                yield item.span, format_rule(item)
            case _:
                pass
