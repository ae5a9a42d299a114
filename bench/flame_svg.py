"""Draws sampled stacks as a flame graph: a small SVG without scripts, readable by day and night."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from html import escape
from typing import NamedTuple, TypeAlias

Stack: TypeAlias = tuple[str, ...]
Stacks: TypeAlias = Mapping[Stack, int]
"""How often each stack was seen, outermost frame first."""

_WIDTH, _HEIGHT, _MARGIN = 1000, 18, 10
_LETTER = 6.8
"""Width of a letter of the font on average, so that text ends within its box."""
_LEAST = 0.004
"""Share of all samples below which a frame is left out."""
_COLOURS = {
    "role": "#d7dae0",
    "rtkit": "#f3b562",
    "bench": "#e8d8b0",
    "system": "#8fb7d9",
    "other": "#b9d7a3",
}
_LEGEND = {
    "rtkit": "rtkit",
    "bench": "what measures",
    "system": "kernel and C code that Python calls",
    "other": "libraries, standard ones too",
}


class Box(NamedTuple):
    """One frame of the picture: place by samples from the left, and by depth."""

    name: str
    kind: str
    depth: int
    start: int
    samples: int


def kind_of(frame: str) -> str:
    """Return what code a frame is of: ``rtkit``, ``bench``, ``system``, ``other`` or ``role``."""
    name, _, where = frame.partition(" · ")
    if not where:
        return "role" if name.endswith(":") else "system"
    if "/" not in where:
        return "bench" if where[:1].isupper() else "other"  # a component, or a single module
    first = where.split("/")[0]
    return first if first in ("rtkit", "bench") else "other"


def boxes(stacks: Stacks) -> Iterator[Box]:
    """Yield the frames, each behind the one that it is in; equal neighbours are one."""
    total = sum(stacks.values())
    yield from _boxes(sorted(stacks.items()), 0, 0, max(1.0, total * _LEAST))


def _boxes(stacks: list[tuple[Stack, int]], depth: int, start: int, least: float) -> Iterator[Box]:
    groups: dict[str, list[tuple[Stack, int]]] = {}
    for stack, count in stacks:
        if len(stack) > depth:
            groups.setdefault(stack[depth], []).append((stack, count))
    for name, group in groups.items():
        samples = sum(count for _, count in group)
        if samples >= least:
            yield Box(name, kind_of(name), depth, start, samples)
            yield from _boxes(group, depth + 1, start, least)
        start += samples


def leaves(stacks: Stacks, most: int) -> list[tuple[str, str, float]]:
    """Return role, innermost frame and share of the most frequent ones."""
    total, ends = sum(stacks.values()), Counter[tuple[str, str]]()
    for stack, count in stacks.items():
        ends[stack[0].rstrip(":"), stack[-1]] += count
    return [(role, frame, count / total) for (role, frame), count in ends.most_common(most)]


def shares(stacks: Stacks) -> dict[str, float]:
    """Return the share of each kind of code, by innermost frames."""
    total, found = sum(stacks.values()), Counter[str]()
    for stack, count in stacks.items():
        found[kind_of(stack[-1])] += count
    return {_LEGEND[kind]: found[kind] / total for kind, _ in found.most_common()}


def importing(stacks: Stacks) -> float:
    """Return the share of what imports of modules do, below the module that is run."""
    within = (count for stack, count in stacks.items() if any(map(_is_import, stack)))
    return sum(within) / sum(stacks.values())


def _is_import(frame: str) -> bool:
    return frame.startswith("import ")


def svg(title: str, stacks: Stacks) -> str:
    """Return the picture; the outermost frames stand on top."""
    drawn = list(boxes(stacks))
    total = sum(stacks.values())
    scale = (_WIDTH - 2 * _MARGIN) / max(total, 1)
    deepest = max((box.depth for box in drawn), default=0)
    top = 46
    height = top + (deepest + 1) * _HEIGHT + _MARGIN
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}"'
        ' font-family="DejaVu Sans, sans-serif" font-size="11">',
        f"<title>{escape(title)}</title>",
        "<style>rect{stroke:#fff;stroke-width:.5}"
        + "".join(f".{kind}{{fill:{colour}}}" for kind, colour in _COLOURS.items())
        + "</style>",
        f'<path d="M0 0h{_WIDTH}v{height}H0z" fill="#fff"/>',
        f'<text x="{_MARGIN}" y="16" font-size="13">{escape(title)}</text>',
        *_legend(),
        *(_drawn(box, top, scale, total) for box in drawn),
        "</svg>\n",
    ]
    return "\n".join(lines)


def _legend() -> Iterator[str]:
    x = _MARGIN
    for kind, text in _LEGEND.items():
        yield f'<rect class="{kind}" x="{x}" y="25" width="12" height="12"/>'
        yield f'<text x="{x + 17}" y="35">{text}</text>'
        x += 40 + round(len(text) * _LETTER)


def _drawn(box: Box, top: int, scale: float, total: int) -> str:
    x, width = _MARGIN + box.start * scale, box.samples * scale
    y = top + box.depth * _HEIGHT
    share = f"{box.samples / total:.1%}"
    room = int((width - 6) / _LETTER)
    name = box.name.partition(" · ")[0]
    text = name if len(name) <= room else f"{name[: room - 1]}…" if room > 3 else ""
    label = f'<text x="{x + 3:.1f}" y="{y + 13}">{escape(text)}</text>' if text else ""
    return (
        f'<g><title>{escape(box.name)}, {share}</title><rect class="{box.kind}" x="{x:.1f}"'
        f' y="{y}" width="{width:.1f}" height="{_HEIGHT}"/>{label}</g>'
    )
