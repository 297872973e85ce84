"""A run as a timeline: a self-contained SVG with a lane for each request, wrapped into bands.

All coordinates are integers and every order is that of the spec or of the run, so equal runs have equal bytes. No
meaning is in a colour alone. The whole run is in `desc` as text, for screen readers.
"""

from collections.abc import Iterator

from exover.dataclass import dataclass
from exover.escaping import plain_html
from exover.report.lanes import Lane, LaneMark, LaneMarkKind, Row, lanes_of
from exover.report.story import Story, story_lines

BAND_WIDTH = 1200
"""The most pixels of the columns in one band; a single column may be wider."""
MIN_COLUMN = 42
LINE = 13
"""Height of a line of marks."""
ROW = 15
"""Height of a row of bars."""
GAP = 8
AXIS = 34
"""Height of the axis above the lanes of a band."""
MARGIN = 16

SHAPES: dict[LaneMarkKind, str] = {
    "ask": "M0 0L7 4L0 8z",
    "report": "M4 0L8 4L4 8L0 4z",
    "observe": "M0 3h8v2h-8z",
    "abort": "M0 0h8v8h-8zM2 2v4h4v-4z",
    "launch": "M4 0a4 4 0 1 1 0 8a4 4 0 1 1 0-8z",
    "wait": "M0 0h3v8h-3zM5 0h3v8h-3z",
    "reject": "M0 1L1 0L4 3L7 0L8 1L5 4L8 7L7 8L4 5L1 8L0 7L3 4z",
    "kill": "M0 0h8v8h-8z",
    "violation": "M4 0L8 8H0z",
    "invalid": "M4 0L8 8H0zM4 3L2 7H6z",
}
STYLE = """text{font:11px monospace;fill:#222}.head{font-size:14px;font-weight:bold}
.name{font-weight:bold}.small{font-size:10px}
.line{stroke:#ddd}.tick{stroke:#999}.running{fill:#8ecb8a;stroke:#1b7837}.stopping{fill:url(#stopping);stroke:#1b7837}
.waiting{fill:#fde3b5;stroke:#b35806;stroke-dasharray:3 2}.clearing{fill:url(#clearing);stroke:#b35806}
.value{fill:#eef3fa;stroke:#7b94b5}.loop{fill:#ede7f6}.ring{fill:none;stroke:#5e35b1;stroke-width:2}
.ask,.observe,.report,.abort{fill:#2166ac}.launch{fill:#1b7837}.wait{fill:#b35806}.reject,.violation,.invalid{fill:#b2182b}
.kill{fill:#762a83}"""
PATTERNS = """<pattern id="stopping" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">\
<rect width="6" height="6" fill="#e3f3e1"/><rect width="3" height="6" fill="#8ecb8a"/></pattern>
<pattern id="clearing" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">\
<rect width="6" height="6" fill="#fff6e5"/><rect width="3" height="6" fill="#f5bf6b"/></pattern>"""


@dataclass(frozen=True, slots=True)
class Band:
    """The columns of moments `first` to `last`; `edges`: the x at which each column begins, and the last one ends."""

    first: int
    last: int
    edges: tuple[int, ...]
    lanes: tuple[Lane, ...]

    def at(self, moment: int) -> int:
        """Return the x at which the column of a moment begins; of the moment after the last, at which the band ends."""
        return self.edges[moment - self.first]

    def lines(self, lane: Lane) -> int:
        """Return how many lines of marks a lane has in this band."""
        return max((len(marks) for step, marks in lane.marks.items() if self.first <= step <= self.last), default=0)

    def height(self, lane: Lane) -> int:
        """Return the height of a lane in pixels."""
        return self.lines(lane) * LINE + max(len(lane.rows), 0 if self.lines(lane) else 1) * ROW + GAP


def render(title: str, story: Story) -> str:
    """Return the SVG with a final newline; `title`: what the run shows."""
    lanes = lanes_of(story)
    labels = [_label(lane, row) for lane in lanes for row in lane.rows] + [lane.name for lane in lanes]
    left = MARGIN + max(map(_width, labels), default=0) + GAP
    bands = tuple(_bands(lanes, len(story.scenes), left))
    body: list[str] = []
    y = 3 * MARGIN
    for band in bands:
        body += _band(story, band, y)
        y += AXIS + sum(band.height(lane) for lane in band.lanes) + MARGIN
    legend, legend_end = _legend(MARGIN, y)
    title_end = MARGIN + _width(title) * 14 // 11
    width = max([band.edges[-1] for band in bands] + [title_end, legend_end]) + MARGIN
    height = y + 2 * MARGIN
    told = "\n".join(plain_html(line) for line in story_lines(story))
    head = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        'role="img" aria-labelledby="title desc">',
        f'<title id="title">{plain_html(title)}</title>',
        f'<desc id="desc">{told}</desc>',
        f"<style>{STYLE}</style>",
        f"<defs>{PATTERNS}</defs>",
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
        f'<text class="head" x="{MARGIN}" y="{MARGIN + 10}">{plain_html(title)}</text>',
    ]
    return "\n".join([*head, *body, *legend, "</svg>"]) + "\n"


# ---- layout ----


def _bands(lanes: tuple[Lane, ...], last: int, left: int) -> Iterator[Band]:
    """Yield the bands from the start to moment `last`, each of as many moments as fit BAND_WIDTH."""
    first = 0
    while first <= last:
        edges = [left, left + _column(lanes, first, opening=True)]
        moment = first + 1
        while moment <= last and edges[-1] + _column(lanes, moment) - left <= BAND_WIDTH:
            edges.append(edges[-1] + _column(lanes, moment))
            moment += 1
        shown = tuple(lane for lane in lanes if lane.busy(first, moment - 1))
        yield Band(first, moment - 1, tuple(edges), shown)
        first = moment


