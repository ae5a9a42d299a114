"""State of the widgets of a panel: what is shown, and what a key makes of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite
from typing import Any

from rtkit.panel.description import Panel
from rtkit.property.values import is_number, is_vector

LONGEST_TRACE = 400
_SIDES = {"left": -1, "right": 1}
_STEPS = {"minus": -1, "plus": 1, "pagedown": -10, "pageup": 10}


@dataclass
class WidgetState:
    """Keeps what a widget shows.

    Attributes:
        value: None before the first has come.
        quality: As it came with the value.
        problem: Why the last wish was refused, empty if it was not.
        trace: The last numbers, for plots.
    """

    value: Any = None
    quality: str = "good"
    problem: str = ""
    trace: list[float] = field(default_factory=list)

    def take(self, value: Any, quality: str = "good") -> None:
        """Take a value that has come."""
        self.quality = quality
        if quality == "gone" and value in (None, ""):
            return  # what was known last stays to be seen
        self.value = value
        if is_number(value):
            self.trace = [*self.trace[1 - LONGEST_TRACE :], float(value)]

    def state(self, panel: Panel) -> str:
        """Return the worst of quality and alarms: a key of `drawing.SIGNS`, empty if it is well."""
        if panel.is_round:
            return "round"
        if self.quality != "good":
            return self.quality
        if isinstance(self.value, bytes):
            return ""
        severity = panel.spec.severity(self.value)
        return "" if severity == "none" else severity


def wish(panel: Panel, value: Any, key: str, part: int = 0) -> Any:
    """Return the value that a key asks for, None if it asks for none."""
    if panel.is_read_only or panel.kind == "button":
        return None
    if panel.kind == "toggle":
        return (value is not True) if key in ("space", "enter") else None
    if panel.kind == "choice":
        return _chosen(panel, value, _SIDES.get(key, 0))
    if is_number(value) and panel.kind in ("slider", "knob", "number"):
        return _moved(panel, float(value), key)
    if is_vector(value) and panel.kind == "vector" and part < len(value) and key in _STEPS:
        moved = _moved(panel, float(value[part]), key)
        return None if moved is None else (*value[:part], moved, *value[part + 1 :])
    return None


def _chosen(panel: Panel, value: Any, by: int) -> Any:
    choices = panel.words("choices")
    if not by or not choices:
        return None
    known = panel.texts("choices")
    at = known.index(str(value)) if str(value) in known else -by
    return choices[(at + by) % len(choices)]


def _moved(panel: Panel, value: float, key: str) -> float | int | None:
    low, high = panel.number("min", float("-inf")), panel.number("max", float("inf"))
    ends = {"home": low, "end": high}
    if key in ends:
        return ends[key] if abs(ends[key]) < float("inf") else None
    by = (_SIDES | _STEPS).get(key, 0)
    if not by:
        return None
    is_whole = panel.attributes.get("type") == "integer"
    usual = 1.0 if is_whole else (high - low) / 50 if high - low < float("inf") else 0.1
    moved = min(high, max(low, value + by * panel.number("step", usual)))
    if not isfinite(moved):
        return None
    return round(moved) if is_whole else float(f"{moved:.9g}")


def steered(panel: Panel, axes: tuple[int, int], size: int, key: str) -> tuple[float, ...] | None:
    """Return where a joystick goes by an arrow key, None by another; all of it, or back to zero."""
    most = min(abs(panel.number("max", 1.0)), abs(panel.number("min", -1.0)))
    ways = {"up": (0, 1), "down": (0, -1), "left": (1, 1), "right": (1, -1)}
    if key in ("space", "escape"):
        return (0.0,) * size
    if key not in ways or panel.is_read_only:
        return None
    axis, sign = ways[key]
    return tuple(sign * most if each == axes[axis] else 0.0 for each in range(size))
