"""Converts a YAML or JSON tree to elements, as which every profile is checked.

Scalars stay text: the tables of `rtkit.profile.spec` know the type of each of them, so ``0.2``
is a version where a version is meant, and ``no`` a name where a name is.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any, NamedTuple

from rtkit.profile import tree_form as form
from rtkit.profile.findings import Findings, refused
from rtkit.profile.parse import MAX_ATTRIBUTES
from rtkit.profile.rts_model import OrderStep
from rtkit.profile.spec import DATE, FLAG, Attr, Child, ElementSpec
from rtkit.profile.xmlnames import NAMESPACES, XSI_TYPE, clark, short
from rtkit.xmltext import without_bad_characters

MAX_DEPTH = 136
"""Tables and lists nested deeper than this are refused; an element may be both of them."""

MAX_NODES = 450_000
"""A document of more scalars, tables and lists than this is refused."""

_MARKS = (
    (b"\xff\xfe\0\0", "utf-32"),
    (b"\0\0\xfe\xff", "utf-32"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
)
_NULLS = ("", "~", "null", "Null", "NULL")


class ScalarNode(NamedTuple):
    """A scalar; one that is not quoted may stand for something else than text."""

    line: int
    text: str
    is_quoted: bool = False

    @property
    def is_null(self) -> bool:
        """Return whether nothing is there."""
        return not self.is_quoted and self.text in _NULLS


class TableNode(NamedTuple):
    """Keys and their values, in the order of the document; each key is there once."""

    line: int
    items: tuple[tuple[ScalarNode, Node], ...]


class ListNode(NamedTuple):
    """A list."""

    line: int
    items: tuple[Node, ...]


Node = ScalarNode | TableNode | ListNode


def decoded(data: bytes, source: str) -> str:
    """Return the text of a document: UTF-8, or what its byte order mark says.

    Raises:
        InvalidProfile: It is no such text.
    """
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), "utf-8-sig")
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        name = encoding.removesuffix("-sig").upper()
        raise refused(
            source, line, "not-well-formed", f"not {name}: byte {error.start + 1}"
        ) from error


_CHARACTER = "bad-character"
_TRUE, _FALSE = ("true", "yes", "on", "y"), ("false", "no", "off", "n")
PREFIXES = {"rtc": ("rtc", "rtcDoc", "rtcExt", "xsi"), "rts": ("rts", "rtsExt", "xsi")}


def root_of(node: Node, source: str) -> tuple[str, ScalarNode, Node]:
    """Return the kind of a document, its root's key, and the node under it.

    Raises:
        InvalidProfile: It is no profile.
    """
    wanted = " or ".join(form.ROOTS.values())
    keys = node.items if isinstance(node, TableNode) else ()
    keys = tuple(item for item in keys if item[0].text != form.SCHEMA_KEY)
    if len(keys) != 1:
        raise refused(source, node.line, "wrong-root", f"the root is a table of one key, {wanted}")
    ((key, body),) = keys
    for kind, root in form.ROOTS.items():
        if key.text[:1].lower() + key.text[1:] == root:
            return kind, key, body
    why = f"the root is {key.text[:80]!r}; a profile's is {wanted}"
    raise refused(source, key.line, "wrong-root", why)


def elements_of(body: Node, line: int, kind: str, spec: ElementSpec, found: Findings) -> Any:
    """Return the root element for what is under the root's key."""
    from lxml import etree

    prefixes = {prefix: NAMESPACES[prefix] for prefix in PREFIXES[kind]}
    root: Any = etree.Element(clark(f"{kind}:{kind.capitalize()}Profile"), nsmap=prefixes)
    found.set_line(root, line)
    _Filler(found).fill(root, body, spec)
    return root


