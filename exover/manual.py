"""The pages of checks and error codes, read from docs/: the only source for `exover explain` and for reports."""

from functools import cache
from pathlib import Path

from exover.dataclass import dataclass

FILES = ("findings.md", "errors.md")
"""The files with the pages, in docs/, which is installed with the package."""
_FOLDER = Path(__file__).with_name("docs")
_MEND = "**How to mend it:** "


@dataclass(frozen=True, slots=True)
class Page:
    """The page of a check or a code: `text` is the Markdown below the heading, `file` the file that holds it."""

    name: str
    title: str
    text: str
    file: str

    @property
    def iff(self) -> str:
        """The condition on the page of a check after "Holds iff", or after "not `ok` iff"; "" for a code."""
        return self._after("**Holds iff** ") or self._after("A finding is not `ok` iff ")

    @property
    def severity(self) -> str:
        """The severity of this check: error, warning or note; "" for a code."""
        first, comma, _ = self.text.partition(",")
        return first.partition(" ")[2] if comma and self.iff else ""

    @property
    def mend(self) -> str:
        """How to mend it, as a clause without a full stop; "" if the page does not say."""
        return self._after(_MEND)

    @property
    def markdown(self) -> str:
        """The page with its heading."""
        return f"## {self.name}{f': {self.title}' if self.title else ''}\n\n{self.text}\n"

    @property
    def uri(self) -> str:
        """A permanent name for the page."""
        return f"exover:explain/{self.name}"

    def _after(self, mark: str) -> str:
        _, found, rest = self.text.partition(mark)
        return rest.partition("\n")[0].removesuffix(".") if found else ""


@cache
def pages() -> dict[str, Page]:
    """Return all pages by name, checks first, each in the order of its file."""
    return {page.name: page for file in FILES for page in _read(file)}


def page(name: str) -> Page | None:
    """Return the page of a check or of a code, which may be in lower case; None if there is none."""
    return pages().get(name) or pages().get(name.upper())


def mend(code: str) -> str:
    """Return how to mend the mistake of a code, "" if the code has no page."""
    found = page(code)
    return found.mend if found else ""


def _read(file: str) -> list[Page]:
    """Return the pages of a file, one for each heading; none if the file is not installed."""
    if not (_FOLDER / file).is_file():
        return []
    _, *parts = (_FOLDER / file).read_text("utf-8").split("\n## ")
    found = []
    for part in parts:
        heading, _, text = part.partition("\n")
        name, _, title = heading.partition(": ")
        found.append(Page(name, title, text.strip(), file))
    return found
