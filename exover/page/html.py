"""Puts the page together: template, style, scripts and data in one HTML file that loads nothing."""

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
"""dagre (MIT, vendor/LICENSE) computes the layout of graphs."""
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
"""The scripts in the order in which they are run; each may use those before it."""


def render(document: Mapping[str, Any]) -> str:
    """Return the page as HTML; its Content-Security-Policy allows these scripts and no loading."""
    title = f"{document['spec']}: {document['verdict']}"
    return put_together(title, embedded(document), asset("assets/start.js"))


def put_together(title: str, data: str, start: str, allowed: str = "", loads: str = "") -> str:
    """Return a page whose last script is `start`, which finds `data` in the page.

    `allowed`: more sources of scripts; `loads`: more directives of the policy, each with its semicolon.
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
    """Return an object as JSON for an element of HTML: it has no `<`, so no text of it begins a tag or a comment."""
    text = json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return escaped(text).replace("<", "\\u003c")


def _policy(scripts: list[str], style: str, allowed: str, loads: str) -> str:
    """Return the Content-Security-Policy, which allows these scripts and this style by their hashes."""
    known = " ".join([*map(_hash, scripts), allowed]).strip()
    return (
        f"default-src 'none'; script-src {known}; style-src {_hash(style)}; {loads}"
        "img-src data:; base-uri 'none'; form-action 'none'"
    )


def _hash(text: str) -> str:
    return f"'sha256-{b64encode(sha256(text.encode()).digest()).decode()}'"
