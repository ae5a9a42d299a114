"""Calls operations of service ports, with values of Python."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.tree.client import Tree


def call(tree: Tree, typed: str, arguments: Sequence[Any], timeout_s: float) -> Any:
    """Call an operation; see `rtkit.api.tree.Tree.call`."""
    from rtkit.probe.calling import chosen, operations_at
    from rtkit.rtc.names import parse_path

    path = parse_path(typed)
    if path.port is None:
        raise Malformed(f"No port specified: {typed} (it is COMPONENT:PORT.OPERATION)")
    operations, name = operations_at(tree, path)
    operation = chosen(operations, name)
    found = operation.call(
        tree, operation.arguments([_text(each) for each in arguments]), timeout_s
    )
    return found.get("") if found.keys() <= {""} else found


def _text(value: Any) -> str:
    """Return a value as the text that is typed for it; a text is it already."""
    from rtkit.probe.value_text import plain

    return value if isinstance(value, str) else json.dumps(plain(value))
