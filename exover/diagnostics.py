"""Diagnostics, the mistakes in a text, as values, and one renderer for them.

Nothing here prints. Wording: lower case, no full stop, the user's own text in backticks, advice apart in ``help``.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from difflib import SequenceMatcher, get_close_matches
from typing import Literal

from exover.dataclass import dataclass
from exover.escaping import visible
from exover.manual import mend, page
from exover.source import TAB_WIDTH, Source, Span

Severity = Literal["error", "warning", "note"]

CODES: dict[str, str] = {
    # E0xx: files
    "E001": "a file cannot be read",
    "E002": "a file is not UTF-8 text",
    "E003": "a file is too large",
    "E004": "a file holds no spec",
    "E005": "an included file cannot be read",
    "E006": "what is included is no part",
    "E007": "files include each other in a circle, or too deep",
    "E008": "the path of an include is none",
    "E009": "a part stands where a spec is needed",
    # E1xx: syntax
    "E101": "characters that are no part of the language",
    "E102": "a string without an end",
    "E103": "a comment without an end",
    "E104": "an unknown escape in a string",
    "E105": "a malformed number",
    "E106": "something else is expected here",
    "E107": "a `;` is missing",
    "E108": "a bracket is not closed",
    "E109": "brackets or operators are nested too deep",
    "E110": "a reserved word is used as a name",
    "E111": "`all` is used as the name of a group",
    "E199": "more mistakes than are shown",
    # E2xx: names
    "E201": "unknown name",
    "E202": "unknown module",
    "E203": "unknown request",
    "E204": "unknown group",
    "E205": "unknown resource",
    "E206": "unknown type",
    "E207": "unknown poster or state",
    "E208": "unknown parameter or result",
    "E209": "unknown enum value",
    "E210": "a name is declared twice in one scope",
    "E211": "two rules have one name",
    "E212": "a rule has a name that answers use themselves (busy, superseded, aborted, abort)",
    "E213": "a parameter and a result of one request have one name",
    "E214": "defines, groups or consts in a circle",
    "E215": "`self` stands where there is no request of the clause",
    "E216": "a poster, state or latch is read inside `with`",
    "E217": "a parameter is read where none can be",
    "E218": "an enum value stands opposite something that is not of its enum",
    "E219": "a name of another kind than is needed here",
    # E3xx: types
    "E301": "the two sides of a comparison differ in type",
    "E302": "arithmetic or comparison of reals that cannot be decided exactly",
    "E303": "an order or a sum of values that have none (bools, enum values)",
    "E304": "a condition is needed and this is none",
    "E305": "`self.p` inside `with` has too large a type",
    "E306": "an empty range",
    "E307": "a value is out of range",
    "E308": "a value is of the wrong type",
    "E309": "a product of two variables",
    "E310": "integers do not fit 64 bits",
    "E311": "the wrong number of arguments",
    "E312": "a type that cannot stand here",
    "E313": "a real poster is compared outside guards and `fail when`",
    # E4xx: restrictions
    "E401": "a rule reads what its remedies change (running, stopping, waiting, last)",
    "E402": "a latch reads more than posters, levels and earlier latches",
    "E403": "the condition of uses, consumes or produces reads more than parameters",
    "E404": "a kill remedy names a request that its rule does not read",
    "E405": "`uses` and `used` need a renewable resource",
    "E406": "`consumes`, `produces` and `level` need a consumable resource",
    "E407": "a consumable resource has no remedy but reject and wait",
    "E408": "a number is too small (instances are at least 1)",
    "E409": "a request stands twice in one list",
    "E410": "a rule pairs a request with itself",
    "E411": "`interrupts` itself is written `self`",
    "E412": "a define reads parameters",
    "E413": "a list of requests is empty",
    "E414": "a condition or a rule is too large once its defines and lists are expanded",
    "E415": "a predicate stands inside `with`",
    "E416": "a number is larger than the toolkit takes (instances are at most 65535)",
    "E417": "a step predicate (asked, launched, rejected, killed, ended) stands in a spec",
    "E418": "a temporal operator stands in a formula of the other logic",
    "E419": "a properties file is for another spec",
    "E420": "an assumption stands twice",
    "E421": "a rule or clause can constrain nothing",
    "E422": "a spec declares no request",
    # E6xx: configuration
    "E601": "a configuration is not TOML",
    "E602": "an unknown key in a configuration",
    "E603": "a value of the wrong type in a configuration",
    "E604": "a waiver lacks a key",
    "E605": "a configuration names an unknown check",
    "E606": "a waiver of an error that cannot be waived",
    # E7xx: bindings
    "E701": "a binding names what the spec has not",
    "E702": "a binding lacks a key",
    "E703": "a binding is for another spec",
    "E704": "a binding names a watch that it has not",
    "E705": "two bindings of one name cannot be told apart",
    "E706": "something cannot be bound so",
    "E707": "what is cancelled is never known to have ended",
    "E708": "a poster is read nowhere",
}
"""The meaning of every code in one line; the codes of one hundred belong to one stage."""

MAX_REPORTS = 50
"""The most mistakes that are shown of one text."""
LINE_WIDTH = 120
"""The most characters of a source line that are shown; a longer line is cut around the span."""
QUOTE_WIDTH = 60
"""The most characters of the user's text that a message quotes."""
MAX_CANDIDATES = 2000
MAX_NAME = 64
NEAR, ALIKE = 0.6, 0.5
"""The least similarity (Ratcliff, Metzener 1988) of two names, and of each part of them, for one to be suggested."""


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One mistake of the user: ``code`` is a key of CODES, ``span`` the place, if there is one."""

    code: str
    message: str
    span: Span | None
    label: str = ""
    help: str = ""
    severity: Severity = "error"

    @property
    def advice(self) -> str:
        """What to do next: the help, or else the advice on the page of the code."""
        return self.help or mend(self.code)


def capped(reports: Sequence[Diagnostic], gave_up: bool = False) -> tuple[Diagnostic, ...]:
    """Return the first MAX_REPORTS of these and one that counts the others; with `gave_up` there may be more."""
    rest = len(reports) - MAX_REPORTS
    if rest <= 0:
        return tuple(reports)
    count = f"at least {rest}" if gave_up else str(rest)
    more = Diagnostic("E199", f"{count} more mistake{'s' if rest > 1 else ''} not shown", reports[MAX_REPORTS].span)
    return (*reports[:MAX_REPORTS], more)


def render(diagnostic: Diagnostic, source: Source) -> str:
    """Return the diagnostic as text of several lines, without a newline at the end.

    Control characters of the source are shown as U+FFFD, so that a binary file cannot control a terminal.
    """
    lines = [f"{diagnostic.severity}[{diagnostic.code}]: {diagnostic.message}"]
    if diagnostic.span is None:
        lines.append(f"  --> {_shown(source.name)}")
        gutter = ""
    else:
        file, line, column = source.place(diagnostic.span.start)
        gutter = " " * len(str(line))
        shown, mark = _excerpt(source, diagnostic.span)
        lines.append(f"{gutter} --> {_shown(file)}:{line}:{column}")
        lines.append(f"{gutter} |")
        lines.append(f"{line} | {shown}".rstrip())
        lines.append(f"{gutter} | {mark} {diagnostic.label}".rstrip())
    if diagnostic.help:
        lines.append(f"{gutter or ' '} = help: {diagnostic.help}")
    return "\n".join(lines)


def render_all(diagnostics: Iterable[Diagnostic], source: Source) -> str:
    """Return the diagnostics, errors first, each with its advice, and last a line on where to read more."""
    found = [replace(diagnostic, help=diagnostic.advice) for diagnostic in diagnostics]
    errors_first = sorted(found, key=lambda each: each.severity != "error")
    codes = dict.fromkeys(diagnostic.code for diagnostic in errors_first if page(diagnostic.code))
    more = [f"`exover explain {next(iter(codes))}` tells more"] if codes else []
    return "\n\n".join([*(render(diagnostic, source) for diagnostic in found), *more])


def _excerpt(source: Source, span: Span) -> tuple[str, str]:
    """Return the line as shown and the marks below it; a span of several lines is marked to the end of its first."""
    whole = source.line_span(span.start)
    start = min(span.start, whole.end)
    end = max(min(span.end, whole.end), start)
    left, right = whole.start, whole.end
    if right - left > LINE_WIDTH:
        left = max(left, start - LINE_WIDTH // 3)
        right = min(right, left + LINE_WIDTH)
    before = _shown(source.slice(Span(left, start)))
    inside = _shown(source.slice(Span(start, min(end, right))))
    after = _shown(source.slice(Span(min(end, right), right)))
    opening = "… " if left > whole.start else ""
    closing = " …" if right < whole.end else ""
    mark = " " * len(opening + before) + "^" * max(len(inside), 1)
    return opening + before + inside + after + closing, mark


def _shown(text: str) -> str:
    """Return a part of a line as it is shown, `visible` and with blanks for tabs."""
    return visible(text.replace("\t", " " * TAB_WIDTH))


def quote(text: str) -> str:
    """Return the user's ``text`` in backticks, on one line, cut to QUOTE_WIDTH characters."""
    cut = text if len(text) <= QUOTE_WIDTH else text[: QUOTE_WIDTH - 1] + "…"
    return f"`{_shown(cut)}`"


