"""Draws the graph of a machine as SVG: states as rows inside each other, transitions as arcs."""

from __future__ import annotations

from xml.sax.saxutils import escape

from rtkit.services.statemachine.model import Machine, around

_ROW, _INDENT, _LETTER, _LANE, _LEFT = 34, 18, 7.5, 22, 10
_STYLE = (
    "text{font:12px sans-serif}rect{fill:#fff;stroke:#345}.active{fill:#cfe8c9}"
    "path{fill:none;stroke:#345;marker-end:url(#a)}.label{fill:#345;font-size:11px}"
)


def draw_machine(machine: Machine, active: str = "") -> str:
    """Return the picture [SVG]; the active states are green."""
    paths, lit = list(machine.states), around(active)
    rows = {path: index * _ROW + 12 for index, path in enumerate(paths)}
    deepest = max((path.count(".") for path in paths), default=0)
    longest = max((len(path.rpartition(".")[2]) for path in paths), default=0)
    width = _LEFT + deepest * _INDENT * 2 + longest * _LETTER + 40
    parts = [_box(machine, path, rows, width, path in lit) for path in paths]
    ways = [(path, each) for path, state in machine.states.items() for each in state.transitions]
    right = width + len(ways) * _LANE + 20
    farthest = right
    for lane, (path, way) in enumerate(ways):
        start = rows[path] + 8 + min(lane % 4, 3) * 3
        end = rows[way.to or path] + 21 - min(lane % 3, 2) * 3
        edge = width - path.count(".") * _INDENT
        to_edge = width - (way.to or path).count(".") * _INDENT
        middle = width + (lane + 1) * _LANE
        parts.append(f'<path d="M{edge} {start}H{middle}V{end}H{to_edge + 2}"/>')
        caption = escape(f"{path} → {way.to or path}: {way.cause}")
        parts.append(
            f'<text class="label" x="{right}" y="{18 + lane * 16}">{lane + 1}. {caption}</text>'
        )
        parts.append(f'<text class="label" x="{middle - 14}" y="{start - 2}">{lane + 1}</text>')
        farthest = max(farthest, round(right + 20 + len(caption) * 6.2))
    height = max(len(paths) * _ROW, len(ways) * 16) + 24
    arrow = '<marker id="a" markerWidth="8" markerHeight="8" refX="7" refY="4" orient="auto">'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{farthest}" height="{height}">'
        f"<title>{escape(machine.name)}</title><style>{_STYLE}</style>"
        f'<defs>{arrow}<path d="M0 0L8 4L0 8z" style="fill:#345"/></marker></defs>'
        f"{''.join(parts)}</svg>\n"
    )


def _box(machine: Machine, path: str, rows: dict[str, int], width: float, is_active: bool) -> str:
    """Return a state: its box goes round those inside it; a final one has a double name."""
    below = [each for each in rows if each.startswith(f"{path}.")]
    indent = path.count(".") * _INDENT
    height = 26 + len(below) * _ROW
    name = path.rpartition(".")[2] + (" ◉" if machine.states[path].is_final else "")
    is_initial = path in (machine.initial, *(each.initial for each in machine.states.values()))
    x = _LEFT + indent
    return (
        f'<rect class="{"active" if is_active else ""}" x="{x}" y="{rows[path]}" rx="6" '
        f'width="{width - _LEFT - 2 * indent}" height="{height}"/>'
        f'<text x="{x + 8}" y="{rows[path] + 17}">{"● " if is_initial else ""}{escape(name)}</text>'
    )
