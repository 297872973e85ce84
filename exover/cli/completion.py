"""`exover completion`: print the script that completes commands in a shell."""

import argparse
from collections.abc import Iterable, Iterator, Mapping

import shtab

from exover.checks.questions import SEVERITY
from exover.cli import docs
from exover.cli.arguments import parser
from exover.cli.parsing import Lists
from exover.cli.status import ExitStatus
from exover.cli.streams import out
from exover.manual import pages

PATHS = {
    "DIR": shtab.DIRECTORY,
    **dict.fromkeys(("FILE", "SPEC", "PATH", "TABLE", "FINDING", "REPORT", "BOX"), shtab.FILE),
}
"""By the metavar of an argument, the kind of path that completes it."""
FISH_FILES = " (__fish_complete_path (commandline -ct))"
SPLIT = """
# As `_shtab_exover`, of `--format=json` as of `--format json`: bash splits words at `=`.
_exover() {
  local -a whole=()
  local at=$COMP_CWORD word
  for word in "${!COMP_WORDS[@]}"; do
    if [[ ${COMP_WORDS[word]} == "=" && $word -gt 0 && ${COMP_WORDS[word - 1]} == --* ]]; then
      if [[ $word -eq $COMP_CWORD ]]; then whole+=(""); elif [[ $word -lt $COMP_CWORD ]]; then at=$((at - 1)); fi
    else
      whole+=("${COMP_WORDS[word]}")
    fi
  done
  local -a COMP_WORDS=("${whole[@]}")
  local COMP_CWORD=$at
  _shtab_exover "$@"
}
complete -o bashdefault -F _exover exover
"""
"""The text appended to the script for bash."""


def run(arguments: argparse.Namespace) -> int:
    """Print the script for a shell, made from the parser that reads the arguments."""
    described = parser()
    for verb, action in _actions(described, ""):
        found = _completed(verb, action)
        if found:
            action.complete = found  # type: ignore[attr-defined]  # the attribute that shtab reads
    script = shtab.complete(described, shell=arguments.shell).rstrip()
    out(f"{script}\n{SPLIT if arguments.shell == 'bash' else ''}")
    return ExitStatus.OK


def _completed(verb: str, action: argparse.Action) -> Mapping[str, object] | None:
    """Return the completion of an argument of a verb; None if its choices complete it, or nothing does."""
    match verb, action.dest:
        case _, "only" | "skip" if action.metavar == "CHECK[,…]":
            return _words("checks", (*SEVERITY, *dict.fromkeys(SEVERITY.values())), ",")
        case _, dest if isinstance(action.choices, Lists):
            return _words(dest, action.choices, ",")
        case _, "check" if action.metavar == "CHECK":
            return _words("check", SEVERITY)
        case "docs", "page":
            return _words("page", sorted(docs.pages()))
        case "explain", "spec":
            return _words("pages", pages(), files=True)
        case _:
            return PATHS.get(str(action.metavar))


def _words(name: str, words: Iterable[str], between: str = "", files: bool = False) -> Mapping[str, object]:
    """Return the completion by one of these words; `between`: by a list of them; `files`: or by a file."""
    listed = " ".join(words)
    head, last = ('"${1%"${1##*,}"}"', '"${1##*,}"') if between else ('""', '"$1"')
    lines = [f"_exover_{name}() {{", f'  compgen -P {head} -W "{listed}" -- {last}']
    lines += ['  compgen -f -- "$1"'] if files else []
    several = f"(__fish_complete_list , 'printf %s\\\\n {listed}')"
    return {
        "bash": f"_exover_{name}",
        "zsh": "_files" if files else f"_values -s , {name} {listed}" if between else f"({listed})",
        "fish": f"{several if between else listed}{FISH_FILES if files else ''}",
        "preamble": {"bash": "\n".join([*lines, "}"])},
    }


def _actions(described: argparse.ArgumentParser, verb: str) -> Iterator[tuple[str, argparse.Action]]:
    """Yield the arguments of a parser and of its verbs, each with its verb."""
    for action in described._actions:
        yield verb, action
        if isinstance(action, argparse._SubParsersAction):
            for name, each in action.choices.items():
                yield from _actions(each, name)
