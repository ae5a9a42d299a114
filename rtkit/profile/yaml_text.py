"""Reads and writes the YAML of profiles: text to nodes, plain data to text; by PyYAML.

The library's parser only yields events; nothing is ever constructed from a tag. Harmful content
is refused with its line: tags but those of plain data, aliases of anything but scalars,
repeated keys, keys that are no scalars, several documents, nesting and size beyond bounds.

See decision 9.
"""

from __future__ import annotations

from typing import Any, NoReturn

from rtkit.profile.findings import refused
from rtkit.profile.parse import MAX_BYTES
from rtkit.profile.tree_read import MAX_DEPTH, MAX_NODES, ListNode, Node, ScalarNode, TableNode

_SYNTAX, _LARGE, _TAGS, _KEYS = "not-well-formed", "too-large", "tag-or-alias", "repeated-key"
_TOO_DEEP = "too-deep", f"nested deeper than {MAX_DEPTH}"
_CORE = "tag:yaml.org,2002:"
_SCALAR_TAGS = frozenset(f"{_CORE}{name}" for name in ("str", "int", "float", "bool", "null"))
_ALLOWED = {
    "ScalarEvent": _SCALAR_TAGS,
    "MappingStartEvent": frozenset((f"{_CORE}map",)),
    "SequenceStartEvent": frozenset((f"{_CORE}seq",)),
}


def read_yaml(text: str, source: str) -> Node:
    """Return the root of a document.

    Raises:
        InvalidProfile: It is not well-formed, or has what is refused.
    """
    import yaml

    loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    reader = _Reader(source)
    try:
        for event in yaml.parse(text, Loader=loader):
            reader.take(event)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        why = " ".join(f"{error.context or ''} {error.problem or ''}".split())
        line = mark.line + 1 if mark else 1
        if "nesting depth" in why:  # Some builds of libyaml read ahead, to a bound of their own.
            raise refused(source, line, *_TOO_DEEP) from error
        raise refused(source, line, _SYNTAX, f"not YAML: {why}") from error
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        raise refused(
            source, line, _SYNTAX, "not YAML: a character that may not be in it"
        ) from error
    return reader.root or ScalarNode(1, "")


class _Open:
    """A table or list whose end has not come yet."""

    __slots__ = ("is_table", "items", "key", "keys", "line")

    def __init__(self, line: int, is_table: bool) -> None:
        self.line = line
        self.is_table = is_table
        self.items: list[Any] = []
        self.keys: set[str] = set()
        self.key: ScalarNode | None = None


class _Reader:
    """Puts events together, without recursion, and refuses what is beyond bounds."""

    def __init__(self, source: str) -> None:
        self.root: Node | None = None
        self._source = source
        self._open: list[_Open] = []
        self._anchors: dict[str, ScalarNode | None] = {}
        self._known: dict[str, str] = {}
        self._documents = 0
        self._nodes = 0
        self._copied = 0

    def take(self, event: Any) -> None:
        kind = type(event).__name__
        line = event.start_mark.line + 1
        if kind == "ScalarEvent":
            self._check(kind, event, line)
            is_text = event.tag is None or event.tag == f"{_CORE}str"
            is_quoted = bool(event.style) or event.tag == f"{_CORE}str"
            value = self._known.setdefault(event.value, event.value)
            text = ScalarNode(line, value, is_quoted and is_text)
            self._remember(event.anchor, text)
            self._add(text)
        elif kind in _ALLOWED:
            self._check(kind, event, line)
            self._remember(event.anchor, None)
            if len(self._open) >= MAX_DEPTH:
                self._refuse(line, *_TOO_DEEP)
            if self._open and self._open[-1].is_table and self._open[-1].key is None:
                self._refuse(line, _SYNTAX, "a key is a table or list; it must be a text")
            self._open.append(_Open(line, kind == "MappingStartEvent"))
        elif kind in ("MappingEndEvent", "SequenceEndEvent"):
            done = self._open.pop()
            make = TableNode if done.is_table else ListNode
            self._add(make(done.line, tuple(done.items)))
        elif kind == "AliasEvent":
            self._add(self._alias(event.anchor, line))
        elif kind == "DocumentStartEvent":
            self._documents += 1
            if self._documents > 1:
                self._refuse(line, _SYNTAX, "a second document; a profile is one")

    def _check(self, kind: str, event: Any, line: int) -> None:
        self._nodes += 1
        if self._nodes > MAX_NODES:
            self._refuse(line, _LARGE, f"more than {MAX_NODES} entries; no profile has so many")
        if event.tag is not None and event.tag != "!" and event.tag not in _ALLOWED[kind]:
            self._refuse(
                line, _TAGS, f"tag {event.tag[:80]!r} is not allowed: a profile is plain data"
            )

    def _remember(self, anchor: str | None, text: ScalarNode | None) -> None:
        if anchor is not None:
            self._anchors[anchor] = text

    def _alias(self, anchor: str, line: int) -> ScalarNode:
        if anchor not in self._anchors:
            self._refuse(line, _SYNTAX, f"alias *{anchor} has no anchor before it")
        text = self._anchors[anchor]
        if text is None:
            self._refuse(
                line, _TAGS, f"alias *{anchor} stands for a table or list: only texts may be"
            )
        self._nodes += 1
        self._copied += len(text.text)
        if self._copied > MAX_BYTES or self._nodes > MAX_NODES:
            self._refuse(line, _LARGE, "aliases make the document larger than a profile may be")
        return text._replace(line=line)

    def _add(self, node: Node) -> None:
        if not self._open:
            self.root = node
            return
        top = self._open[-1]
        if not top.is_table:
            top.items.append(node)
        elif top.key is not None:
            top.items.append((top.key, node))
            top.key = None
        elif not isinstance(node, ScalarNode):
            self._refuse(node.line, _SYNTAX, "a key is a table or list; it must be a text")
        elif node.text in top.keys:
            self._refuse(node.line, _KEYS, f"key {node.text[:80]!r} is there twice")
        else:
            top.keys.add(node.text)
            top.key = node

    def _refuse(self, line: int, rule: str, why: str) -> NoReturn:
        raise refused(self._source, line, rule, why)


def write_yaml(data: dict[str, Any]) -> str:
    """Return plain data as YAML in block style, keys in the order of `data`."""
    import yaml

    base: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)

    class Dumper(base):  # type: ignore[misc]
        """Quotes names with ``::``, which some readers take for a key; never uses anchors."""

        def ignore_aliases(self, data: Any) -> bool:
            return True

    def text(dumper: Any, value: str) -> Any:
        style = '"' if "::" in value else None
        return dumper.represent_scalar(f"{_CORE}str", value, style=style)

    Dumper.add_representer(str, text)
    written: str = yaml.dump(
        data,
        Dumper=Dumper,
        allow_unicode=True,
        sort_keys=False,
        default_flow_style=False,
        width=2**30,
        indent=2,
    )
    return written
