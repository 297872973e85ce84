"""The differences between two versions of a spec in SARIF 2.1.0: a result for each change, at its request in NEW."""

from typing import Any

from exover.model.difference import AnswerChange, Compared, Difference
from exover.model.model import NOWHERE, Location
from exover.model.wire import escaped
from exover.report.difference import change_text, in_both, property_title, run_lines, title
from exover.report.sarif import FINGERPRINT, fingerprint_of, location_of, written

RULES = {
    "weaker": "NEW launches what OLD refuses or lets wait",
    "answers": "an answer is another one in NEW",
    "property": "a property holds in one version and not in the other",
}


def render(compared: Compared) -> str:
    """Return a log of one run as text with a final newline."""
    results = [_difference(compared, each) for each in compared.differences]
    for each in compared.undecided:
        text = f"{change_text(each.change)}: unknown, {each.reason}"
        results.append(_result(compared, _rule(each.change), "open", "none", text, _declared(compared, each.change)))
    for prop in in_both(compared):
        kind, level = ("fail", "warning") if prop.decided else ("open", "none")
        results.append(_result(compared, "property", kind, level, property_title(prop), prop.location))
    rules = [{"id": f"exover/diff/{name}", "shortDescription": {"text": text}} for name, text in RULES.items()]
    return written(
        [
            {
                "tool": {"driver": {"name": "exover", "version": compared.version, "rules": rules}},
                "automationDetails": {"id": f"exover/diff/{compared.versions.new.name}/"},
                "invocations": [{"executionSuccessful": True}],
                "columnKind": "unicodeCodePoints",
                "results": results,
                "properties": {
                    "verdict": compared.verdict,
                    "old": compared.files[0],
                    "new": compared.files[1],
                    "notes": list(map(escaped, compared.notes)),
                },
            }
        ]
    )


def _rule(change: AnswerChange) -> str:
    return "weaker" if change.weaker else "answers"


def _difference(compared: Compared, each: Difference) -> dict[str, Any]:
    text = "\n".join((title(each), *run_lines(compared, each)))
    level = "warning" if each.change.weaker else "note"
    return _result(compared, _rule(each.change), "fail", level, text, _declared(compared, each.change))


def _declared(compared: Compared, change: AnswerChange) -> Location:
    return NOWHERE if change.request is None else compared.versions.new.request[change.request].location


def _result(compared: Compared, rule: str, kind: str, level: str, text: str, location: Location) -> dict[str, Any]:
    first = text.split("\n", 1)[0].split(" (")[0]
    return {
        "ruleId": f"exover/diff/{rule}",
        "ruleIndex": list(RULES).index(rule),
        "kind": kind,
        "level": level,
        "message": {"text": escaped(text)},
        "locations": [location_of(location, compared.files[1])],
        "partialFingerprints": {FINGERPRINT: fingerprint_of(compared.versions.new.name, rule, first)},
    }