class _Filler:
    """Fills elements from tables; faults go to the findings, with their lines."""

    def __init__(self, found: Findings) -> None:
        self._found = found
        self._usual: set[tuple[str, str, str]] = set()

    def fill(self, element: Any, body: Node, spec: ElementSpec) -> None:
        if isinstance(body, ScalarNode) and body.is_null:
            return
        if not isinstance(body, TableNode):
            self._wrong(body, f"{short(element.tag)} is a table of its parts")
            return
        if self._has_too_many(body):
            return
        body = self._chosen(body, spec)
        parts: list[tuple[int, Child, Node]] = []
        others: list[tuple[ScalarNode, Node]] = []
        for key, value in _parts(body, spec):
            local = _local(key)
            attribute = spec.known.get(spec.attribute_by_local.get(local, ""))
            if key.text.startswith(form.OWN_KEYS) and isinstance(value, ScalarNode):
                others.append((key, value))
                continue
            if attribute is not None and isinstance(value, ScalarNode):
                self._look_at(key, attribute.name, element.tag)
                self._set(element, attribute, value)
                continue
            ranked = _child_of(spec, local)
            if ranked is not None:
                self._look_at(key, ranked[1].name, element.tag)
                parts.append((*ranked, value))
            elif attribute is not None:
                self._set(element, attribute, value)
            else:
                others.append((key, value))
        # The order of keys means nothing, but the schema fixes the order of elements.
        for _, part, value in sorted(parts, key=lambda each: each[0]):
            self._children(element, part, value)
        for key, value in others:
            if key.text in (form.FOREIGN_ATTRIBUTES, form.FOREIGN_ELEMENTS):
                self._foreign(element, key, value)
            else:
                self._keep(element, key, value)

    def _chosen(self, body: TableNode, spec: ElementSpec) -> TableNode:
        """Return the choice that its parts, standing in its place, mean."""
        if not spec.is_choice or any(_child_of(spec, _local(key)) for key, _ in body.items):
            return body
        for choice in spec.children:
            inner = choice.spec
            if inner is not None and all(_child_of(inner, _local(key)) for key, _ in body.items):
                key = form.key_of(choice.name, choice.name)
                self._found.repaired_at(body.line, "key-name", f"{key!r} is absent: taken as meant")
                return TableNode(body.line, ((ScalarNode(body.line, key), body),))
        return body

    def _look_at(self, key: ScalarNode, name: str, tag: str) -> None:
        """Record a misspelt key, with the key that it was taken as."""
        if (key.text, name, tag) in self._usual:
            return
        usual = form.key_of(name, tag)
        if key.text in (usual, *form.OTHER_WORDS.get(usual, ())):
            self._usual.add((key.text, name, tag))
        else:
            text = f"key {key.text!r} taken as {usual!r}"
            self._found.repaired_at(key.line, "key-name", text)

    def _children(self, element: Any, part: Child, value: Node) -> None:
        is_unit = part.spec is not None and not part.spec.attributes and not part.spec.children
        if isinstance(value, ScalarNode) and value.is_null and not is_unit:
            return
        value = self._whole(part, value)
        for item in value.items if isinstance(value, ListNode) else (value,):
            made = self._made(element, part.name, item)
            if part.spec is None:
                self._text(made, item)
                continue
            if part.spec.xsi_type_text is not None:
                made.set(XSI_TYPE, part.spec.xsi_type_text)
            self.fill(made, item, part.spec)

    def _whole(self, part: Child, value: Node) -> Node:
        """Return the table that a list, standing in its place, means."""
        inner = part.spec.children if part.spec is not None else ()
        if (
            part.is_many
            or not isinstance(value, ListNode)
            or len(inner) != 1
            or not inner[0].is_many
        ):
            return value
        key = form.key_of(inner[0].name, part.name)
        text = f"a list taken as {key!r} of {form.key_of(part.name, part.name)!r}"
        self._found.repaired_at(value.line, "key-name", text)
        return TableNode(value.line, ((ScalarNode(value.line, key), value),))

    def _set(self, element: Any, attribute: Attr, value: Node) -> None:
        if attribute.kind == DATE and isinstance(value, TableNode):
            self._put(element, attribute.name, self._date(value), value)
            return
        if not isinstance(value, ScalarNode):
            self._wrong(value, f"{short(attribute.name)} is one value")
            return
        if value.is_null:
            return
        text = value.text
        if attribute.kind == FLAG and text.lower() in (*_TRUE, *_FALSE):
            text = "true" if text.lower() in _TRUE else "false"
        self._put(element, attribute.name, text, value)

    def _date(self, value: TableNode) -> str:
        parts = {key.text: part.text for key, part in value.items if isinstance(part, ScalarNode)}
        text = form.date_text(parts) if parts.keys() <= set(form.DATE_PARTS) else None
        if text is None or len(parts) != len(value.items):
            self._wrong(value, f"a date has numbers for: {', '.join(form.DATE_PARTS)}", "bad-value")
        return text or ""

    def _keep(self, element: Any, key: ScalarNode, value: Node) -> None:
        """Keep a key that no table knows, for the checks of every profile to judge."""
        name = form.name_of(key.text, element.tag)
        if name is None:
            self._wrong(key, f"no part of a profile: {key.text[:80]!r}", "unknown-key")
        elif isinstance(value, ScalarNode):
            if not value.is_null:
                self._put(element, name, value.text, value)
        else:
            for item in value.items if isinstance(value, ListNode) else (value,):
                made = self._made(element, name, item)
                if made is None:
                    continue
                if not isinstance(item, TableNode):
                    self._text(made, item)
                elif not self._has_too_many(item):
                    for inner, below in item.items:
                        self._keep(made, inner, below)

    def _foreign(self, element: Any, key: ScalarNode, value: Node) -> None:
        if key.text == form.FOREIGN_ATTRIBUTES:
            self._foreign_attributes(element, value)
            return
        for item in value.items if isinstance(value, ListNode) else (value,):
            self._foreign_element(element, item)

    def _foreign_attributes(self, element: Any, value: Node) -> None:
        if not isinstance(value, TableNode):
            self._wrong(value, "foreign attributes are a table of name and text")
            return
        if self._has_too_many(value):
            return
        for name, text in value.items:
            if isinstance(text, ScalarNode):
                self._put(element, name.text, text.text, name)
            else:
                self._wrong(text, f"{name.text[:80]!r} is one value")

    def _foreign_element(self, parent: Any, node: Node) -> None:
        parts = (
            {key.text: value for key, value in node.items} if isinstance(node, TableNode) else {}
        )
        name = parts.get("name")
        if not isinstance(name, ScalarNode) or not parts.keys() <= set(form.FOREIGN_PARTS):
            self._wrong(node, f"a foreign element is a table of: {', '.join(form.FOREIGN_PARTS)}")
            return
        made = self._made(parent, name.text, node)
        if made is None:
            return
        if "attributes" in parts:
            self._foreign_attributes(made, parts["attributes"])
        if "text" in parts:
            self._text(made, parts["text"])
        if "tail" in parts:
            self._text(made, parts["tail"], is_tail=True)
        below = parts.get("children", ListNode(node.line, ()))
        for item in below.items if isinstance(below, ListNode) else (below,):
            self._foreign_element(made, item)

    def _made(self, parent: Any, name: str, node: Node) -> Any:
        """Append an element that bears the line of `node`; None if the name cannot be."""
        from lxml import etree

        try:
            made: Any = etree.SubElement(parent, name)
        except ValueError:
            self._wrong(node, f"not the name of an element: {name[:80]!r}", _CHARACTER)
            return None
        self._found.set_line(made, node.line)
        return made

    def _text(self, element: Any, value: Node, *, is_tail: bool = False) -> None:
        if not isinstance(value, ScalarNode):
            self._wrong(value, f"{short(element.tag)} is text")
            return
        try:
            if is_tail:
                element.tail = value.text
            else:
                element.text = "" if value.is_null else value.text
        except ValueError:
            self._wrong(
                value, f"{short(element.tag)} has a character that no profile can hold", _CHARACTER
            )

    def _put(self, element: Any, name: str, text: str, node: Node) -> None:
        try:
            element.set(name, text)
        except ValueError:
            # The key is there, however wrong: a second error that it is missing would mislead.
            with suppress(ValueError):
                element.set(name, without_bad_characters(text))
            shown = short(name)[:80]
            why = f"{shown} has a name or a character that no profile can hold"
            self._wrong(node, why, _CHARACTER)

    def _has_too_many(self, table: TableNode) -> bool:
        """Return whether a table has more keys than an element may have attributes."""
        if len(table.items) <= MAX_ATTRIBUTES:
            return False
        why = f"more than {MAX_ATTRIBUTES} keys in one table"
        self._wrong(table, why, "too-many-attributes")
        return True

    def _wrong(self, node: Node, why: str, rule: str = "tree-shape") -> None:
        self._found.wrong_at(node.line, rule, why)


def _parts(body: TableNode, spec: ElementSpec) -> Iterator[tuple[ScalarNode, Node]]:
    """Yield the keys of a table; the conditions of a target are one level further down."""
    for key, value in body.items:
        if spec.make is OrderStep and key.text == form.CONDITION and isinstance(value, TableNode):
            yield from value.items
        else:
            yield key, value


def _local(key: ScalarNode) -> str:
    return key.text.rpartition("::")[2]


def _child_of(spec: ElementSpec, local: str) -> tuple[int, Child] | None:
    """Return the place among the children that a key names, and what it is."""
    for name in (local, local[:1].upper() + local[1:]):
        if name in spec.child_by_local:
            return spec.index[spec.child_by_local[name]]
    return None
