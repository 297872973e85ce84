"""The names of a spec in Rust: enums of requests, posters, stocks and reasons; constants; texts, a feature `names`."""

import re
from collections.abc import Iterable, Iterator, Sequence

from exover.emit.identifiers import NamedConstant, constants
from exover.model.index import ModelIndex
from exover.model.model import Model
from exover.ocrd.reasons import reasons

START = "x"
"""The prefix that identifiers.py gets for Rust; it is cut off again, since modules are prefixes already."""
TAKEN = ("Self", "ALL")
"""Names that no variant and no type gets: a keyword of Rust, and the constant of every enum."""


def names(model: Model) -> str:
    """Return the source of the module `names`."""
    known = constants(model, START)
    index, given = ModelIndex(model), reasons(model)
    requests, stocks = index.requests, index.stocks
    statuses = [(name.removeprefix("X_STATUS_"), n) for t in known.typed for name, n in t.statuses.constants if n >= 0]
    values = [(name.removeprefix("X_"), n) for kind in known.enums.values() for name, n in kind.constants]
    posters = [model.variables[number].name for _, number in known.posters]
    return "\n".join(
        [
            f"//! What the things of the spec {model.name} are called.",
            "",
            "#![allow(non_camel_case_types, clippy::enum_variant_names)]",
            "",
            *enum("Request", "The requests", enumerate(requests)),
            *enum(
                "Poster", "The variables that can be observed", zip([n for _, n in known.posters], posters, strict=True)
            ),
            *enum("Stock", "The consumable resources", enumerate(stocks)),
            *enum("Reason", "Why something is refused, stopped or required", enumerate(r.rule for r in given)),
            *_constants("statuses", "u32", "The statuses of failed reports, by request", statuses),
            *_constants("values", "i64", "The values of enums, by type", values),
            *_texts("Request", "name", "What it is called", requests),
            *_texts("Poster", "name", "What it is called", posters),
            *_texts("Stock", "name", "What it is called", stocks),
            *_texts("Reason", "name", "What it is called", [reason.rule for reason in given]),
            *_texts("Reason", "because", "What the spec says it is for", [reason.because for reason in given]),
            *_lists("params", "What its parameters are called", [[p.name for p in r.params] for r in model.requests]),
            *_lists("results", "What its results are called", [[p.name for p in r.results] for r in model.requests]),
            *_lists("statuses", "The statuses of its failures", [r.statuses for r in model.requests]),
        ]
    )


def enum(name: str, title: str, things: Iterable[tuple[int, str]]) -> Iterator[str]:
    """Yield the lines of an enum; `things`: number and name of each variant, perhaps none."""
    things = list(things)
    named = zip(variants(text for _, text in things), things, strict=True)
    numbered = [(variant, number, text) for variant, (number, text) in named]
    yield f"/// {title}."
    yield "#[derive(Clone, Copy, Debug, PartialEq, Eq)]"
    yield f"pub enum {name} {{"
    for variant, number, text in numbered:
        yield f"    /// `{plain(text)}`"
        yield f"    {variant} = {number},"
    yield "}"
    yield ""
    yield f"impl {name} {{"
    yield "    /// All of them, in order."
    yield f"    pub const ALL: [{name}; {len(numbered)}] = ["
    yield from (f"        {name}::{variant}," for variant, _, _ in numbered)
    yield "    ];"
    yield ""
    yield "    /// Its number in the tables."
    yield "    pub const fn index(self) -> usize {"
    yield f"        {'self as usize' if numbered else 'match self {}'}"
    yield "    }"
    yield "}"
    yield ""


def variants(texts: Iterable[str], taken: Iterable[str] = ()) -> list[str]:
    """Return the names in camel case, distinct and none in `taken`: the second of a name gets `_2`."""
    found = dict.fromkeys([*TAKEN, *taken])
    before = len(found)
    for text in texts:
        words = re.split(r"[\W_]+", text, flags=re.ASCII)
        wanted = "".join(word[:1].upper() + word[1:] for word in words)
        wanted = wanted if wanted[:1].isalpha() else f"N{wanted}"
        name, number = wanted, 2
        while name in found:
            name, number = f"{wanted}_{number}", number + 1
        found[name] = None
    return list(found)[before:]


def _constants(module: str, kind: str, title: str, known: Sequence[NamedConstant]) -> Iterator[str]:
    """Yield the lines of a module of constants."""
    yield f"/// {title}."
    yield "#[allow(missing_docs)]"
    yield f"pub mod {module} {{"
    yield from (f"    pub const {name}: {kind} = {number};" for name, number in known)
    yield "}"
    yield ""


def _texts(owner: str, method: str, title: str, texts: Sequence[str | None]) -> Iterator[str]:
    """Yield the lines of a method of `owner` that returns a text, or for `because` an Option of one."""
    optional = method == "because"
    kind = "Option<&str>" if optional else "&str"
    result = kind.replace("&", "&'static ")
    yield '#[cfg(feature = "names")]'
    yield f"impl {owner} {{"
    yield f"    /// {title}."
    yield f"    pub fn {method}(self) -> {result} {{"
    yield f"        const TEXTS: [{kind}; {len(texts)}] = ["
    yield from (f"            {_optional(text) if optional else _literal(text or '')}," for text in texts)
    yield "        ];"
    yield f"        TEXTS.get({_position(owner)}).copied().unwrap_or_default()"
    yield "    }"
    yield "}"
    yield ""


def _position(owner: str) -> str:
    """Return the expression for the index of a text: posters are counted, since their numbers have gaps."""
    if owner != "Poster":
        return "self.index()"
    return "Self::ALL.iter().position(|each| *each == self).unwrap_or(usize::MAX)"


def _lists(method: str, title: str, lists: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of a method of `Request` that returns a list of texts."""
    yield '#[cfg(feature = "names")]'
    yield "impl Request {"
    yield f"    /// {title}."
    yield f"    pub fn {method}(self) -> &'static [&'static str] {{"
    yield f"        const TEXTS: [&[&str]; {len(lists)}] = ["
    yield from (f"            &[{', '.join(map(_literal, texts))}]," for texts in lists)
    yield "        ];"
    yield "        TEXTS.get(self.index()).copied().unwrap_or_default()"
    yield "    }"
    yield "}"
    yield ""


def _optional(text: str | None) -> str:
    return "None" if text is None else f"Some({_literal(text)})"


def _literal(text: str) -> str:
    """Return a text as a literal; quotes, backslashes and all but printable ASCII are written by their code points."""
    shown = (c if " " <= c <= "~" and c not in '"\\' else f"\\u{{{ord(c):x}}}" for c in text)
    return f'"{"".join(shown)}"'


def plain(text: str) -> str:
    """Return a text for a comment, with `?` for backquotes and all but printable ASCII."""
    return "".join(c if " " <= c <= "~" and c != "`" else "?" for c in text)
