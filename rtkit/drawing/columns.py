"""Arranges connected boxes in columns from left to right, and routes their wires."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from rtkit.drawing import scene as s
from rtkit.drawing.channels import Net, Route, joints, routes
from rtkit.drawing.heights import Chain, Pull, heights, slide
from rtkit.drawing.order import EdgePiece, ordered
from rtkit.drawing.ranks import ranks

_TRACK = 10
_MARGIN = 22
_BOX_GAP, _WIRE_GAP, _MIXED_GAP = 32, 12, 18


class Stop(NamedTuple):
    """End of a wire in a channel: a node at one side of it.

    Attributes:
        node: A box, or a node that stands for the wire where it passes a column.
        offset: How far below the top of the node.
        side: Of the channel.
    """

    node: int
    offset: int
    side: str


class Hop(NamedTuple):
    """The piece of a wire in one channel; channel i lies between the columns i-1 and i."""

    channel: int
    start: Stop
    end: Stop
    net: object


def arranged(
    boxes: Sequence[s.Box],
    wires: Sequence[s.Wire],
    rank: Sequence[int] | None = None,
    points: int = 0,
) -> s.Layout:
    """Return places for boxes of which each is connected to another one, or is alone.

    Args:
        boxes: What is drawn.
        wires: Between them.
        rank: The column of each box; None to choose it.
        points: So many of the last boxes have no size: there wires leave the picture.
    """
    return _Columns(boxes, wires, rank, points).arrangement()


def columns_of(boxes: Sequence[s.Box], wires: Sequence[s.Wire]) -> list[int]:
    """Return the column of each box."""
    first = [index for index, box in enumerate(boxes) if box.is_first]
    return ranks(len(boxes), [(wire.source.box, wire.target.box) for wire in wires], first)


class _Columns:
    def __init__(
        self,
        boxes: Sequence[s.Box],
        wires: Sequence[s.Wire],
        rank: Sequence[int] | None,
        points: int,
    ) -> None:
        self._boxes = boxes
        self._wires = wires
        self._solid = len(boxes) - points
        solid = boxes[: self._solid]
        self._sizes = [s.box_size(box) for box in solid] + [s.Size(0, 0)] * points
        self._offsets = [s.port_offsets(box) for box in solid] + [{0: 0}] * points
        self._rank = rank or columns_of(boxes, wires)
        self._heights = [size.height for size in self._sizes]
        self._columns: list[list[int]] = [[] for _ in range(max(self._rank) + 1)]
        for box, column in enumerate(self._rank):
            self._columns[column].append(box)
        self._hops = [self._way(wire) for wire in wires]
        self._tops: dict[int, int] = {}
        self._routes: list[dict[object, Route]] = []
        self._share_ends()

    def _share_ends(self) -> None:
        """Have wires that go to one port join where they reach it, if they come from several."""
        going: Counter[tuple[int, object]] = Counter()
        coming: Counter[tuple[int, object]] = Counter()
        for wire, hops in self._ways():
            going[hops[0].channel, wire.source] += 1
            coming[hops[-1].channel, wire.target] += 1
        for wire, hops in self._ways():
            last = hops[-1]
            from_one = going[last.channel, last.net] if isinstance(last.net, s.WireEnd) else 1
            if coming[last.channel, wire.target] > from_one:
                hops[-1] = last._replace(net=wire.target)

    def arrangement(self) -> s.Layout:
        """Put everything in order and in place."""
        links = [_link(hop, self._heights) for hops in self._hops for hop in hops]
        chains = [[hop.end.node for hop in hops[:-1]] for hops in self._hops]
        self._columns = ordered(self._columns, links, chains)
        self._tops = self._settled()
        channels = self._channels()
        columns, width = self._x(channels)
        places = [self._place(box, columns) for box in range(len(self._boxes))]
        starts = [left - channels[i] for i, (left, _) in enumerate(columns)]
        starts.append(columns[-1][1])
        paths = [self._path(wire, hops, places, starts) for wire, hops in self._ways()]
        joined = [
            (_x_of(starts[channel], piece.track), y)
            for channel, routes_of in enumerate(self._routes)
            for route in routes_of.values()
            for piece in route
            for y in joints(piece.net)
        ]
        corners = [point for path in paths for point in path]
        tops = [y for _, y in corners] + [y for _, y in places]
        bottoms = [y for _, y in corners]
        bottoms += [y + size.height for (_, y), size in zip(places, self._sizes, strict=True)]
        top = min(tops)
        return s.Layout(
            s.Size(width, max(bottoms) - top),
            tuple((x, y - top) for x, y in places),
            tuple(tuple((x, y - top) for x, y in path) for path in paths),
            tuple((x, y - top) for x, y in joined),
        )

    def _ways(self) -> list[tuple[s.Wire, list[Hop]]]:
        return list(zip(self._wires, self._hops, strict=True))

    def _way(self, wire: s.Wire) -> list[Hop]:
        """Return the hops of a wire, adding a node to each column that it passes."""
        at, to = self._channel(wire.source), self._channel(wire.target)
        step = 1 if to >= at else -1
        stop = self._stop(wire.source)
        net: object = wire.source
        hops: list[Hop] = []
        while at != to:
            column = at if step > 0 else at - 1
            node = len(self._heights)
            self._heights.append(0)
            self._columns[column].append(node)
            ends = (s.RIGHT, s.LEFT) if step > 0 else (s.LEFT, s.RIGHT)
            hops.append(Hop(at, stop, Stop(node, 0, ends[0]), net))
            stop, net = Stop(node, 0, ends[1]), node
            at += step
        hops.append(Hop(at, stop, self._stop(wire.target), net))
        return hops

    def _channel(self, end: s.WireEnd) -> int:
        port = self._boxes[end.box].ports[end.port]
        return self._rank[end.box] + (port.side == s.RIGHT)

    def _stop(self, end: s.WireEnd) -> Stop:
        box = self._boxes[end.box]
        # The right side of a box faces the left side of its channel.
        side = s.LEFT if box.ports[end.port].side == s.RIGHT else s.RIGHT
        return Stop(end.box, self._offsets[end.box][end.port], side)

    def _settled(self) -> dict[int, int]:
        """Return the distance of each node from the top."""
        pulls: dict[int, tuple[list[Pull], list[Pull]]] = {
            node: ([], []) for column in self._columns for node in column
        }
        for hops in self._hops:
            for hop in hops:
                self._pull(hop, pulls)
        gaps = [self._gaps(column) for column in self._columns]
        places = heights(
            self._columns, gaps, [[pulls[node] for node in column] for column in self._columns]
        )
        slide(places, self._columns, gaps, [self._chain(hops) for hops in self._hops])
        return {node: round(place) for node, place in places.items()}

    def _chain(self, hops: Sequence[Hop]) -> Chain:
        """Return the nodes that a wire passes, and where its ports are."""
        first, last = hops[0].start, hops[-1].end
        nodes = tuple(hop.end.node for hop in hops[:-1])
        return Chain(nodes, (first.node, first.offset), (last.node, last.offset))

    def _pull(self, hop: Hop, pulls: dict[int, tuple[list[Pull], list[Pull]]]) -> None:
        start, end = hop.start, hop.end
        count = self._solid
        passing = (start.node >= count) + (end.node >= count)
        is_turn = start.side == end.side
        # A turn is near its box where nothing else matters.
        weight = 0 if is_turn else (1, 2, 8)[passing]
        for one, other in ((start, end), (end, start)):
            if is_turn and one.node < count:
                continue
            # At the left side of a channel is the right side of a node.
            index = 1 if one.side == s.LEFT else 0
            pulls[one.node][index].append(Pull(other.node, other.offset - one.offset, weight))

    def _gaps(self, column: Sequence[int]) -> list[float]:
        count = self._solid
        gaps = [0.0]
        for above, below in pairwise(column):
            passing = (above >= count) + (below >= count)
            gap = (_BOX_GAP, _MIXED_GAP, _WIRE_GAP)[passing]
            gaps.append(float(self._heights[above] + gap))
        return gaps[: len(column)]

    def _channels(self) -> list[int]:
        """Find the vertical lines of all wires, and return the width of each channel."""
        sides_of: list[dict[object, tuple[list[int], list[int]]]] = [
            {} for _ in range(len(self._columns) + 1)
        ]
        for hops in self._hops:
            for hop in hops:
                sides = sides_of[hop.channel].setdefault(hop.net, ([], []))
                for stop in (hop.start, hop.end):
                    sides[stop.side == s.RIGHT].append(self._tops[stop.node] + stop.offset)
        widths = []
        for channel, known in enumerate(sides_of):
            nets = [Net(tuple(lefts), tuple(rights)) for lefts, rights in known.values()]
            found = routes(nets)
            self._routes.append(dict(zip(known, found, strict=True)))
            last = max((piece.track for route in found for piece in route), default=-1)
            is_outside = channel in (0, len(self._columns))
            margin = 0 if is_outside and last < 0 else 2 * _MARGIN
            widths.append(margin + max(0, last) * _TRACK)
        return widths

    def _x(self, channels: Sequence[int]) -> tuple[list[tuple[int, int]], int]:
        """Return where each column begins and ends, and the width of all."""
        x = 0
        columns = []
        for index, column in enumerate(self._columns):
            x += channels[index]
            widest = max((self._sizes[n].width for n in column if n < len(self._boxes)), default=0)
            columns.append((x, x + widest))
            x += widest
        return columns, x + channels[-1]

    def _place(self, box: int, columns: Sequence[tuple[int, int]]) -> s.Point:
        left, right = columns[self._rank[box]]
        return left + (right - left - self._sizes[box].width) // 2, self._tops[box]

    def _path(
        self, wire: s.Wire, hops: Sequence[Hop], places: Sequence[s.Point], starts: Sequence[int]
    ) -> tuple[s.Point, ...]:
        points = [self._port(wire.source, places)]
        for hop in hops:
            points += self._corners(hop, starts[hop.channel])
        points.append(self._port(wire.target, places))
        return tuple(simplified(points))

    def _corners(self, hop: Hop, start: int) -> list[s.Point]:
        """Return the corners of a wire in a channel that begins at `start`."""
        route = self._routes[hop.channel][hop.net]
        if not route:
            return []
        y, z = (self._tops[stop.node] + stop.offset for stop in (hop.start, hop.end))
        sides = [0 if stop.side == s.LEFT else len(route) - 1 for stop in (hop.start, hop.end)]
        x, u = (_x_of(start, route[side].track) for side in sides)
        if sides[0] == sides[1]:
            return [(x, y), (u, z)]
        (bend,) = route[0].net.rights
        return [(x, y), (x, bend), (u, bend), (u, z)]

    def _port(self, end: s.WireEnd, places: Sequence[s.Point]) -> s.Point:
        box = self._boxes[end.box]
        x, y = places[end.box]
        right = self._sizes[end.box].width if box.ports[end.port].side == s.RIGHT else 0
        return x + right, y + self._offsets[end.box][end.port]


def _x_of(start: int, track: int) -> int:
    return start + _MARGIN + track * _TRACK


def _link(hop: Hop, heights: Sequence[int]) -> EdgePiece:
    def at(stop: Stop) -> float:
        return stop.offset / heights[stop.node] if heights[stop.node] else 0.5

    start, end = hop.start, hop.end
    if start.side == end.side:
        return EdgePiece(
            start.node, end.node, at(start), at(end), 1 if start.side == s.LEFT else -1
        )
    left, right = (start, end) if start.side == s.LEFT else (end, start)
    return EdgePiece(left.node, right.node, at(left), at(right))


def simplified(points: Sequence[s.Point]) -> list[s.Point]:
    """Leave out corners that are none."""
    kept: list[s.Point] = []
    for point in points:
        if kept and kept[-1] == point:
            continue
        if len(kept) >= 2 and _is_straight(kept[-2], kept[-1], point):
            kept.pop()
        kept.append(point)
    return kept


def _is_straight(one: s.Point, two: s.Point, three: s.Point) -> bool:
    return one[0] == two[0] == three[0] or one[1] == two[1] == three[1]
