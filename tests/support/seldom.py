"""Events that random ones seldom meet."""

SELDOM = {
    "what fell from clearing is not made clearing again in the step": (
        """module m {
            request x() { interrupts m.y else wait; interrupts m.z; wait until not waiting(m.y); }
            request y();
            request z();
        }""",
        ["ask z", "ask x", "ask y", "ok z", "ok y"],
    ),
    "what is produced is never above the capacity": (
        """resource p: 3 consumable = 2;
        module m {
            request x() { produces p 2; }
            request y() { consumes p 3; }
            request z() { consumes p 1; }
        }""",
        [
            "ask y",
            "ask x",
            "ok x",
            "ask y",
            "ask z",
            "ok y",
            "ask x",
            "ok x",
            "ask z",
            "ok z",
            "ask z",
            "ok z",
            "ask z",
        ],
    ),
    "what is stopping counts as active and as idle": (
        """module m { request a(); request b(); }
        forbid active(m.a) and not active(m.b) by wait;""",
        ["ask b", "abort b", "ask a", "ok b", "ask b", "ok a"],
    ),
    "who is killed for the sake of another is not launched over what is stopping": (
        """module m {
            request a();
            request b() { settle until not active(m.d); }
            request c();
            request d();
        }
        limit at most 2 of m.a, m.b, m.c by kill m.a;""",
        ["ask c", "abort c", "ask d", "ask b", "ask a", "ok c", "ask a", "ok d"],
    ),
    "a request that interrupts itself and is killed by another": (
        """module m {
            request x() { interrupts self else wait; }
            request y() { interrupts m.x; settle until not running(m.z); }
            request z() { interrupts self, m.y; }
        }""",
        ["ask z", "ask x", "ask y", "ask x", "ask z", "ok x", "ask x", "ok z", "ask y", "ok z", "ok x", "ok y", "ok x"],
    ),
}
_SHAPES = {"ask": '{{"ask": "m.{}"}}', "ok": '{{"report": "m.{}", "outcome": "ok"}}', "abort": '{{"abort": "m.{}"}}'}


def lines(events: list[str]) -> list[str]:
    """Return such events, as `ask x`, as JSON lines."""
    return [_SHAPES[kind].format(name) for kind, name in map(str.split, events)]