def _column(lanes: tuple[Lane, ...], moment: int, opening: bool = False) -> int:
    """Return the width of the column of a moment; the `opening` one of a band shows every value."""
    widths = [MIN_COLUMN]
    for lane in lanes:
        widths += [_width(mark.text) + 18 for mark in lane.marks.get(moment, ())]
        if lane.values:
            cells = lane.rows[0].cells
            if opening or cells[moment] != cells[moment - 1]:
                widths.append(_width(cells[moment]) + 10)
    return max(widths)


def _width(text: str) -> int:
    """Return the pixels of a text of 11 px monospace, rounded up."""
    return len(text) * 67 // 10 + 1


def _label(lane: Lane, row: Row) -> str:
    return f"{lane.name} {row.label}".rstrip()


# ---- drawing ----


def _band(story: Story, band: Band, top: int) -> Iterator[str]:
    """Yield the elements of a band."""
    bottom = top + AXIS + sum(band.height(lane) for lane in band.lanes)
    yield from _loop(story, band, top, bottom)
    for moment in range(band.first, band.last + 1):
        x = band.at(moment)
        yield f'<path class="tick" d="M{x} {top + AXIS - 6}V{bottom}"/>'
        yield f'<text x="{x + 3}" y="{top + AXIS - 8}">{moment or "start"}</text>'
    y = top + AXIS
    for lane in band.lanes:
        yield f'<path class="line" d="M{MARGIN} {y}H{band.edges[-1]}"/>'
        yield from _lane(band, lane, y)
        y += band.height(lane)
    yield f'<path class="line" d="M{MARGIN} {y}H{band.edges[-1]}"/>'


def _loop(story: Story, band: Band, top: int, bottom: int) -> Iterator[str]:
    """Yield the background and the bracket of the loop of a lasso, as far as it is in the band."""
    if story.loop_start is None or band.last < story.loop_start + 1:
        return
    first, last = story.loop_start + 1, len(story.scenes)
    start, end = band.at(max(first, band.first)), band.edges[-1]
    yield f'<rect class="loop" x="{start}" y="{top}" width="{end - start}" height="{bottom - top}"/>'
    opening = f"M{start} {top + 6}V{top}" if first >= band.first else f"M{start} {top}"
    closing = "v6" if last == band.last else ""
    yield f'<path class="ring" d="{opening}H{end}{closing}"/>'
    yield f'<text class="small" x="{start + 3}" y="{top + 11}">for ever: {first}–{last}</text>'


def _lane(band: Band, lane: Lane, top: int) -> Iterator[str]:
    """Yield the name, the marks and the rows of a lane."""
    rows = top + band.lines(lane) * LINE + 3
    for step, marks in sorted(lane.marks.items()):
        if band.first <= step <= band.last:
            for line, mark in enumerate(marks):
                yield _mark(mark, band.at(step) + 3, top + line * LINE + 3)
    if not lane.rows:
        yield f'<text class="name" x="{MARGIN}" y="{top + 13}">{plain_html(lane.name)}</text>'
    for index, row in enumerate(lane.rows):
        y = rows + index * ROW
        yield f'<text class="name" x="{MARGIN}" y="{y + 11}">{plain_html(_label(lane, row))}</text>'
        yield from _bars(band, lane, row, y)


def _bars(band: Band, lane: Lane, row: Row, y: int) -> Iterator[str]:
    """Yield a bar for each maximal interval of moments with one content that is not empty."""
    moment = band.first
    while moment <= band.last:
        end = moment
        while end < band.last and row.cells[end + 1] == row.cells[moment]:
            end += 1
        cell = row.cells[moment]
        if cell:
            x, width = band.at(moment), band.at(end + 1) - band.at(moment)
            kind = "value" if lane.values else cell
            told = f"<title>{plain_html(f'{_label(lane, row)}: {cell}')}</title>"
            yield f'<rect class="{kind}" x="{x}" y="{y}" width="{width}" height="{ROW - 3}">{told}</rect>'
            if lane.values:
                yield f'<text class="small" x="{x + 4}" y="{y + 10}">{plain_html(cell)}</text>'
        moment = end + 1


def _mark(mark: LaneMark, x: int, y: int) -> str:
    return (
        f'<g><title>{plain_html(mark.whole)}</title><path class="{mark.kind}" transform="translate({x} {y})" '
        f'd="{SHAPES[mark.kind]}"/><text x="{x + 11}" y="{y + 8}">{plain_html(mark.text)}</text></g>'
    )


def _legend(x: int, y: int) -> tuple[list[str], int]:
    """Return the elements of the legend, and the x at which it ends."""
    found: list[str] = []
    for phase in ("running", "stopping", "waiting", "clearing"):
        found.append(f'<rect class="{phase}" x="{x}" y="{y}" width="22" height="{ROW - 3}"/>')
        found.append(f'<text x="{x + 26}" y="{y + 10}">{phase}</text>')
        x += 34 + _width(phase)
    for kind, shape in SHAPES.items():
        found.append(f'<path class="{kind}" transform="translate({x} {y + 2})" d="{shape}"/>')
        found.append(f'<text x="{x + 11}" y="{y + 10}">{kind}</text>')
        x += 19 + _width(kind)
    return found, x
