"""Notes statements that by their form constrain nothing (docs/language.md, section 2)."""

from collections.abc import Collection

from exover.diagnostics import quote
from exover.model.expression import Cond, Past, Status
from exover.model.kleene import truth
from exover.model.wording import counted
from exover.resolve.mistakes import Mistakes
from exover.source import Span

CODE = "E421"
_READ_SOMETHING = "let it read something that changes: an activity, a poster, a state or a parameter"


def fixed(cond: Cond) -> bool | None:
    """Return the truth value that a condition has by its constants alone; None if they do not decide it."""

    def known(part: Cond) -> bool | None:
        match part:
            case Status(_, _, where) | Past(_, where):
                return False if where is not None and fixed(where) is False else None
            case _:
                return None  # a comparison of constants was folded to TRUE or FALSE before

    return truth(cond, known)


def note_fixed(mistakes: Mistakes, cond: Cond, useless: bool, so: str, span: Span) -> None:
    """Note a condition whose constants fix it to `useless`, the value with which its statement constrains nothing."""
    if fixed(cond) is useless:
        mistakes.unless_others(
            CODE, f"this condition is {str(useless).lower()} whatever happens, so {so}", span, _READ_SOMETHING
        )


def note_amount(mistakes: Mistakes, word: str, amount: int, span: Span) -> None:
    """Note an amount of 0."""
    if amount == 0:
        mistakes.unless_others(CODE, f"`{word}` of the amount 0 changes nothing", span, "write an amount of 1 or more")


def note_mutex(mistakes: Mistakes, requests: tuple[str, ...], span: Span) -> None:
    """Note a mutex of a single request."""
    if len(requests) == 1:
        message = f"a mutex of {quote(requests[0])} alone keeps nothing apart"
        mistakes.unless_others(CODE, message, span, "list every request that must not be active together with it")


def note_limit(mistakes: Mistakes, most: int, slots: int, span: Span) -> None:
    """Note a limit that cannot be exceeded: the listed requests have only `slots` <= `most` slots together."""
    if slots <= most:
        message = f"the listed requests have {counted(slots, 'instance')} together, so this limit is always kept"
        hint = f"write a number below {slots}, or list more; a request has one instance unless it says `instances`"
        mistakes.unless_others(CODE, message, span, hint)


def note_context(mistakes: Mistakes, request: str, span: Span) -> None:
    """Note a context without clauses."""
    mistakes.unless_others(CODE, f"this context adds nothing to {quote(request)}", span, "write clauses into its block")


def note_requests(mistakes: Mistakes, spec: str, requests: Collection[str], span: Span) -> None:
    """Note a spec without a request."""
    if not requests:
        message = f"spec {quote(spec)} declares no request, so there is nothing to decide"
        mistakes.unless_others("E422", message, span, "declare one: `module NAME { request NAME(); }`")
