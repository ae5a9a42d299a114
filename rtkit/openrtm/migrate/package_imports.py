"""Imports of siblings in packages, which Python 2 found without a dot before their names."""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterator

from rtkit.openrtm.migrate.lost_names import Loss
from rtkit.openrtm.migrate.python2_names import IsBeside
from rtkit.openrtm.migrate.source_edits import Edit, SourcePlaces

_FROM = re.compile(r"from\s+")


def is_beside(file: str, module: str) -> bool:
    """Return whether a file has a sibling of that name, which it imports in place of others."""
    place = os.path.join(os.path.dirname(file), module)
    return os.path.isfile(f"{place}.py") or os.path.isfile(os.path.join(place, "__init__.py"))


def sibling_imports(tree: ast.Module, data: bytes, has_sibling: IsBeside) -> Iterator[Loss]:
    """Yield the imports of a module in a package that want a dot.

    Args:
        tree: The source, parsed.
        data: The same in UTF-8.
        has_sibling: Tells the siblings.
    """
    places = SourcePlaces(data)
    for node in ast.walk(tree):
        match node:
            case ast.ImportFrom(module=str(module), level=0) if has_sibling(
                module.partition(".")[0]
            ):
                found = _FROM.match(places.text(node))
                assert found is not None
                at = places.begin(node) + len(found[0].encode())
                yield Loss(node.lineno, f"import of {module} beside it", (Edit(at, at, "."),))
            case ast.Import(names=names):
                near = [each for each in names if has_sibling(each.name.partition(".")[0])]
                if near:
                    what = f"import of {near[0].name} beside it"
                    yield _with_dots(node, near, what, places)


def _with_dots(node: ast.Import, near: list[ast.alias], what: str, places: SourcePlaces) -> Loss:
    others = [each for each in node.names if each not in near]
    if any("." in each.name for each in near):  # it binds the name of the outer one
        return Loss(node.lineno, what, (), f"{what}: Python 3 wants from . import")
    texts = [ast.unparse(ast.ImportFrom(None, near, 1))]
    texts += [ast.unparse(ast.Import(others))] if others else []
    return Loss(node.lineno, what, (places.whole(node, "; ".join(texts)),))
