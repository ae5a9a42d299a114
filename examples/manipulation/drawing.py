"""Pictures of a dialogue as SVG: the site, what was explored, the way chosen, the sub-problems."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape

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
_CELL, _EDGE = 48, 34
_INK, _PALE, _WALL, _GRID = "#1f2933", "#6b7785", "#4a5563", "#d5dae1"
_HAND, _WALK, _CARRY = "#c2410c", "#2563eb", "#b45309"
_FILLS = ("#bfdbfe", "#bbf7d0", "#fde68a", "#fbcfe8", "#ddd6fe", "#fed7aa")
_FONT = "font-family='Helvetica, Arial, sans-serif'"


@dataclass
class _Sheet:
    """SVG elements over a grid of places, (1 1) below on the left."""

    columns: int
    rows: int
    legend: float = 0
    parts: list[str] = field(default_factory=list)

    @property
    def size(self) -> tuple[float, float]:
        return self.columns * _CELL + 2 * _EDGE, self.rows * _CELL + 2 * _EDGE + self.legend

    def at(self, x: float, y: float) -> tuple[float, float]:
        return _EDGE + (x - 0.5) * _CELL, _EDGE + (self.rows - y + 0.5) * _CELL

    def cell(self, place: Place, fill: str, inset: float = 0, **more: object) -> None:
        x, y = self.at(*place)
        half = _CELL / 2 - inset
        attributes = "".join(f" {key.replace('_', '-')}='{value}'" for key, value in more.items())
        self.parts.append(
            f"<rect x='{x - half:g}' y='{y - half:g}' width='{2 * half:g}' height='{2 * half:g}'"
            f" fill='{fill}'{attributes}/>"
        )

    def text(self, x: float, y: float, text: str, **more: object) -> None:
        settings = {"font_size": 13, "fill": _INK, "text_anchor": "middle", **more}
        attributes = "".join(f" {k.replace('_', '-')}='{v}'" for k, v in settings.items())
        self.parts.append(f"<text x='{x:g}' y='{y:g}'{attributes}>{escape(text)}</text>")

    def line(self, points: Sequence[tuple[float, float]], stroke: str, **more: object) -> None:
        told = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        attributes = "".join(f" {k.replace('_', '-')}='{v}'" for k, v in more.items())
        self.parts.append(
            f"<polyline points='{told}' fill='none' stroke='{stroke}' stroke-linejoin='round'"
            f" stroke-linecap='round'{attributes}/>"
        )

    def svg(self, title: str) -> str:
        return _svg(*self.size, title, self.parts)


def _svg(width: float, height: float, title: str, parts: Iterable[str]) -> str:
    body = "\n".join(parts)
    return (
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width:g} {height:g}'"
        f" width='{width:g}' height='{height:g}' {_FONT}>\n<title>{escape(title)}</title>\n"
        f"<rect width='{width:g}' height='{height:g}' fill='white'/>\n{body}\n</svg>\n"
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
    sheet = _Sheet(site.width, site.height, legend)
    for number, places in enumerate(site.regions.values()):
        for place in places:
            sheet.cell(place, _FILLS[number % len(_FILLS)], 1, opacity=0.45)
    for x in range(1, site.width + 1):
        for y in range(1, site.height + 1):
            sheet.cell((x, y), "none", stroke=_GRID)
    for wall in site.walls:
        sheet.cell(wall, _WALL)
    for x in range(1, site.width + 1):
        sheet.text(sheet.at(x, 0)[0], sheet.at(1, 0.42)[1] + 14, str(x), fill=_PALE, font_size=11)
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
        cells = sorted(cells_of(thing.shape, poses[name]))
        corners = [sheet.at(*cell) for cell in cells]
        left, top = min(x for x, _ in corners) - 16, min(y for _, y in corners) - 16
        right, low = max(x for x, _ in corners) + 16, max(y for _, y in corners) + 16
        dash = "" if thing.is_named else " stroke-dasharray='4 3'"
        sheet.parts.append(
            f"<rect x='{left:g}' y='{top:g}' width='{right - left:g}' height='{low - top:g}' rx='5'"
            f" fill='{fill}' stroke='{_INK}' stroke-width='1.5' opacity='{opacity}'{dash}/>"
        )
        if not is_labelled:
            continue
        label = name if thing.is_named else "?"
        size = _fitting(label, right - left) if thing.is_named else 18
        sheet.text((left + right) / 2, (top + low) / 2 + 5, label, font_size=size)


def _fitting(name: str, width: float) -> float:
    return max(7.0, min(13.0, 1.7 * width / max(1, len(name))))


def _named(sheet: _Sheet, site: Site) -> None:
    for name, place in site.places.items():
        x, y = sheet.at(*place)
        sheet.parts.append(f"<circle cx='{x:g}' cy='{y:g}' r='5' fill='#facc15' stroke='{_INK}'/>")
        sheet.text(x, y - 9, name, font_size=_fitting(name, 40))
    for name, places in site.regions.items():
        for place in places:
            x, y = sheet.at(*place)
            sheet.text(
                x - 21, y + _CELL / 2 - 4, name, font_size=9, fill=_PALE, text_anchor="start"
            )


def _jaws(sheet: _Sheet, hand: Pose) -> None:
    x, y = sheet.at(*hand[:2])
    turn = -90 * hand[2]
    sheet.parts.append(
        f"<g transform='rotate({turn} {x:g} {y:g})' stroke='{_HAND}' stroke-width='4' fill='none'>"
        f"<path d='M {x - 12:g} {y - 20:g} H {x + 12:g} M {x - 12:g} {y + 20:g} H {x + 12:g}'/></g>"
    )


def site_picture(site: Site, poses: Mapping[str, Pose], hand: Pose) -> str:
    """Return the site: walls, things, regions, named places, and the jaws (two red bars)."""
    sheet = _ground(site, poses)
    _things(sheet, site, poses)
    _named(sheet, site)
    _jaws(sheet, hand)
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
        sheet.cell(place, "#2563eb", 1, opacity=f"{0.12 + 0.68 * count / most:.2f}")
    _things(sheet, site, view.poses, 0.75)
    for place, count in counts.items():
        x, y = sheet.at(*place)
        ink = "white" if count > 0.6 * most else _INK
        sheet.text(x + 21, y - 14, str(count), font_size=10, fill=ink, text_anchor="end")
    _jaws(sheet, view.hand)
    total, places = sum(counts.values()), site.width * site.height - len(site.walls)
    told = f"{len(searches)} evaluations expanded {total} states; {len(counts)} of {places} places"
    sheet.text(sheet.size[0] / 2, sheet.size[1] - 14, told)
    return sheet.svg(TITLES["explored"])


def way_picture(site: Site, view: View, way: Way) -> str:
    """Return a way: dashed where the hand is empty, solid where it carries, parts numbered."""
    sheet = _ground(site, view.poses, 44 + 17 * len(way.parts))
    _things(sheet, site, view.poses, 0.5, is_labelled=False)
    last = way.parts[-1].after.poses if way.parts else view.poses
    ends = {name: pose for name, pose in last.items() if pose != view.poses.get(name)}
    _ends(sheet, site, ends)
    _named(sheet, site)
    before, is_loaded = view.hand, bool(view.holding)
    marks: list[tuple[float, float, str, str]] = []
    for number, part in enumerate(way.parts, 1):
        off = ((number * 5) % 11 - 5) * 1.9
        run = [_shifted(sheet, before, off)]
        for step in part.steps:
            here = _shifted(sheet, step.pose, off)
            if step.kind in ("grip", "release"):
                _run(sheet, run, is_loaded)
                run, is_loaded = [here], step.kind == "grip"
                marks.append((*here, str(number) if is_loaded else "", _CARRY))
            elif step.kind == "turn":
                marks.append((*here, "t", "#7c3aed"))
            else:
                run.append(here)
            before = step.pose
        _run(sheet, run, is_loaded)
        if isinstance(part.goal, Go):
            marks.append((*_shifted(sheet, before, off), str(number), _WALK))
    for x, y, text, colour in sorted(marks, key=lambda mark: bool(mark[2])):  # numbers on top
        _mark(sheet, x, y, text, colour)
    _labels(sheet, site, view.poses, ends)
    _jaws(sheet, view.hand)
    _legend(sheet, way)
    return sheet.svg(TITLES["way"])


def _mark(sheet: _Sheet, x: float, y: float, text: str, colour: str) -> None:
    """Draw where a thing is gripped or a walk ends, with its number; a ring where one is left."""
    fill, radius = (colour, 8) if text else ("white", 5)
    sheet.parts.append(
        f"<circle cx='{x:g}' cy='{y:g}' r='{radius}' fill='{fill}' stroke='{colour}'"
        " stroke-width='2'/>"
    )
    if text:
        sheet.text(x, y + 4, text, font_size=11, fill="white", font_weight="bold")


def _run(sheet: _Sheet, points: Sequence[tuple[float, float]], is_loaded: bool) -> None:
    if len(points) > 1:
        colour, dash = (_CARRY, {}) if is_loaded else (_WALK, {"stroke_dasharray": "2 6"})
        sheet.line(points, colour, stroke_width=3.5, **dash)
        _arrow(sheet, points, colour)


def _ends(sheet: _Sheet, site: Site, poses: Mapping[str, Pose]) -> None:
    for name, pose in poses.items():
        for cell in cells_of(site.things[name].shape, pose):
            sheet.cell(cell, "none", 7, stroke=_INK, stroke_dasharray="5 4", stroke_width=1.5, rx=5)


def _labels(sheet: _Sheet, site: Site, poses: Mapping[str, Pose], ends: Mapping[str, Pose]) -> None:
    """Write names beside the ways: above the left corner, and with a dash where things end."""
    for name, pose in poses.items():
        top = max(cells_of(site.things[name].shape, pose), key=lambda cell: (cell[1], -cell[0]))
        x, y = sheet.at(*top)
        sheet.text(x - 20, y - 18, name, text_anchor="start", font_size=11, font_weight="bold")
    for name, pose in ends.items():
        x, y = sheet.at(*pose[:2])
        sheet.text(x + 21, y + 22, f"{name}\u2032", text_anchor="end", font_size=11)


def _shifted(sheet: _Sheet, pose: Pose, off: float) -> tuple[float, float]:
    """Return where a pose is drawn: ways of several parts beside each other."""
    x, y = sheet.at(*pose[:2])
    return round(x + off, 1), round(y + off, 1)


def _arrow(sheet: _Sheet, points: Sequence[tuple[float, float]], fill: str) -> None:
    (x0, y0), (x, y) = points[-2], points[-1]
    dx, dy = (x > x0) - (x < x0), (y > y0) - (y < y0)
    tip, back = (x - 7 * dx, y - 7 * dy), (x - 18 * dx, y - 18 * dy)
    corners = [tip, (back[0] - 6 * dy, back[1] + 6 * dx), (back[0] + 6 * dy, back[1] - 6 * dx)]
    told = " ".join(f"{a:.1f},{b:.1f}" for a, b in corners)
    sheet.parts.append(f"<polygon points='{told}' fill='{fill}'/>")


def _legend(sheet: _Sheet, way: Way) -> None:
    y = sheet.size[1] - 17 * len(way.parts) - 22
    left = _EDGE
    sheet.line([(left, y), (left + 28, y)], _WALK, stroke_width=3.5, stroke_dasharray="2 6")
    sheet.text(left + 34, y + 4, "empty", text_anchor="start", font_size=12)
    sheet.line([(left + 84, y), (left + 112, y)], _CARRY, stroke_width=3.5)
    sheet.text(left + 118, y + 4, "carrying", text_anchor="start", font_size=12)
    costs = ", ".join(f"{name} {cost:g}" for name, cost in way.costs.items() if cost)
    told = f"cost {way.cost:g} ({costs})" if costs else "nothing to do"
    sheet.text(left + 186, y + 4, told, text_anchor="start", font_weight="bold", font_size=12)
    for number, part in enumerate(way.parts, 1):
        cost = sum(step.price + step.risk for step in part.steps)
        line = f"{number}  {part.goal}: {cost:g}"
        sheet.text(left, y + 7 + 17 * number, line, text_anchor="start", font_size=12)


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
    column = 200
    rows = _drawn(root, 0, 0, column, parts)
    return _svg(column * (depth + 1) + 70, max(rows, 1) * 40 + 40, TITLES["tree"], parts)


def _drawn(node: _Node, level: int, row: int, column: int, parts: list[str]) -> int:
    """Draw a node at its first row, and all below it; return the first row that is free."""
    x, y = 20 + level * column, 36 + row * 40
    colour, weight = (_CARRY, "bold") if node.is_chosen else (_PALE, "normal")
    following = row
    for number, child in enumerate(node.children.values()):
        below = 36 + following * 40
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
    size = _fitting(node.text, column - 95) if level else 13
    parts.append(
        f"<text x='{x}' y='{y + 4}' font-size='{size:.1f}' fill='{_INK}'"
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
