"""Pictures of a dialogue as SVG: the site, what was explored, the way chosen, the sub-problems."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from itertools import pairwise
from typing import NamedTuple

from manipulation.dialogue import Dialogue
from manipulation.knowledge import Pose, Site, cells_of
from manipulation.language import Go, Place
from manipulation.legs import Search
from manipulation.ways import Alternative, View, Way

TITLES = {
    "site": "the site as it is known",
    "explored": "places looked at while planning",
    "way": "the way that was chosen",
    "tree": "sub-problems and what they cost",
}
_CELL, _EDGE, _HEAD, _STRIP = 76.0, 34.0, 26.0, 16.0
_INK, _PALE, _WALL, _GRID = "#1f2933", "#6b7785", "#4a5563", "#d5dae1"
_HAND, _WALK, _CARRY = "#c2410c", "#2563eb", "#b45309"
_FILLS = ("#bfdbfe", "#bbf7d0", "#fde68a", "#fbcfe8", "#ddd6fe", "#fed7aa")
_TOP = 36 + _HEAD
_LANES = (0.0, 10.0, -10.0, 19.0, -19.0)
_HALO = {"stroke": "white", "stroke_width": 3, "stroke_linejoin": "round", "paint_order": "stroke"}
_FONT = "font-family='Helvetica, Arial, sans-serif'"


class _Box(NamedTuple):
    left: float
    top: float
    right: float
    low: float

    def wider(self, by: float) -> _Box:
        return _Box(self.left - by, self.top - by, self.right + by, self.low + by)

    def common(self, other: _Box) -> float:
        """Return the area that two boxes share."""
        across = min(self.right, other.right) - max(self.left, other.left)
        down = min(self.low, other.low) - max(self.top, other.top)
        return max(0.0, across) * max(0.0, down)


@dataclass
class _Sheet:
    """SVG elements over a grid of places, (1 1) below on the left.

    Attributes:
        legend: Height of what is written below the grid [px].
        side: Of a place [px].
        taken: Boxes that labels are to keep off.
    """

    columns: int
    rows: int
    legend: float = 0
    side: float = _CELL
    parts: list[str] = field(default_factory=list)
    taken: list[_Box] = field(default_factory=list)

    @property
    def size(self) -> tuple[float, float]:
        height = self.rows * self.side + 2 * _EDGE + _HEAD + self.legend
        return self.columns * self.side + 2 * _EDGE, height

    def at(self, x: float, y: float) -> tuple[float, float]:
        return _EDGE + (x - 0.5) * self.side, _HEAD + _EDGE + (self.rows - y + 0.5) * self.side

    def box(self, cells: Iterable[Place], inset: float = _STRIP) -> _Box:
        """Return the box around places."""
        corners = [self.at(*cell) for cell in cells]
        across, down = [x for x, _ in corners], [y for _, y in corners]
        return _Box(min(across), min(down), max(across), max(down)).wider(self.side / 2 - inset)

    def rectangle(self, box: _Box, fill: str, **more: object) -> None:
        self.parts.append(
            f"<rect x='{box.left:g}' y='{box.top:g}' width='{box.right - box.left:g}'"
            f" height='{box.low - box.top:g}' fill='{fill}'{_attributes(more)}/>"
        )

    def cell(self, place: Place, fill: str, inset: float = 0, **more: object) -> None:
        self.rectangle(self.box([place], inset), fill, **more)

    def text(self, x: float, y: float, text: str, **more: object) -> None:
        settings = {"font_size": 13, "fill": _INK, "text_anchor": "middle", **more}
        self.parts.append(f"<text x='{x:g}' y='{y:g}'{_attributes(settings)}>{escape(text)}</text>")

    def label(self, text: str, box: _Box, **more: object) -> None:
        """Write beside a box, where the least is covered: above it, below it, on its sides."""
        width, high, middle = _width(text, 12), 12, (box.top + box.low) / 2 - 6
        starts = (box.left, (box.left + box.right - width) / 2, box.right - width)
        corners = [(left, top) for top in (box.top - 13, box.low + 1) for left in starts]
        corners += [(box.right + 3, middle), (box.left - width - 3, middle)]
        most = self.size[0] - _EDGE - width
        lefts = [max(_EDGE, min(left, most)) for left, _ in corners]
        places = [
            _Box(left, top, left + width, top + high)
            for left, (_, top) in zip(lefts, corners, strict=True)
        ]
        best = min(places, key=lambda place: sum(place.common(each) for each in self.taken))
        self.taken.append(best)
        settings = {"text_anchor": "start", "font_size": 12, **_HALO, **more}
        self.text(round(best.left, 1), round(best.low - 2, 1), text, **settings)

    def line(self, points: Sequence[tuple[float, float]], stroke: str, **more: object) -> None:
        told = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self.parts.append(
            f"<polyline points='{told}' fill='none' stroke='{stroke}' stroke-linejoin='round'"
            f" stroke-linecap='round'{_attributes(more)}/>"
        )

    def svg(self, title: str) -> str:
        return _svg(*self.size, title, self.parts)


def _attributes(settings: Mapping[str, object]) -> str:
    return "".join(f" {key.replace('_', '-')}='{value}'" for key, value in settings.items())


def _width(text: str, size: float) -> float:
    """Return how wide a text is at most [px], in fonts as wide as DejaVu Sans."""
    return 0.64 * size * len(text)


def _svg(width: float, height: float, title: str, parts: Iterable[str]) -> str:
    body, shown = "\n".join(parts), escape(title[:1].upper() + title[1:])
    width = max(width, _width(title, 15) + 40)
    return (
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width:g} {height:g}'"
        f" width='{width:g}' height='{height:g}' {_FONT}>\n<title>{escape(title)}</title>\n"
        f"<rect width='{width:g}' height='{height:g}' fill='white'/>\n"
        f"<text x='20' y='26' font-size='15' font-weight='bold' fill='{_INK}'>{shown}</text>\n"
        f"{body}\n</svg>\n"
    )


def picture(dialogue: Dialogue, which: str) -> str:
    """Return a picture of `TITLES` as SVG."""
    site, poses = dialogue.site, {name: each.pose for name, each in dialogue.site.things.items()}
    if which == "site":
        return site_picture(site, poses, site.hand)
    if which == "explored":
        return explored_picture(site, dialogue.view, dialogue.searches)
    if which == "way":
        return way_picture(site, dialogue.view, dialogue.way)
    return tree_picture(dialogue.shown, dialogue.way)


def _ground(site: Site, poses: Mapping[str, Pose], legend: float = 0) -> _Sheet:
    names = [name.split() for name, thing in site.things.items() if thing.is_named]
    longest = max((_width(word, 13) for words in names for word in words), default=0)
    lines = max((len(words) for words in names), default=1)
    side = round(max(_CELL, longest + 2 * _STRIP + 4, 14 * lines + 2 * _STRIP + 4))
    sheet = _Sheet(site.width, site.height, legend, side)
    for number, places in enumerate(site.regions.values()):
        for place in places:
            sheet.cell(place, _FILLS[number % len(_FILLS)], 1, opacity=0.45)
    for x in range(1, site.width + 1):
        for y in range(1, site.height + 1):
            sheet.cell((x, y), "none", stroke=_GRID)
    for wall in site.walls:
        sheet.cell(wall, _WALL)
        sheet.taken.append(sheet.box([wall], 0))
    for x in range(1, site.width + 1):
        sheet.text(sheet.at(x, 0)[0], sheet.at(1, 0.5)[1] + 16, str(x), fill=_PALE, font_size=11)
    for y in range(1, site.height + 1):
        sheet.text(_EDGE - 12, sheet.at(1, y)[1] + 4, str(y), fill=_PALE, font_size=11)
    return sheet


def _things(
    sheet: _Sheet,
    site: Site,
    poses: Mapping[str, Pose],
    opacity: float = 1,
    *,
    is_labelled: bool = True,
) -> None:
    for number, (name, thing) in enumerate(site.things.items()):
        if name not in poses:
            continue
        fill = _FILLS[number % len(_FILLS)] if thing.is_named else "#fecaca"
        box = sheet.box(cells_of(thing.shape, poses[name]))
        dash = {} if thing.is_named else {"stroke_dasharray": "4 3"}
        outline = {"rx": 5, "stroke": _INK, "stroke_width": 1.5, "opacity": opacity}
        sheet.rectangle(box, fill, **outline, **dash)
        if not is_labelled:
            continue
        lines = name.split() if thing.is_named else ["?"]
        middle = (box.top + box.low) / 2 + 5 - 7 * (len(lines) - 1)
        for number_of_line, line in enumerate(lines):
            across = (box.left + box.right) / 2
            sheet.text(across, middle + 14 * number_of_line, line, font_size=13)


def _named(sheet: _Sheet, site: Site) -> None:
    for name, places in site.regions.items():
        for place in places:
            left, _, _, low = sheet.box([place], 3)
            sheet.text(left, low, name, font_size=10, fill=_PALE, text_anchor="start", **_HALO)
            sheet.taken.append(_Box(left, low - 10, left + _width(name, 10), low + 2))
    for name, place in site.places.items():
        x, y = sheet.at(*place)
        sheet.parts.append(f"<circle cx='{x:g}' cy='{y:g}' r='5' fill='#facc15' stroke='{_INK}'/>")
        sheet.label(name, _Box(x - 7, y - 7, x + 7, y + 7))


def _jaws(sheet: _Sheet, hand: Pose) -> None:
    x, y = sheet.at(*hand[:2])
    far, turn = sheet.side / 2 - _STRIP + 4, -90 * hand[2]
    sheet.parts.append(
        f"<g transform='rotate({turn} {x:g} {y:g})' stroke='{_HAND}' stroke-width='4' fill='none'>"
        f"<path d='M {x - 12:g} {y - far:g} h 24 M {x - 12:g} {y + far:g} h 24'/></g>"
    )
    for off in (-far, far):
        here = (x, y + off) if not hand[2] else (x + off, y)
        half = (12, 2) if not hand[2] else (2, 12)
        sheet.taken.append(
            _Box(here[0] - half[0], here[1] - half[1], here[0] + half[0], here[1] + half[1])
        )


def site_picture(site: Site, poses: Mapping[str, Pose], hand: Pose) -> str:
    """Return the site: walls, things, regions, named places, and the jaws (two red bars)."""
    sheet = _ground(site, poses)
    _things(sheet, site, poses)
    _jaws(sheet, hand)
    _named(sheet, site)
    return sheet.svg(TITLES["site"])


def explored_picture(site: Site, view: View, searches: Sequence[Search]) -> str:
    """Return how often each place was expanded, over all searches of the last planning."""
    counts: dict[Place, int] = {}
    for search in searches:
        for pose in search.expanded:
            counts[pose[:2]] = counts.get(pose[:2], 0) + 1
    sheet = _ground(site, view.poses, 26)
    most = max(counts.values(), default=1)
    for place, count in counts.items():
        sheet.cell(place, "#2563eb", 1, opacity=f"{0.1 + 0.5 * count / most:.2f}")
    _things(sheet, site, view.poses, 0.75)
    for place, count in counts.items():
        _, top, right, _ = sheet.box([place], 2)
        sheet.text(right, top + 10, str(count), font_size=11, text_anchor="end", **_HALO)
    _jaws(sheet, view.hand)
    total, places = sum(counts.values()), site.width * site.height - len(site.walls)
    told = f"{len(searches)} evaluations expanded {total} states; {len(counts)} of {places} places"
    sheet.text(sheet.size[0] / 2, sheet.size[1] - 14, told)
    return sheet.svg(TITLES["explored"])


@dataclass
class _Run:
    """A stretch of a way between grips and releases.

    Attributes:
        mark: Number of the part that grips at its beginning, or walks to its end.
        lane: How far it is drawn from the middle of the places [px].
    """

    poses: list[Pose]
    is_loaded: bool
    mark: str = ""
    is_released: bool = False
    turns: list[Pose] = field(default_factory=list)
    lane: float = 0

    def edges(self) -> set[frozenset[Place]]:
        return {frozenset((a[:2], b[:2])) for a, b in pairwise(self.poses) if a[:2] != b[:2]}

    def spots(self) -> set[Place]:
        """Return the places where it is marked."""
        marked = self.poses[0 if self.is_loaded else -1]
        left = {self.poses[-1][:2]} if self.is_released else set()
        return left | ({marked[:2]} if self.mark else set())

    def hides(self, other: _Run) -> bool:
        """Return whether one would cover the other if both were drawn in one lane."""
        own, others = ({pose[:2] for pose in each.poses} for each in (self, other))
        joint = {self.poses[0][:2]} & {other.poses[-1][:2]} - (self.spots() & other.spots())
        met = (self.spots() & others) | (other.spots() & own)
        return bool(self.edges() & other.edges() or met - joint)


def _runs(view: View, way: Way) -> list[_Run]:
    before, is_loaded = view.hand, bool(view.holding)
    runs: list[_Run] = []
    for number, part in enumerate(way.parts, 1):
        runs.append(_Run([before], is_loaded))
        for step in part.steps:
            if step.kind in ("grip", "release"):
                runs[-1].is_released = is_loaded
                is_loaded = step.kind == "grip"
                runs.append(_Run([step.pose], is_loaded, str(number) if is_loaded else ""))
            elif step.kind == "turn":
                runs[-1].turns.append(step.pose)
            else:
                runs[-1].poses.append(step.pose)
            before = step.pose
        if isinstance(part.goal, Go) and not is_loaded:
            runs[-1].mark = str(number)
    kept = [run for run in runs if len(run.poses) > 1 or run.mark or run.turns or run.is_released]
    for number, run in enumerate(kept):
        hidden = {other.lane for other in kept[:number] if run.hides(other)}
        run.lane = next((lane for lane in _LANES if lane not in hidden), 0.0)
    return kept


def way_picture(site: Site, view: View, way: Way) -> str:
    """Return a way: dashed where the hand is empty, solid where it carries, parts numbered."""
    sheet = _ground(site, view.poses, 44 + 17 * len(way.parts))
    _things(sheet, site, view.poses, 0.5, is_labelled=False)
    last = way.parts[-1].after.poses if way.parts else view.poses
    ends = {name: pose for name, pose in last.items() if pose != view.poses.get(name)}
    for name, pose in ends.items():
        box = sheet.box(cells_of(site.things[name].shape, pose), _STRIP - 3)
        sheet.rectangle(box, "none", stroke=_INK, stroke_dasharray="5 4", stroke_width=1.5, rx=6)
    runs = _runs(view, way)
    _ways(sheet, runs)
    _jaws(sheet, view.hand)
    _named(sheet, site)
    for name, pose in view.poses.items():
        box = sheet.box(cells_of(site.things[name].shape, pose), _STRIP - 3)
        sheet.label(name, box, font_weight="bold")
    for name, pose in ends.items():
        box = sheet.box(cells_of(site.things[name].shape, pose), _STRIP - 3)
        sheet.label(f"{name}\u2032", box, font_weight="bold")
    _legend(sheet, way, runs)
    return sheet.svg(TITLES["way"])


def _ways(sheet: _Sheet, runs: Sequence[_Run]) -> None:
    """Draw the runs, each from where the one before ended, and their marks above all of them."""
    marks: list[tuple[float, float, str, str]] = []
    end: list[tuple[float, float]] = []
    for run in runs:
        colour = _CARRY if run.is_loaded else _WALK
        points = [_shifted(sheet, pose, run.lane) for pose in run.poses]
        joined = end + points if end and end[0] != points[0] else points
        _run(sheet, joined, run.is_loaded)
        marks += [(*_shifted(sheet, pose, run.lane), "t", "#7c3aed") for pose in run.turns]
        if run.is_released:
            marks.append((*points[-1], "", _CARRY))
        if run.mark:
            marks.append((*points[0 if run.is_loaded else -1], run.mark, colour))
        end = points[-1:]
    for x, y, text, colour in sorted(marks, key=lambda mark: bool(mark[2])):  # numbers on top
        _mark(sheet, x, y, text, colour)


def _mark(sheet: _Sheet, x: float, y: float, text: str, colour: str) -> None:
    """Draw where a thing is gripped or a walk ends, with its number; a ring where one is left."""
    fill, radius = (colour, 8) if text else ("white", 5)
    sheet.taken.append(_Box(x, y, x, y).wider(radius + 1))
    sheet.parts.append(
        f"<circle cx='{x:g}' cy='{y:g}' r='{radius}' fill='{fill}' stroke='{colour}'"
        " stroke-width='2'/>"
    )
    if text:
        sheet.text(x, y + 4, text, font_size=11, fill="white", font_weight="bold")


def _stroke(is_loaded: bool) -> tuple[str, dict[str, object]]:
    return (_CARRY, {}) if is_loaded else (_WALK, {"stroke_dasharray": "2 6"})


def _run(sheet: _Sheet, points: Sequence[tuple[float, float]], is_loaded: bool) -> None:
    if len(points) > 1:
        colour, dash = _stroke(is_loaded)
        sheet.line(points, colour, stroke_width=3.5, **dash)
        if points[-1] != points[-2]:
            _arrow(sheet, points, colour)
        for (x0, y0), (x, y) in pairwise(points):
            sheet.taken.append(_Box(min(x0, x), min(y0, y), max(x0, x), max(y0, y)).wider(3))


def _shifted(sheet: _Sheet, pose: Pose, off: float) -> tuple[float, float]:
    """Return where a pose is drawn: ways over the same places beside each other."""
    x, y = sheet.at(*pose[:2])
    return round(x + off, 1), round(y + off, 1)


def _arrow(sheet: _Sheet, points: Sequence[tuple[float, float]], fill: str) -> None:
    (x0, y0), (x, y) = points[-2], points[-1]
    dx, dy = (x > x0) - (x < x0), (y > y0) - (y < y0)
    tip, back = (x - 7 * dx, y - 7 * dy), (x - 18 * dx, y - 18 * dy)
    corners = [tip, (back[0] - 6 * dy, back[1] + 6 * dx), (back[0] + 6 * dy, back[1] - 6 * dx)]
    told = " ".join(f"{a:.1f},{b:.1f}" for a, b in corners)
    sheet.parts.append(f"<polygon points='{told}' fill='{fill}'/>")


def _legend(sheet: _Sheet, way: Way, runs: Sequence[_Run]) -> None:
    """Write what the lines that are there mean, what the way costs, and its parts."""
    y, left = sheet.size[1] - 17 * len(way.parts) - 22, _EDGE
    moved = {run.is_loaded for run in runs if len(run.poses) > 1}
    for is_loaded, told in ((False, "empty"), (True, "carrying")):
        if is_loaded in moved:
            colour, dash = _stroke(is_loaded)
            sheet.line([(left, y), (left + 28, y)], colour, stroke_width=3.5, **dash)
            sheet.text(left + 34, y + 4, told, text_anchor="start", font_size=12)
            left += 46 + _width(told, 12)
    costs = ", ".join(f"{name} {cost:g}" for name, cost in way.costs.items() if cost)
    told = f"cost {way.cost:g} ({costs})" if costs else "nothing to do"
    sheet.text(left, y + 4, told, text_anchor="start", font_weight="bold", font_size=12)
    for number, part in enumerate(way.parts, 1):
        cost = sum(step.price + step.risk for step in part.steps)
        line = f"{number}  {part.goal}: {cost:g}"
        sheet.text(_EDGE, y + 7 + 17 * number, line, text_anchor="start", font_size=12)


@dataclass
class _Node:
    text: str
    cost: float
    children: dict[str, _Node] = field(default_factory=dict)
    total: float | None = None
    is_chosen: bool = False


def tree_picture(offered: Sequence[Alternative], way: Way) -> str:
    """Return the alternatives as a tree of sub-problems: equal beginnings are one branch."""
    root = _Node("task", 0.0, is_chosen=True)
    ways = [each.way for each in offered]
    if all(str(each) != str(way) for each in ways) and way.parts:
        ways = [way]
    for each in ways:
        node, is_chosen = root, str(each) == str(way)
        for part in each.parts:
            cost = sum(step.price + step.risk for step in part.steps)
            key = str(part.goal)
            node = node.children.setdefault(key, _Node(key, cost))
            node.is_chosen = node.is_chosen or is_chosen
        node.total = each.cost
    parts: list[str] = []
    depth = max((len(each.parts) for each in ways), default=1)
    labels = {"task", *(str(part.goal) for each in ways for part in each.parts)}
    column = round(max(_width(label, 13) for label in labels)) + 95
    rows = _drawn(root, 0, 0, column, parts)
    return _svg(column * (depth + 1) + 70, max(rows, 1) * 40 + 40 + _HEAD, TITLES["tree"], parts)


def _drawn(node: _Node, level: int, row: int, column: int, parts: list[str]) -> int:
    """Draw a node at its first row, and all below it; return the first row that is free."""
    x, y = 28 + level * column, _TOP + row * 40
    colour, weight = (_CARRY, "bold") if node.is_chosen else (_PALE, "normal")
    following = row
    for number, child in enumerate(node.children.values()):
        below = _TOP + following * 40
        stroke = _CARRY if child.is_chosen else "#c3cad3"
        width = 2.5 if child.is_chosen else 1.2
        start = x + column - 40
        parts.append(
            f"<path d='M {start} {y} C {start + 26} {y} {start + 8} {below} {start + 34} {below}'"
            f" fill='none' stroke='{stroke}' stroke-width='{width}'/>"
        )
        following = _drawn(child, level + 1, following, column, parts)
        if number == 0:
            following = max(following, row + 1)
    following = max(following, row + 1)
    box = f"x='{x - 8}' y='{y - 15}' width='{column - 30}' height='30' rx='6'"
    parts.append(f"<rect {box} fill='white' stroke='{colour}' stroke-width='1.5'/>")
    text = escape(node.text)
    parts.append(
        f"<text x='{x}' y='{y + 4}' font-size='13' fill='{_INK}'"
        f" font-weight='{weight}'>{text}</text>"
    )
    if level:
        parts.append(
            f"<text x='{x + column - 46}' y='{y + 4}' font-size='12' fill='{colour}'"
            f" text-anchor='end'>{node.cost:g}</text>"
        )
    if node.total is not None:
        parts.append(
            f"<text x='{x + column - 14}' y='{y + 5}' font-size='14' font-weight='{weight}'"
            f" fill='{colour}'>= {node.total:g}</text>"
        )
    return following


def as_text(site: Site) -> str:
    """Return the site as characters: # walls, letters of things, ? unknown ones, + the hand."""
    rows = {(x, y): "." for x in range(1, site.width + 1) for y in range(1, site.height + 1)}
    rows |= {place: "," for places in site.regions.values() for place in places}
    rows |= dict.fromkeys(site.places.values(), "*")
    rows |= dict.fromkeys(site.walls, "#")
    for name, thing in site.things.items():
        mark = name[0] if thing.is_named else "?"
        rows |= dict.fromkeys(cells_of(thing.shape, thing.pose), mark)
    rows[site.hand[:2]] = "+" if not site.holding else "@"
    lines = (
        "".join(rows[x, y] for x in range(1, site.width + 1)) for y in range(site.height, 0, -1)
    )
    return "".join(f"{line}\n" for line in lines)
