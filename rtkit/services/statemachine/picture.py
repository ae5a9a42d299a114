"""Draws the graph of a machine as SVG: states inside each other, ways from their causes in arcs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple
from xml.sax.saxutils import escape

from rtkit.services.statemachine.model import GuardedTransition, Machine, around, by_outer

_HEAD, _LINE, _GAP, _INDENT, _LANE, _LETTER = 26, 16, 8, 12, 14, 6.4
_LONGEST = 90
"""Letters of a cause that are shown; the rest is in its tooltip."""
_STYLE = (
    "text{font:13px sans-serif;fill:#1f2933}.cause{font-size:11px;fill:#4a5563}"
    ".state{fill:#fff;stroke:#345}.active{fill:#d9efd4;stroke:#2e7d32;stroke-width:2}"
    ".way{fill:none;stroke:#345;marker-end:url(#a)}"
)


class _Box(NamedTuple):
    top: float
    bottom: float
    depth: int


def draw_machine(machine: Machine, active: str = "") -> str:
    """Return the picture [SVG]; the active states are green."""
    boxes: dict[str, _Box] = {}
    height = _placed(machine, by_outer(machine.states), boxes)
    texts = [_INDENT * box.depth + _LETTER * 1.3 * len(path.rpartition(".")[2])
             for path, box in boxes.items()]  # fmt: skip
    texts += [_INDENT * boxes[path].depth + _LETTER * len(_cause(way))
              for path, state in machine.states.items() for way in state.transitions]  # fmt: skip
    right = max(texts, default=0) + _INDENT * max((b.depth for b in boxes.values()), default=0) + 60
    lit = set(around(active))
    parts = [_state(machine, path, box, right, path in lit) for path, box in boxes.items()]
    ways, lanes = _ways(machine, boxes, right)
    width = right + (lanes + 1) * _LANE
    arrow = '<marker id="a" markerWidth="8" markerHeight="8" refX="7" refY="4" orient="auto">'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}">'
        f"<title>{escape(machine.name)}</title><style>{_STYLE}</style>"
        f'<defs>{arrow}<path d="M0 0L8 4L0 8z" fill="#345"/></marker></defs>'
        f'<path d="M0 0H{width:.0f}V{height:.0f}H0z" fill="#f5f7f9"/>'
        f"{''.join(parts)}{ways}</svg>\n"
    )


def _placed(
    machine: Machine, inside: Mapping[str, list[str]], boxes: dict[str, _Box], outer: str = ""
) -> float:
    """Give the states inside another one their boxes, downwards; return where they end."""
    depth = outer.count(".") + 1 if outer else 0
    y = boxes[outer].bottom if outer else float(_GAP)
    for path in inside.get(outer, ()):
        ways = len(machine.states[path].transitions)
        boxes[path] = _Box(y, y + _HEAD + ways * _LINE + (_GAP if ways else 0), depth)
        boxes[path] = _Box(y, _placed(machine, inside, boxes, path), depth)
        y = boxes[path].bottom + _GAP
    return y


def _cause(way: GuardedTransition) -> str:
    cause = way.cause if way.to else f"{way.cause} (stays)"
    return cause if len(cause) <= _LONGEST else f"{cause[:_LONGEST]}…"


def _state(machine: Machine, path: str, box: _Box, right: float, is_active: bool) -> str:
    """Return a state with the causes of its ways: its box goes round those inside it."""
    state, x = machine.states[path], _GAP + box.depth * _INDENT
    name = path.rpartition(".")[2] + (" ◉" if state.is_final else "")
    outer = path.rpartition(".")[0]
    is_initial = path == (machine.states[outer].initial if outer else machine.initial)
    causes = "".join(
        f'<text class="cause" x="{x + 20}" y="{box.top + _HEAD + row * _LINE + 10}">'
        f"<title>{escape(way.cause)}</title>{escape(_cause(way))}</text>"
        for row, way in enumerate(state.transitions)
    )
    return (
        f'<rect class="state{" active" if is_active else ""}" x="{x}" y="{box.top}" rx="6" '
        f'width="{right - box.depth * _INDENT - x:.0f}" height="{box.bottom - box.top}"/>'
        f'<text x="{x + 8}" y="{box.top + 18}">{"● " if is_initial else ""}{escape(name)}</text>'
        f"{causes}"
    )


def _ways(machine: Machine, boxes: Mapping[str, _Box], right: float) -> tuple[str, int]:
    """Return the arcs, each in a lane in which it meets no other one, and how many lanes."""
    arcs: list[tuple[str, str, float, float]] = []
    coming: dict[str, int] = {}
    for path, state in machine.states.items():
        for row, way in enumerate(state.transitions):
            if way.to:
                start = boxes[path].top + _HEAD + row * _LINE + 6
                end = boxes[way.to].top + 6 + coming.get(way.to, 0) * 4 % 20
                coming[way.to] = coming.get(way.to, 0) + 1
                arcs.append((path, way.to, start, end))
    taken: list[list[tuple[float, float]]] = []
    parts = []
    for path, to, start, end in sorted(arcs, key=lambda arc: abs(arc[3] - arc[2])):
        low, high = min(start, end) - 3, max(start, end) + 3
        free = (at for at, lane in enumerate(taken)
                if all(high < one or other < low for one, other in lane))  # fmt: skip
        lane = next(free, len(taken))
        taken[lane:] = taken[lane:] or [[]]
        taken[lane].append((low, high))
        begin, finish = (right - boxes[each].depth * _INDENT for each in (path, to))
        middle = right + (lane + 0.7) * _LANE
        parts.append(
            f'<path class="way" d="M{begin:.0f} {start}H{middle:.0f}V{end}H{finish + 1:.0f}">'
            f"<title>{escape(f'{path} → {to}')}</title></path>"
        )
    return "".join(parts), len(taken)
