"""Draws the value of a widget as lines of styled text; nothing here knows of a terminal.

State is told by a word and a sign as well as by colour.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

from rtkit.panel.description import Panel
from rtkit.panel.state import WidgetState
from rtkit.property import components
from rtkit.property.conversion import to_value
from rtkit.property.values import Element, is_number, is_vector
from rtkit.property.writing import write

Segment = tuple[str, str]
"""Text and its style: empty, ``dim``, ``good``, ``warn``, ``alarm``, ``accent``, ``#rrggbb …``."""
Line = list[Segment]

SIGNS = {
    "alarm": "▲ alarm",
    "warn": "△ warning",
    "bad": "✕ bad",
    "uncertain": "? uncertain",
    "stale": "◷ stale",
    "gone": "⊘ gone",
    "round": "↻ above",
}
STYLES = {"alarm": "alarm", "bad": "alarm", "gone": "alarm", "round": "dim"}
_BARS = "▁▂▃▄▅▆▇█"
_MOST_LINES = _MOST_PARTS = 12
_LONGEST_TEXT = 4096
_MOST_LETTERS = 800
_FARTHEST = 1e100
_DIALS = "↙←↖↑↗→↘"


def lines(panel: Panel, shown: WidgetState, width: int, part: int = 0) -> list[Line]:
    """Return a value as it is drawn in so many columns; `part` of a vector is marked."""
    value = shown.value
    if value is None:
        return [[("" if panel.is_round else "…", "dim")]]
    is_bytes = isinstance(value, bytes) or panel.attributes.get("type") == "bytes"
    if is_bytes and isinstance(value, bytes | str):
        value = value if isinstance(value, bytes) else value.encode("utf-8", "surrogateescape")
        if panel.kind == "image":
            from rtkit.panel.blocks import blocks

            return blocks(value, max(8, min(56, width)))
        return _other(text) if (text := _decoded(value)) else [[(f"{len(value)} bytes", "")]]
    if panel.kind in ("slider", "knob") and is_number(value):
        return [_bar(panel, float(value), width)]
    if panel.kind == "toggle":
        return [[("[●━] on" if value is True else "[━○] off", "accent" if value is True else "")]]
    if panel.kind == "choice":
        return [_choices(panel, value)]
    if panel.kind == "plot":
        spark = _spark(shown.trace[16 - width :], max(8, width - 16))
        return [[(spark, "accent"), (f" {text_of(value)}", "")]]
    if panel.kind == "joystick" and is_vector(value) and value:
        return _pad(panel, value)
    if panel.kind == "map":
        return _map(list(value) if isinstance(value, tuple) else [value], width)
    if panel.kind == "button":
        return [_call(value)]
    if panel.kind == "marker" and (found := _location(value)) is not None:
        return [_parts(panel, found, part), *_features(value)]
    if is_vector(value) and len(value) > _MOST_PARTS:
        ends = f" {len(value)} from {text_of(min(value))} to {text_of(max(value))}"
        return [[(_spark(value, max(8, width - len(ends))), "accent"), (ends, "")]]
    if is_vector(value) and value:
        return [_parts(panel, value, part)]
    return _other(value)


def text_of(value: Any) -> str:
    """Return a value as people read it: no quotes, numbers not longer than needed."""
    if isinstance(value, bool):
        return write(value)
    if isinstance(value, int | float):
        return f"{value:.0f}" if 1e6 <= abs(value) < 1e15 else f"{value:.6g}"
    if isinstance(value, str):
        return value.translate(_CONTROLS)
    if is_vector(value):
        return "  ".join(map(text_of, value))
    return write(to_value(value))  # type: ignore[arg-type]


def _decoded(data: bytes) -> str:
    """Return the text that bytes are, empty where they are none, or too long to be looked at."""
    try:
        text = data.decode() if len(data) <= _LONGEST_TEXT else ""
    except UnicodeDecodeError:
        return ""
    return "" if any(_CONTROLS.get(ord(each)) == "�" for each in text) else text


