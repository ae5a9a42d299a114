"""Suggests component types in place of an unknown one: the nearest, else some."""

from __future__ import annotations

from collections.abc import Collection

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.modules.describing import describe
from rtkit.modules.search import SUFFIX, Search
from rtkit.rtc.nearest import did_you_mean, nearest

_SHORT = 5
_MOST_FILES = 200
_MOST_NEAR = 20


def instead(
    type_name: str, registered: Collection[str], standard: Collection[str], search: Search | None
) -> str:
    """Return the end of the message that a type is not known.

    Args:
        type_name: Type that was asked for.
        registered: The types that are offered already.
        standard: Those that are there without a module.
        search: Where modules are found by the names of their types; None where they are not.
    """
    there = {*registered, *standard}
    names = () if search is None else tuple(each.removesuffix(SUFFIX) for each in search.modules())
    likely = nearest(type_name, [*there, *names], _MOST_NEAR)
    near = [name for name in likely if name in there or _is_offered(search, name)]
    if near:
        return did_you_mean(type_name, near)
    found = [name for name in names[:_MOST_FILES] if _is_offered(search, name)]
    known = sorted({*registered, *found})
    if not known:
        return "; none is known here (rtmgr -l loads a module)"
    more = len(known) - _SHORT
    rest = f" and {more} more (rtmgr -m lists them)" if more > 0 else ""
    return f"; there are: {', '.join(known[:_SHORT])}{rest}"


def _is_offered(search: Search | None, name: str) -> bool:
    """Return whether the module of that name would offer the type of that name."""
    if search is None:
        return False
    try:
        source = search.read(f"{name}{SUFFIX}")
        offers = describe(source.text, source.file, source.init, source.package)
    except (Refused, NotFound, Malformed):
        return False
    return any(offer.type.type_name == name for offer in offers or ())
