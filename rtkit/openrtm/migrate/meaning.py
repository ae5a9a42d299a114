"""Changes in a source that 2to3 leaves out: lost names, divisions, texts that were decoded."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from rtkit.openrtm.migrate.integers import divisions
from rtkit.openrtm.migrate.lost_names import Loss
from rtkit.openrtm.migrate.source_edits import Edit, Remark, SourcePlaces, with_edits


def without_losses(text: str, found: Iterable[Loss]) -> tuple[str, list[Remark]]:
    """Return a source without what is lost, and what is left to look at."""
    losses = list(found)
    remarks = {Remark(each.line, each.remark) for each in losses if each.remark}
    return with_edits(text.encode(), (e for each in losses for e in each.edits)), sorted(remarks)


def as_python2_meant(
    text: str, tree: ast.Module, *, divides_whole: bool
) -> tuple[str, list[Remark]]:
    """Return a source that was Python 2 with what means something else in 3, and the same.

    Args:
        text: Of Python 3.
        tree: The same, parsed.
        divides_whole: In it ``/`` of two whole numbers has rounded down so far.
    """
    data = text.encode()
    places = SourcePlaces(data)
    edits, remarks = list(_decoded(tree, places)), list(_remarks(tree))
    if divides_whole:
        for each in divisions(tree):
            if each.is_of_integers:
                edits.append(places.operator(each.node))
            elif each.is_open:
                why = "/ may have divided whole numbers, which Python 2 rounds down"
                remarks.append(Remark(each.node.lineno, why))
    return with_edits(data, edits), sorted(set(remarks))


def _decoded(tree: ast.Module, places: SourcePlaces) -> Iterator[Edit]:
    """Yield changes of ``unicode(x, encoding)``: what it decoded may be text already.

    `str` took one argument in Python 2, so that one with two was `unicode`.
    """
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Name(id="str"), args=[value, _, *_]) if _is_simple(value):
                begin, end = places.begin(node), places.end(node)
                name = places.text(value)
                text = f"({name} if isinstance({name}, str) else {places.text(node)})"
                yield Edit(begin, end, text)


def _is_simple(node: ast.expr) -> bool:
    """Return whether an expression may be evaluated twice."""
    match node:
        case ast.Name():
            return True
        case ast.Attribute(value=value):
            return _is_simple(value)
        case ast.Subscript(value=value, slice=ast.Constant() | ast.Name()):
            return _is_simple(value)
    return False


def _remarks(tree: ast.Module) -> Iterator[Remark]:
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Attribute(attr="encode" | "decode" as name)):
                why = f"{name}: texts and bytes are two kinds in Python 3"
                yield Remark(node.lineno, why)
