"""A parser of arguments that suggests what was meant, with the usage of the verb that was called."""

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, TypeAlias

from exover.cli.streams import out
from exover.cli.values import text


class Lists(tuple[str, ...]):
    """Words; a value may be one of them or a list of them, separated by commas."""

    def __contains__(self, value: object) -> bool:
        """Return whether each part of the value is one of the words."""
        return isinstance(value, str) and set(value.split(",")) <= set(self)


Verbs: TypeAlias = "argparse._SubParsersAction[Parser]"
"""The verbs of a parser, each with a parser of its own."""


class Parser(argparse.ArgumentParser):
    """As `argparse` has it, but the parser of a verb refuses what it does not know instead of handing it back."""

    events: str | None = None
    """The option that names the events, for what a word most likely is that no argument takes."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**{"allow_abbrev": False, **options})
        self.register("type", None, text)

    def add_subparsers(self, **options: Any) -> Any:
        """Add verbs, whose parsers read the values of the arguments behind them."""
        self.register("type", None, str)
        return super().add_subparsers(**options)

    def parse_known_args(  # type: ignore[override]  # its overloads are about the type of the namespace
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Return the arguments, none of them unknown; unknown options are reported before missing arguments."""
        args = sys.argv[1:] if args is None else args
        self._refuse(self._unknown(args))
        found, unknown = super().parse_known_args(args, namespace)
        self._refuse(unknown)
        return found, unknown

    def _unknown(self, args: Iterable[str]) -> Iterator[str]:
        """Yield the long options that this parser does not know, up to a verb, whose parser reads the rest."""
        for word in args:
            if word == "--" or (self._subparsers and not word.startswith("-")):
                return
            if word.startswith("--") and word.partition("=")[0] not in self._option_string_actions:
                yield word

    def _refuse(self, unknown: Iterable[str]) -> None:
        words = list(unknown)
        if words:
            advice = next(filter(None, (self._advice(word) for word in words)), "")
            self.error(f"unrecognized arguments: {' '.join(words)}{advice}")

    def _advice(self, word: str) -> str:
        if not word.startswith("-"):
            return self._place(word)
        return _meant(word.partition("=")[0], self._option_string_actions)

    def _place(self, word: str) -> str:
        """Return where a word that no argument takes belongs, as the end of a message; empty if that is not known."""
        if self.events:
            return f"; did you mean `{self.events} {word}`?"
        several = next((each for each in self._get_positional_actions() if each.nargs in ("+", "*")), None)
        return f"; write all of {several.metavar} together, with no option between them" if several else ""

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print help and version by `out`: argparse would ignore a failure to write."""
        if file is sys.stdout:
            out(message)
        else:
            super()._print_message(message, file)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            known = [str(choice) for choice in action.choices or ()]
            wrong = next((word for word in str(value).split(",") if word not in known), str(value))
            error.message = error.message.replace(repr(value), repr(wrong), 1) + _meant(wrong, known)
            raise


def _meant(word: str, known: Iterable[str]) -> str:
    """Return a suggestion of the nearest known word, as the end of a message; empty if none is near."""
    from exover.diagnostics import did_you_mean

    advice = did_you_mean(word, known)
    return f"; {advice}" if advice else ""
