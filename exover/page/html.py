"""The page put together: template, style, scripts and what it is told, in one file that loads nothing."""

import json
from base64 import b64encode
from collections.abc import Mapping
from hashlib import sha256
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from exover.model.wire import escaped

LIBRARY = "vendor/dagre.min.js"
"""dagre (MIT, vendor/LICENSE) lays out what is drawn."""
SCRIPTS = (
    "tables.js",
    "exact.js",
    "wire.js",
    "memory.js",
    "walker.js",
    "words.js",
    "run.js",
    "dom.js",
    "layout.js",
    "diagram.js",
    "timeline.js",
    "verdicts.js",
    "rules.js",
    "missions.js",
    "graph.js",
    "controls.js",
    "simulator.js",
    "page.js",
)
"""The scripts in the order in which they are run; each stands on those before it."""


def render(document: Mapping[str, Any]) -> str:
    """Return the page as HTML. Its policy lets nothing run but these scripts, and nothing be loaded at all."""
    title = f"{document['spec']}: {document['verdict']}"
    return put_together(title, embedded(document), asset("assets/start.js"))


def put_together(title: str, data: str, start: str, allowed: str = "", loads: str = "") -> str:
    """Return a page that begins with the script `start`; `data` is there for it.

    `allowed` are further sources of scripts, `loads` further parts of the policy, each with its semicolon.
    """
    style = asset("assets/page.css")
    scripts = [asset(LIBRARY), *(asset(f"assets/{name}") for name in SCRIPTS), start]
    return Template(asset("assets/page.html")).substitute(
        policy=escape(_policy(scripts, style, allowed, loads)),
        title=escape(title),
        style=style,
        data=data,
        scripts="\n".join(f"<script>{script}</script>" for script in scripts),
    )


def asset(name: str) -> str:
    """Return the text of a file of this package."""
    return files("exover.page").joinpath(name).read_text("utf-8")


def embedded(document: Mapping[str, Any]) -> str:
    """Return an object as JSON that can stand in an element of HTML: no text of it begins a tag or a comment."""
    text = json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return escaped(text).replace("<", "\\u003c")


def _policy(scripts: list[str], style: str, allowed: str, loads: str) -> str:
    """Return the Content-Security-Policy: these scripts and this style alone, by their hashes."""
    known = " ".join([*map(_hash, scripts), allowed]).strip()
    return (
        f"default-src 'none'; script-src {known}; style-src {_hash(style)}; {loads}"
        "img-src data:; base-uri 'none'; form-action 'none'"
    )


def _hash(text: str) -> str:
    return f"'sha256-{b64encode(sha256(text.encode()).digest()).decode()}'"