_CONTROLS = {code: "�" for code in (*range(32), *range(127, 160)) if code != 10}
_CONTROLS |= {9: "    ", 13: ""}


def _bar(panel: Panel, value: float, width: int) -> Line:
    low, high = panel.number("min", 0.0), panel.number("max", 1.0)
    part = min(1.0, max(0.0, (value - low) / (high - low))) if high > low else 0.0
    text = f" {text_of(value)}"
    if panel.kind == "knob":
        dial = _DIALS[round(part * (len(_DIALS) - 1))]
        return [(f"({dial})", "accent"), (text, "")]
    room = slider_room(width)
    done = round(part * room)
    return [("━" * done, "accent"), ("●", "accent"), ("─" * (room - done), "dim"), (text, "")]


def slider_room(width: int) -> int:
    """Return how far the knob of a slider goes, in columns."""
    return max(4, min(40, width - 12) - 1)


def _choices(panel: Panel, value: Any) -> Line:
    made: Line = []
    for each in panel.words("choices"):
        is_it = text_of(each) == text_of(value)
        made.append((f"◉ {text_of(each)}  " if is_it else f"○ {text_of(each)}  ",
                     "accent" if is_it else "dim"))  # fmt: skip
    return made or [(text_of(value), "")]


def choice_at(panel: Panel, column: int) -> Any:
    """Return the choice that is drawn in a column, None behind the last."""
    for each in panel.words("choices"):
        column -= len(text_of(each)) + 4
        if column < 0:
            return each
    return None


def _spark(trace: Sequence[float], room: int) -> str:
    every = max(1, math.ceil(len(trace) / room))
    kept = [each for each in trace[::every] if math.isfinite(each)]
    if not kept:
        return ""
    low, high = min(kept), max(kept)
    scale = (len(_BARS) - 1) / (high - low) if high > low else 0.0
    return "".join(_BARS[int((each - low) * scale)] for each in kept)


def axes(panel: Panel, value: Sequence[float]) -> tuple[int, int]:
    """Return which parts of a vector a joystick moves: ahead and to the left."""
    labels = panel.texts("labels")[: len(value)]
    wanted = panel.texts("axes")
    if not wanted:
        wanted = ["x", "c"] if len(value) == 6 else labels[:2]
    found = [labels.index(each) for each in wanted if each in labels]
    return (found[0], found[1]) if len(found) > 1 else (0, min(1, len(value) - 1))


def _pad(panel: Panel, value: Sequence[float]) -> list[Line]:
    ahead, left = (value[each] / (panel.number("max", 1.0) or 1.0) for each in axes(panel, value))
    row = 2 - round(2 * max(-1.0, min(1.0, ahead)))  # of nan: min and max return the other number
    column = 4 - round(4 * max(-1.0, min(1.0, left)))
    grid = [[("●" if (each, at) == (row, column) else "┼" if (each, at) == (2, 4) else "·")
             for at in range(9)] for each in range(5)]  # fmt: skip
    grid[2] += [f"  {text_of(value)}"]
    return [[("".join(each), "accent" if row == index else "dim")]
            for index, each in enumerate(grid)]  # fmt: skip


def _parts(panel: Panel, value: Sequence[float], part: int) -> Line:
    labels = components.names(tuple(value), panel.texts("labels"))
    made: Line = []
    for index, (label, each) in enumerate(zip(labels, value, strict=True)):
        is_it = index == part and not panel.is_read_only
        made.append((f"{label} ", "dim"))
        made.append((f"{text_of(each)}  ", "accent" if is_it else ""))
    return made


def _location(value: Any) -> tuple[float, ...] | None:
    """Return where a marker is, None if that is not told."""
    found = getattr(value, "location", None)
    if found is None and isinstance(value, Element):
        child = value.find("location")
        found = child.leaf if child is not None else None
    return found if is_vector(found) and len(found or ()) > 1 else None


def _features(value: Any) -> list[Line]:
    parts = [str(getattr(value, key, "") or "") for key in ("name", "type", "id", "frame")]
    words = " ".join(text_of(each) for each in parts if each)
    return [[(words, "dim")]] if words else []


