"""Whether the tables of a binding agree with each other and with the launch rules of the spec (docs/binding.md)."""

from collections.abc import Set
from math import isinf
from typing import Any

from exover.dataclass import dataclass
from exover.diagnostics import quote
from exover.gate.binding import Binding, RequestBinding, matches
from exover.gate.fields import FieldPath, Missing, same
from exover.model.index import ModelIndex
from exover.model.model import Model
from exover.model.wording import value_text
from exover.toml_schema import MistakeList


def note_inconsistencies(
    model: Model, binding: Binding, requests: Set[str], posters: Set[str], mistakes: MistakeList
) -> None:
    """Note what no table of a binding shows by itself.

    `requests`, `posters`: of what the file has tables, with mistakes or without; nothing is said to be missing that
    has one.
    """
    asked = _Consistency(model, binding, mistakes)
    asked.ambiguous()
    asked.launchable(requests)
    asked.makeable()
    asked.writable()
    asked.unread(posters)
    asked.passed()


@dataclass(frozen=True)
class _Consistency:
    """A binding of a model, and the list of its mistakes."""

    model: Model
    binding: Binding
    mistakes: MistakeList

    def ambiguous(self) -> None:
        """Note requests that no call can mean, since each call that meets their `when` meets an earlier one too."""
        for number, later in enumerate(self.binding.requests):
            for earlier in self.binding.requests[:number]:
                alike = (earlier.kind, earlier.outer) == (later.kind, later.outer) and later.outer
                if alike and all(_demands(later, path, value) for path, value in earlier.when):
                    message = f"{quote(later.request)} is never meant: {quote(earlier.request)} is, by the same calls"
                    advice = "tell them apart by `when`, the one with more conditions first"
                    self.mistakes.say("E705", message, ("request", later.request), advice)
                    break

    def launchable(self, named: Set[str]) -> None:
        """Note launch rules that require a request which is not bound."""
        bound = {each.request for each in self.binding.requests} | named
        for launch in self.model.launches:
            if launch.request not in bound:
                message = f"the launch rule {quote(launch.name)} requires {quote(launch.request)}, which is not bound"
                self.mistakes.say("E706", message, ("request",), f'write [request."{launch.request}"]')

    def makeable(self) -> None:
        """Note requests of launch rules whose calls the gate cannot make, since two paths of them clash."""
        launched = {launch.request for launch in self.model.launches}
        for bound in self.binding.requests:
            clash = bound.clash if bound.request in launched else None
            if clash:
                first, second = (quote(".".join(path)) for path in clash)
                message = f"a launch rule requires {quote(bound.request)}, whose call cannot have {first} and {second}"
                advice = "let no argument, condition of `when` or constant stand at, or within, another"
                self.mistakes.say("E706", message, ("request", bound.request), advice)
            gap = bound.gap if bound.request in launched and bound.kind == "tool" else None
            if gap:
                whole = f"the whole list {quote('.'.join(gap))}"
                message = f"a launch rule requires {quote(bound.request)}, whose call has not {whole}"
                advice = "give each of its elements, 0, 1 and so on, by an argument or a constant"
                self.mistakes.say("E706", message, ("request", bound.request), advice)

    def writable(self) -> None:
        """Note arguments of launch rules that have no outer value, or become infinite when they are scaled back."""
        of = {each.request: each for each in self.binding.requests}
        for launch in self.model.launches:
            fields = of[launch.request].arguments if launch.request in of else ()
            for field, value in zip(fields, launch.args, strict=False):
                outer = field.write(value)
                infinite = isinstance(outer, float) and isinf(outer)
                if infinite or isinstance(outer, Missing):
                    given = f"{quote(launch.name)} requires {quote(field.name)} = {value_text(value)}"
                    why = (
                        "no number stands for in a call, scaled back" if infinite else "none of its `values` stands for"
                    )
                    path = ("request", launch.request, "arguments", field.name)
                    self.mistakes.say("E706", f"{given}, which {why}", path)

    def unread(self, named: Set[str]) -> None:
        """Note posters that nothing reads."""
        read = {each.poster for each in self.binding.posters} | named
        for _, variable in ModelIndex(self.model).posters:
            if variable.name not in read:
                message = f"nothing reads {quote(variable.name)}: it stays {value_text(variable.initial)}"
                self.mistakes.say("E708", message, ("poster",), f'write [poster."{variable.name}"]', "warning")

    def passed(self) -> None:
        """Note patterns of `pass` that would let clients call tools that only the gate may call."""
        for number, pattern in enumerate(self.binding.gate.passed):
            for tool in sorted(self.binding.below):
                if matches(tool, pattern):
                    message = f"{quote(pattern)} passes {quote(tool)}, by which the gate carries out or stops a request"
                    advice = "name the tools that command nothing, or bind this one to a request"
                    self.mistakes.say("E706", message, ("gate", "pass", number), advice)


def _demands(bound: RequestBinding, path: FieldPath, value: Any) -> bool:
    """Return whether `when` of a request wants this value at a path."""
    return any(each == path and same(wanted, value) for each, wanted in bound.when)
