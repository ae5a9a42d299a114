"""Wraps boxes that would stand in a long row: their columns go on below, as lines of a text do.

A wire to another row leaves its row at the right, turns round it, and comes in at the left of the
other one, with a line of its own all the way.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rtkit.drawing import scene as s
from rtkit.drawing.columns import arranged, columns_of, simplified

WIDEST = 2400
_FLATTEST = 4
"""What is less wide, or higher in proportion, stays as it is."""
_ASPECT = 1.7
_AWAY = 0.35
"""How far a cut may be from where the rows would be of one length, in parts of that length."""
_MOST_WIRES = 8
"""No cut where more would have to turn: they are read better in one row."""
_LINE, _MARGIN, _ROW_GAP = 10, 22, 48


def wrapped(boxes: Sequence[s.Box], wires: Sequence[s.Wire], widest: int = WIDEST) -> s.Layout:
    """Return places for boxes of which each is connected to another one, or is alone."""
    rank = columns_of(boxes, wires)
    whole = arranged(boxes, wires, rank)
    if whole.size.width <= max(widest, _FLATTEST * whole.size.height):
        return whole
    cuts = _cuts(whole, rank, wires)
    return _Rows(boxes, wires, rank, cuts).layout() if cuts else whole


def _cuts(whole: s.Layout, rank: Sequence[int], wires: Sequence[s.Wire]) -> list[int]:
    """Return before which columns a new row begins: where few wires have to turn."""
    columns = range(1, max(rank) + 1)
    begin = dict.fromkeys(columns, whole.size.width)
    for (x, _), column in zip(whole.places, rank, strict=True):
        if column:
            begin[column] = min(begin[column], x)
    turning = dict.fromkeys(columns, 0)
    for wire in wires:
        low, high = sorted((rank[wire.source.box], rank[wire.target.box]))
        for column in range(low + 1, high + 1):
            turning[column] += 1
    height = whole.size.height + _ROW_GAP
    count = max(2, round((whole.size.width / height / _ASPECT) ** 0.5))
    length = whole.size.width / count
    found: list[int] = []
    for number in range(1, count):
        ideal = number * length
        near = [
            (turning[column], abs(begin[column] - ideal), column)
            for column in columns
            if column > max(found, default=0) and abs(begin[column] - ideal) <= _AWAY * length
        ]
        if near and min(near)[0] <= _MOST_WIRES:
            found.append(min(near)[2])
    return found


class _Trunk(NamedTuple):
    """The way of the wires of one port from their row to another one.

    Attributes:
        source: The port.
        start: Number of the row of the port.
        end: Number of the other row.
    """

    source: s.WireEnd
    start: int
    end: int


class _Row(NamedTuple):
    """The boxes of some columns, with a point for each trunk that leaves it or comes in.

    Attributes:
        boxes: Their numbers; the points stand behind them.
        wires: Numbers of the wires in it, whole or in part, in the order of its layout.
        leaving: The ports whose wires leave it.
        coming: The trunks that come in.
    """

    boxes: list[int]
    wires: list[int]
    leaving: list[s.WireEnd]
    coming: list[_Trunk]
    layout: s.Layout

    def exit(self, source: s.WireEnd) -> s.Point:
        """Return where the wires of a port leave."""
        return self.layout.places[len(self.boxes) + self.leaving.index(source)]

    def entry(self, trunk: _Trunk) -> s.Point:
        """Return where a trunk comes in."""
        return self.layout.places[len(self.boxes) + len(self.leaving) + self.coming.index(trunk)]


class _Rows:
    def __init__(
        self,
        boxes: Sequence[s.Box],
        wires: Sequence[s.Wire],
        rank: Sequence[int],
        cuts: Sequence[int],
    ) -> None:
        self._boxes = boxes
        self._wires = wires
        self._rank = rank
        self._cuts = [0, *cuts, max(rank) + 1]
        self._row_of = [sum(each >= cut for cut in cuts) for each in rank]
        self._trunks = list(dict.fromkeys(self._turning()))
        self._rows = [self._row(number) for number in range(len(cuts) + 1)]

    def _turning(self) -> Iterator[_Trunk]:
        for wire in self._wires:
            trunk = self._trunk(wire)
            if trunk is not None:
                yield trunk

    def _trunk(self, wire: s.Wire) -> _Trunk | None:
        start, end = self._row_of[wire.source.box], self._row_of[wire.target.box]
        return None if start == end else _Trunk(wire.source, start, end)

    def _row(self, number: int) -> _Row:
        """Lay out one row."""
        begin, end = self._cuts[number], self._cuts[number + 1]
        own = [box for box, row in enumerate(self._row_of) if row == number]
        coming = [each for each in self._trunks if each.end == number]
        leaving = list(dict.fromkeys(t.source for t in self._trunks if t.start == number))
        place = {box: index for index, box in enumerate(own)}
        exits = {source: len(own) + index for index, source in enumerate(leaving)}
        entries = {trunk: len(own) + len(leaving) + index for index, trunk in enumerate(coming)}
        boxes = [self._boxes[box] for box in own]
        boxes += [_point(s.LEFT)] * len(leaving) + [_point(s.RIGHT)] * len(coming)
        rank = [self._rank[box] - begin + 1 for box in own]
        rank += [end - begin + 1] * len(leaving) + [0] * len(coming)
        if not coming:
            rank = [each - 1 for each in rank]
        numbers, wires = [], []
        for index, wire in enumerate(self._wires):
            trunk = self._trunk(wire)
            source, target = wire.source, wire.target
            if trunk is None and self._row_of[source.box] == number:
                ends = [each._replace(box=place[each.box]) for each in (source, target)]
            elif trunk is not None and trunk.start == number:
                ends = [source._replace(box=place[source.box]), s.WireEnd(exits[source], 0)]
            elif trunk is not None and trunk.end == number:
                ends = [s.WireEnd(entries[trunk], 0), target._replace(box=place[target.box])]
            else:
                continue
            numbers.append(index)
            wires.append(wire._replace(source=ends[0], target=ends[1]))
        points = len(leaving) + len(coming)
        return _Row(own, numbers, leaving, coming, arranged(boxes, wires, rank, points))

    def layout(self) -> s.Layout:
        """Put the rows below each other, and lead the trunks round them."""
        tops = self._tops()
        exits = {t: tops[t.start] + self._rows[t.start].exit(t.source)[1] for t in self._trunks}
        entries = {t: tops[t.end] + self._rows[t.end].entry(t)[1] for t in self._trunks}
        corridors = self._corridors(tops, exits)
        lefts = _tracks(
            sorted(self._trunks, key=lambda t: -corridors[t]),
            {t: _span(corridors[t], entries[t]) for t in self._trunks},
        )
        rights = _tracks(
            sorted(self._trunks, key=lambda t: (exits[t] > corridors[t], -exits[t])),
            {t: _span(exits[t], corridors[t]) for t in self._trunks},
        )
        left = _width(lefts)
        right = left + max(row.layout.size.width for row in self._rows)
        places: list[s.Point] = [(0, 0)] * len(self._boxes)
        paths: list[list[s.Point]] = [[] for _ in self._wires]
        joints = [
            (left + x, top + y)
            for row, top in zip(self._rows, tops, strict=True)
            for x, y in row.layout.joints
        ]
        ways: dict[_Trunk, list[s.Point]] = {}
        for trunk in self._trunks:
            x = right + _MARGIN + rights[trunk] * _LINE
            u = left - _MARGIN - lefts[trunk] * _LINE
            y = corridors[trunk]
            ways[trunk] = [(x, exits[trunk]), (x, y), (u, y), (u, entries[trunk])]
        for number, (row, top) in enumerate(zip(self._rows, tops, strict=True)):
            for box, (x, y) in zip(row.boxes, row.layout.places, strict=False):
                places[box] = (left + x, top + y)
            for index, path in zip(row.wires, row.layout.paths, strict=True):
                moved = [(left + x, top + y) for x, y in path]
                turning = self._trunk(self._wires[index])
                if turning is not None and turning.start == number:
                    paths[index] = [*moved, *ways[turning], *paths[index]]
                else:
                    paths[index] += moved
        bottom = tops[-1] + self._rows[-1].layout.size.height
        size = s.Size(right + _width(rights), bottom)
        return s.Layout(size, tuple(places), tuple(map(_tuple, paths)), tuple(joints))

    def _tops(self) -> list[int]:
        """Return where each row begins: below the lines of the trunks that come in."""
        tops, bottom = [], 0
        for number, row in enumerate(self._rows):
            lines = len(row.coming)
            room = 2 * _MARGIN + lines * _LINE if lines else 0
            tops.append(bottom + max(room, _ROW_GAP if number else 0))
            bottom = tops[-1] + row.layout.size.height
        return tops

    def _corridors(self, tops: Sequence[int], exits: dict[_Trunk, int]) -> dict[_Trunk, int]:
        """Return the height of the line of each trunk above the row to which it leads."""
        found = {}
        for row, top in zip(self._rows, tops, strict=True):
            lines = sorted(row.coming, key=lambda t: (t.start, -exits[t]))
            for place, trunk in enumerate(reversed(lines)):
                found[trunk] = top - _MARGIN - place * _LINE
        return found


def _point(side: str) -> s.Box:
    return s.Box("", "", (s.PortPin("", side, s.DATA),))


def _span(one: int, other: int) -> tuple[int, int]:
    return min(one, other), max(one, other)


def _tracks(order: Sequence[_Trunk], spans: dict[_Trunk, tuple[int, int]]) -> dict[_Trunk, int]:
    """Return the track of each vertical line, from 0 at the rows; none lie on one another."""
    tracks: dict[_Trunk, int] = {}
    for trunk in order:
        low, high = spans[trunk]
        inside = [
            track
            for other, track in tracks.items()
            if spans[other][0] - _LINE < high and low - _LINE < spans[other][1]
        ]
        tracks[trunk] = max(inside, default=-1) + 1
    return tracks


def _width(tracks: dict[_Trunk, int]) -> int:
    """Return the room that lines beside the rows need."""
    return 2 * _MARGIN + max(tracks.values()) * _LINE if tracks else 0


def _tuple(path: Sequence[s.Point]) -> tuple[s.Point, ...]:
    return tuple(simplified(path))
