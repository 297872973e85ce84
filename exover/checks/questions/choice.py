"""The selection of checks by name and severity."""

from collections.abc import Iterable, Iterator, Mapping

from exover.checks.finding import SEVERITIES
from exover.dataclass import dataclass
from exover.diagnostics import Severity, did_you_mean, quote


@dataclass(frozen=True, slots=True)
class CheckSelection:
    """The checks named in `only` (all if empty) without those named in `skip`; with `errors_only`, of severity `error`.

    The name of a severity stands for all checks of it.
    """

    only: tuple[str, ...] = ()
    skip: tuple[str, ...] = ()
    errors_only: bool = False


ALL = CheckSelection()
ERRORS = CheckSelection(errors_only=True)


def asked(choice: CheckSelection, checks: Mapping[str, Severity]) -> tuple[str, ...]:
    """Return the names of the chosen checks among these, in their order."""
    return tuple(name for name, severity in checks.items() if _chosen(choice, name, severity))


def _chosen(choice: CheckSelection, name: str, severity: Severity) -> bool:
    names = {name, severity}
    wanted = not choice.only or not names.isdisjoint(choice.only)
    return wanted and names.isdisjoint(choice.skip) and not (choice.errors_only and severity != "error")


def unknown(names: Iterable[str], checks: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield for each name that is of no check and no severity a message and a hint."""
    known = (*checks, *SEVERITIES)
    for name in names:
        if name not in known:
            yield f"there is no check {quote(name)}", did_you_mean(name, known) or f"there are {', '.join(known)}"
