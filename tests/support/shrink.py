"""Makes what two engines disagree about small: delta debugging by lines (Zeller and Hildebrandt 2002)."""

from collections.abc import Callable, Sequence

from exover.pipeline import load
from exover.source import Source
from tests.support.engines import Disagreement, disagreement


def smallest(lines: Sequence[str], fails: Callable[[Sequence[str]], bool]) -> list[str]:
    """Return some of the lines, in order, which still fail, and none of which can be left out alone."""
    kept = list(lines)
    size = max(1, len(kept) // 2)
    while True:
        shorter = False
        start = 0
        while start < len(kept):
            trial = kept[:start] + kept[start + size :]
            if fails(trial):
                kept, shorter = trial, True
            else:
                start += size
        if size == 1 and not shorter:
            return kept
        size = size if shorter else max(1, size // 2)


def shrink(found: Disagreement, native: bool = False) -> Disagreement:
    """Return a disagreement of the same engines about a shorter spec and fewer events."""

    def again(spec: Sequence[str], events: Sequence[str]) -> Disagreement | None:
        text = "\n".join(spec)
        return disagreement(text, events, native) if load(Source("shrunk.exo", text)).model else None

    def fewer_events(found: Disagreement) -> Disagreement:
        spec = found.spec.splitlines()
        return again(spec, smallest(found.lines, lambda events: again(spec, events) is not None)) or found

    def shorter_spec(found: Disagreement) -> Disagreement:
        spec = found.spec.splitlines()
        return again(smallest(spec, lambda lines: again(lines, found.lines) is not None), found.lines) or found

    return shorter_spec(fewer_events(shorter_spec(fewer_events(found))))
