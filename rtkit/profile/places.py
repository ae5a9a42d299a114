"""Locates elements: XPaths in the document as it was read, before any repair."""

from __future__ import annotations

from collections import Counter
from typing import Any

from rtkit.profile.xmlnames import short, split


class ElementPaths:
    """XPaths of one document, each found out once.

    A path is asked for before its element is moved or renamed, and then stays what it was: the
    children of a parent are numbered as they stand when the first of them is asked for.
    """

    def __init__(self) -> None:
        # Keys are kept alive by being keys, else lxml would make other proxies for the elements.
        self._paths: dict[Any, str] = {}
        self._numbered: set[Any] = set()
        self._added: set[Any] = set()

    def path(self, element: Any, attribute: str | None = None) -> str:
        """Return the XPath of `element`, or of its attribute ``{namespace}local``."""
        path = self._element(element)
        if element in self._added:
            return path
        return path if attribute is None else f"{path}/@{_name_test(attribute)}"

    def keep(self, parent: Any) -> None:
        """Find the paths of what is below `parent`, because something is to be added there."""
        self._number(parent, self._element(parent))

    def share(self, added: Any, like: Any) -> None:
        """Give an element that is not in the document the place of `like`."""
        self._added.add(added)
        self._paths[added] = self._element(like)

    def _element(self, element: Any) -> str:
        known = self._paths.get(element)
        if known is not None:
            return known
        parent = element.getparent()
        if parent is None:
            path = f"/{_name_test(element.tag)}"
        else:
            above = self._element(parent)
            path = self._below(element, parent, above)
        self._paths[element] = path
        return path

    def _below(self, element: Any, parent: Any, above: str) -> str:
        if parent not in self._added:
            self._number(parent, above)
            if element in self._paths:
                return self._paths[element]
        # An element that a repair added is not in the document: its parent is.
        self._added.add(element)
        return above

    def _number(self, parent: Any, above: str) -> None:
        if parent in self._numbered or parent in self._added:
            return
        self._numbered.add(parent)
        children = [child for child in parent if child not in self._paths]
        counts = Counter(child.tag for child in children)
        numbers: Counter[str] = Counter()
        for child in children:
            tag = child.tag
            numbers[tag] += 1
            number = f"[{numbers[tag]}]" if counts[tag] > 1 else ""
            self._paths[child] = f"{above}/{_name_test(tag)}{number}"


def _name_test(name: str) -> str:
    """Return the XPath 1.0 test of a name: prefixed where there is a usual prefix."""
    written = short(name)
    if written[:1] != "{":
        return written
    namespace, local = split(name)
    if "'" in namespace:
        # XPath 1.0 has no escapes in its texts.
        return f"*[local-name()='{local}']"
    return f"*[local-name()='{local}' and namespace-uri()='{namespace}']"
