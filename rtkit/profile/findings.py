"""Collects a reader's findings: repairs, remarks and errors, each with its line and XPath."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

from rtkit.errors import InvalidDocument
from rtkit.profile.common import Note
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


FAR_LINE = 65535
"""From here on libxml2 keeps the lines of elements in the text around them, or not at all."""

_SHOWN = 50
_TOO_MANY = 1000
_MOST_REPAIRS = 50_000


class InvalidProfile(InvalidDocument):
    """A profile that cannot be accepted.

    Attributes:
        source: The document, as messages name it.
        problems: All that was found wrong, by line.
    """

    def __init__(self, source: str, problems: Iterable[Note]) -> None:
        self.source = source
        self.problems = tuple(dict.fromkeys(sorted(problems)))
        distinct = dict.fromkeys((note.line, note.text) for note in self.problems)
        shown = [f"{source}:{line}: {text}" for line, text in list(distinct)[:_SHOWN]]
        if len(distinct) > _SHOWN:
            shown.append(f"{source}: … and {len(distinct) - _SHOWN} more problems")
        super().__init__("\n".join(shown))


def refused(source: str, line: int, rule: str, why: str) -> InvalidProfile:
    """Return the error that tells of one problem; `rule` is one of `rtkit.profile.rules`."""
    return InvalidProfile(source, [Note(line, why, rule=rule)])


class Findings:
    """Collector of findings; lines are those of the document as it was read.

    Attributes:
        scope: The prefixes, where the whole document has the same ones.
        is_vague: Whether lines from `FAR_LINE` on are not known.
        is_fragment: Whether a component profile has no ``BasicInfo``; None until it was looked for.
        good_types: Values of ``xsi:type`` seen to be right in this scope, with their tables.
    """

    def __init__(
        self, source: str, scope: dict[str | None, str] | None = None, *, is_vague: bool = False
    ) -> None:
        self.source = source
        self.is_vague = is_vague
        self.is_fragment: bool | None = None
        self.scope = scope
        self.good_types: set[tuple[str, Any]] = set()
        self.repairs: list[Note] = []
        self.remarks: list[Note] = []
        self.errors: list[Note] = []
        self._remarked: set[str] = set()
        self._places = ElementPaths()
        self._far: dict[Any, int] = {}
        self._numbers: dict[Any, int] = {}

    def repaired(self, element: Any, rule: str, text: str, **details: str | None) -> None:
        """Record a deviation that was put right; call it before anything is moved."""
        if self._takes_more(self.line(element)):
            self.repairs.append(self._note(element, rule, text, **details))

    def repaired_at(self, line: int, rule: str, text: str) -> None:
        """Record a deviation for which there is no element, only a line."""
        if self._takes_more(line):
            self.repairs.append(Note(line, text, rule=rule))

    def _takes_more(self, line: int) -> bool:
        """Return whether the quota allows one more repair; report once that it does not."""
        count = len(self.repairs)
        if count == _MOST_REPAIRS:
            more = f"and more repairs, after {_MOST_REPAIRS} that were told"
            self.repairs.append(Note(line, more, rule="more"))
        return count < _MOST_REPAIRS

    def remark(self, element: Any, rule: str, text: str, **details: str | None) -> None:
        """Record, once, something that is allowed but worth knowing."""
        if text not in self._remarked and len(self._remarked) < _MOST_REPAIRS:
            self._remarked.add(text)
            self.remarks.append(self._note(element, rule, text, **details))

    def wrong(self, element: Any, rule: str, text: str, **details: str | None) -> None:
        """Record an error that no mode forgives.

        Raises:
            InvalidProfile: There are so many that looking further is of no use.
        """
        self._add_error(self._note(element, rule, text, **details))

    def wrong_at(self, line: int, rule: str, text: str) -> None:
        """Record an error for which there is no element, only a line.

        Raises:
            InvalidProfile: There are so many that looking further is of no use.
        """
        self._add_error(Note(line, text, rule=rule))

    def _add_error(self, note: Note) -> None:
        self.errors.append(note)
        if len(self.errors) > _TOO_MANY:
            raise InvalidProfile(self.source, self.errors)

    def _note(
        self,
        element: Any,
        rule: str,
        text: str,
        *,
        at: str | None = None,
        seen: str | None = None,
        allowed: str | None = None,
    ) -> Note:
        """Make a note; `at` is the attribute that it is about, `seen` what stands there."""
        return Note(self.line(element), text, self.path(element, at), rule, seen, allowed or "")

    def path(self, element: Any, attribute: str | None = None) -> str:
        """Return the XPath of an element, or of its attribute, in the document as it was read."""
        return self._places.path(element, attribute)

    def add(self, parent: Any, tag: str, like: Any) -> Any:
        """Append an element that is not in the document: its line and place are those of `like`."""
        self._places.keep(parent)
        made = parent.makeelement(tag)
        parent.append(made)
        self.set_line(made, self.line(like))
        self._places.share(made, like)
        return made

    def line(self, element: Any) -> int:
        """Return the line of the document that `element` begins on; 0 if nobody knows."""
        return self._far.get(element) or element.sourceline or 0

    def number(self, element: Any) -> int:
        """Return the number of namesakes before this element, as they stood when first asked."""
        if element not in self._numbers:
            counts: Counter[str] = Counter()
            for item in element.getparent():
                self._numbers[item] = counts[item.tag]
                counts[item.tag] += 1
        return self._numbers[element]

    def set_line(self, element: Any, line: int) -> None:
        """Have an element that was not parsed stand on a line."""
        element.sourceline = min(line, FAR_LINE)
        if line > FAR_LINE:
            self._far[element] = line

    def namespaces(self, element: Any) -> dict[str | None, str]:
        """Return the prefixes in force at `element`."""
        return self.scope if self.scope is not None else dict(element.nsmap)
