"""Translates names between the two sides of a proxy, and restricts which may be set."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase

from rtkit.property.codes import PropertyError
from rtkit.property.naming import canonical
from rtkit.property.reading import read
from rtkit.property.registry import as_value
from rtkit.property.values import Value, is_number
from rtkit.property.writing import write

_LISTED = "properties"


class PrefixedNames:
    """Puts a prefix in front of all names, as they are seen at this side.

    Args:
        prefix: Parts joined by dots; empty for none.
        place: Part of the owner that is meant, by its name there; empty for all of it.

    Raises:
        PropertyError: The prefix is no name.
    """

    def __init__(self, prefix: str = "", place: str = "") -> None:
        self.prefix = canonical(prefix) if prefix else ""
        self._place = f"{canonical(place)}." if place else ""
        self._inner = [""]
        for part in self.prefix.split("."):
            self._inner.append(f"{self._inner[-1]}.{part}".lstrip("."))

    def inward(self, name: str) -> str:
        """Return how the owner calls what is called `name` here.

        Raises:
            PropertyError: ``unknown``: it has another prefix.
        """
        prefix = self.prefix
        if not prefix:
            return name
        if name == prefix:
            return self._place + _LISTED
        if name.startswith(f"{prefix}."):
            return self._place + name[len(prefix) + 1 :]
        raise PropertyError("unknown", f"no such property: {name}")

    def outward(self, name: str) -> str:
        """Return how is called here what the owner calls `name`."""
        inner = f"{name}."[len(self._place) :].rstrip(".")
        return f"{self.prefix}.{inner}".rstrip(".") if self.prefix else name

    def above(self, name: str) -> str | None:
        """Return the inner name above the prefix whose names `name` asks for, None if it is none.

        Those the owner does not know.
        """
        if not self.prefix:
            return None
        place = "" if name == _LISTED else name.removesuffix(f".{_LISTED}")
        return place if place in self._inner[:-1] else None

    def listed(self, place: str) -> str:
        """Return the names one step below an inner name."""
        rest = self.prefix[len(place) :].lstrip(".")
        return write((as_value(rest.partition(".")[0]),))

    def shown_of_owner(self, place: str, options: dict[str, Value]) -> str:
        """Return the parameter for a listing of what of the owner is shown, empty for nothing."""
        depth = options.get("depth", 1)
        if options.get("all") or "names" in options or not is_number(depth):
            return "all"
        below = depth - self.prefix[len(place) :].lstrip(".").count(".") - 1  # type: ignore[operator]
        return f"depth={below}" if below > 0 else ""

    def widened(self, place: str, listing: str, options: dict[str, Value]) -> str:
        """Return a listing of all that the owner has, as it is seen from an inner name.

        The listing holds names; or lists that begin with one, as ``values`` and ``meta`` give them.
        The options are those of ``properties``.
        """
        rest = self.prefix[len(place) :].lstrip(".")
        steps = rest.split(".")
        entries: dict[str, Value] = {}
        for end in range(1, len(steps) + 1):
            name = ".".join(steps[:end])
            if not options.get("values"):
                entries[name] = (as_value(name),) if options.get("meta") else as_value(name)
        for item in _items(read(listing)):
            head, *more = item if isinstance(item, tuple) else (item,)
            name = f"{rest}.{head}"
            entries[name] = (as_value(name), *more) if isinstance(item, tuple) else as_value(name)
        return write(tuple(entries[name] for name in _chosen(entries, options)))


def _chosen(entries: dict[str, Value], options: dict[str, Value]) -> list[str]:
    if "names" in options:
        names = [canonical(str(each)) for each in _items(options["names"])]
        for name in names:
            if name not in entries:
                raise PropertyError("unknown", f"no such property: {name}")
    else:
        depth = options.get("depth", 1)
        if not is_number(depth):
            raise PropertyError("bad-parameter", "depth is a number")
        is_deep = bool(options.get("all"))
        names = [each for each in entries if is_deep or each.count(".") < depth]  # type: ignore[operator]
    pattern = str(options.get("match", "*"))
    return [each for each in names if fnmatchcase(each, pattern)]


def _items(value: Value) -> tuple[Value, ...]:
    return value if isinstance(value, tuple) else ()


class Allowed:
    """Properties that may be set: those whose names match a pattern."""

    def __init__(self, patterns: Sequence[str] = ()) -> None:
        self._patterns = patterns

    def __call__(self, name: str) -> bool:
        """Return whether a name may be set; a list of names only if all that it could hold may."""
        if name == _LISTED or name.endswith(f".{_LISTED}"):
            below = name.removesuffix(_LISTED)
            return any(_covers(pattern, below) for pattern in self._patterns)
        return any(fnmatchcase(name, pattern) for pattern in self._patterns)


def _covers(pattern: str, below: str) -> bool:
    """Return whether a pattern matches every name that begins so."""
    plain = pattern[:-1]
    is_plain = not any(mark in plain for mark in "*?[")
    return pattern.endswith("*") and is_plain and below.startswith(plain)