def _map(markers: list[Any], width: int) -> list[Line]:
    places = [(each, found) for each in markers if (found := _location(each)) is not None]
    if not places:
        return [[("no places", "dim")]]
    columns, most = max(12, min(48, width - 2)), 9
    # Rubbish, as nan, is listed, but lies nowhere.
    drawn = [at[:2] for _, at in places if all(abs(each) < _FARTHEST for each in at[:2])]
    xs = [0.0, *(x for x, _ in drawn)]
    ys = [0.0, *(y for _, y in drawn)]
    unit = max((max(xs) - min(xs)) / (columns - 1), (max(ys) - min(ys)) / 2 / (most - 1), 1e-9)
    rows = min(most, round((max(ys) - min(ys)) / unit / 2) + 1)
    grid = [["·"] * columns for _ in range(rows)]

    def put(x: float, y: float, sign: str) -> None:
        column, row = round((x - min(xs)) / unit), round((max(ys) - y) / unit / 2)
        grid[min(rows - 1, row)][min(columns - 1, column)] = sign

    put(0.0, 0.0, "+")
    listed: list[Line] = []
    for index, (marker, at) in enumerate(places[:26]):
        sign = chr(ord("A") + index)
        if at[:2] in drawn:
            put(at[0], at[1], sign)
        words = "".join(text for line in _features(marker) for text, _ in line)
        listed.append([(f"{sign} ", "accent"), (f"{text_of(at)}  ", ""), (words, "dim")])
    scale = f"{'━' * (columns // 4)} {text_of(unit * (columns // 4))}"
    drawn_rows = [_marked("".join(each)) for each in grid]
    return [*drawn_rows, [(scale, "dim")], *listed[:_MOST_LINES]]


def _marked(row: str) -> Line:
    """Return a row of a map, its signs brighter than the ground."""
    return [(each, "dim" if each[0] == "·" else "accent") for each in re.findall("·+|[^·]+", row)]


def _call(value: Any) -> Line:
    if not isinstance(value, Element):
        return [(text_of(value), "")]
    state = value.attributes.get("state", "")
    parts = {each.name: each.leaf for each in value.children}
    progress = parts.get("progress")
    made: Line = [("" if state == "idle" else state, "alarm" if state == "failed" else "accent")]
    if state == "running" and is_number(progress):
        part = float(progress) if progress <= 1 else float(progress) / 100  # type: ignore[arg-type,operator]
        done = round(10 * min(1.0, max(0.0, part)))
        made.append((f" {'█' * done}{'░' * (10 - done)} {part:.0%}", "accent"))
    for key in ("error", "result", "remaining", "progress"):
        if parts.get(key) is not None and not (key == "progress" and state == "running"):
            made.append((f" {text_of(parts[key])}", "alarm" if key == "error" else ""))
            break
    return made


def _other(value: Any) -> list[Line]:
    plain = value if isinstance(value, str | tuple) else to_value(value)
    if isinstance(plain, Element):
        return _tree(plain, 0)[:_MOST_LINES]
    if isinstance(plain, tuple) and plain and not is_vector(plain):
        rows = [each if isinstance(each, tuple) else (each,) for each in plain]
        return [[("  ".join(map(text_of, each)), "")] for each in rows][:_MOST_LINES]
    text = text_of(plain)
    text = text if len(text) <= _MOST_LETTERS else f"{text[:_MOST_LETTERS]}… ({len(text)} letters)"
    return [[(each, "")] for each in (text.splitlines() or [""])][:_MOST_LINES]


def _tree(element: Element, depth: int) -> list[Line]:
    words = " ".join(f"{key}={text_of(each)}" for key, each in element.attributes.items())
    leaf = "" if element.leaf is None else text_of(element.leaf)
    own: Line = [("  " * depth + element.name, "dim"), (f" {words} {leaf}".rstrip(), "")]
    return [own, *(line for each in element.children for line in _tree(each, depth + 1))]
