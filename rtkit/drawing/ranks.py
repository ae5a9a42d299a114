"""Assigns columns to the nodes of a graph: edges go to the right, as few as possible back."""

from __future__ import annotations

from collections.abc import Sequence

Edge = tuple[int, int]


def backward_edges(count: int, edges: Sequence[Edge], first: Sequence[int] = ()) -> set[int]:
    """Return the edges to reverse so that no circle remains.

    After Eades, Lin and Smyth: nodes without predecessors to the left, those without successors
    to the right, of the others first the one with most more edges out than in. Some nodes may be
    stated to be the first.
    """
    place = {node: index for index, node in enumerate(_greedy_order(count, edges, first))}
    return {i for i, (source, target) in enumerate(edges) if place[source] >= place[target]}


def _greedy_order(count: int, edges: Sequence[Edge], first: Sequence[int]) -> list[int]:
    after: list[list[int]] = [[] for _ in range(count)]
    before: list[list[int]] = [[] for _ in range(count)]
    for source, target in edges:
        if source != target:
            after[source].append(target)
            before[target].append(source)
    outs, ins = [len(each) for each in after], [len(each) for each in before]
    left: list[int] = []
    right: list[int] = []
    todo = dict.fromkeys(range(count))

    def take(node: int, where: list[int]) -> None:
        del todo[node]
        where.append(node)
        for other in after[node]:
            ins[other] -= 1
        for other in before[node]:
            outs[other] -= 1

    for node in first:
        take(node, left)
    while todo:
        ends = [node for node in todo if outs[node] == 0 and ins[node]]
        starts = [node for node in todo if ins[node] == 0]
        if ends:
            take(ends[-1], right)
        elif starts:
            take(starts[0], left)
        else:
            take(max(todo, key=lambda node: (outs[node] - ins[node], -node)), left)
    return left + right[::-1]


def ranks(count: int, edges: Sequence[Edge], first: Sequence[int] = ()) -> list[int]:
    """Return the column of each node, from 0; edges are kept short, and lead back if they must."""
    turned = backward_edges(count, edges, first)
    back = (edges[index] for index in sorted(turned))
    forward = [edge for index, edge in enumerate(edges) if index not in turned]
    return _ranks(count, forward + [(b, a) for a, b in back if a != b])


def _ranks(count: int, edges: Sequence[Edge]) -> list[int]:
    """Return the same for a graph without circles."""
    order = _topological(count, edges)
    before: list[list[int]] = [[] for _ in range(count)]
    after: list[list[int]] = [[] for _ in range(count)]
    for source, target in edges:
        after[source].append(target)
        before[target].append(source)
    rank = [0] * count
    for node in order:
        rank[node] = max((rank[other] + 1 for other in before[node]), default=0)
    for _ in range(4):
        for node in reversed(order):
            if after[node] and len(after[node]) >= len(before[node]):
                # Nothing pulls it to the left more than to the right.
                rank[node] = min(rank[other] for other in after[node]) - 1
        for node in order:
            if before[node] and len(before[node]) > len(after[node]):
                rank[node] = max(rank[other] for other in before[node]) + 1
    least = min(rank, default=0)
    return [each - least for each in rank]


def _topological(count: int, edges: Sequence[Edge]) -> list[int]:
    ins = [0] * count
    after: list[list[int]] = [[] for _ in range(count)]
    for source, target in edges:
        after[source].append(target)
        ins[target] += 1
    ready = [node for node in range(count) if ins[node] == 0]
    order = []
    for node in ready:
        order.append(node)
        for other in after[node]:
            ins[other] -= 1
            if ins[other] == 0:
                ready.append(other)
    return order