def did_you_mean(name: str, candidates: Iterable[str]) -> str:
    """Return "did you mean `x`?" for the candidate x nearest to ``name``, or "" if none is near.

    At most MAX_CANDIDATES names of at most MAX_NAME characters are compared, those of similar length first. Of equally
    near ones the last in alphabetical order is taken, so the order of the candidates does not matter. Both parts of
    `module.name` have to be near, since an equal module alone makes two names look similar.
    """
    if len(name) > MAX_NAME:
        return ""
    near = {candidate for candidate in candidates if candidate != name and len(candidate) <= MAX_NAME}
    ordered = sorted(near, key=lambda candidate: (abs(len(candidate) - len(name)), candidate))[:MAX_CANDIDATES]
    folded = name.lower()
    for candidate in ordered:
        if candidate.lower() == folded:
            return f"did you mean {quote(candidate)}?"
    close = get_close_matches(name, ordered, n=len(ordered) or 1, cutoff=NEAR)
    found = [candidate for candidate in close if _near_by_part(name, candidate)]
    return f"did you mean {quote(found[0])}?" if found else ""


def _near_by_part(name: str, candidate: str) -> bool:
    parts, others = name.split("."), candidate.split(".")
    if len(parts) != len(others):
        return True
    pairs = zip(parts, others, strict=True)
    return all(SequenceMatcher(None, other, part).ratio() >= ALIKE for part, other in pairs)
