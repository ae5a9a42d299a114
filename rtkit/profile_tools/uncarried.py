"""Finds content that no model holds and that rewriting a document loses: mostly comments."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rtkit.profile.common import Note
from rtkit.profile.forms import XML, YAML

_RULE = "comment-dropped"


def uncarried(data: bytes, form: str) -> list[Note]:
    """Return a note for each comment and processing instruction of a document that is valid."""
    if form == XML:
        return list(_of_xml(data)) if b"<!--" in data or data.count(b"<?") > 1 else []
    return list(_of_yaml(data)) if form == YAML and b"#" in data else []


def _of_xml(data: bytes) -> Iterator[Note]:
    from lxml import etree

    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    tree = etree.fromstring(data, parser).getroottree()
    nodes: Any = tree.xpath("//comment() | //processing-instruction()")
    for node in nodes:
        is_comment = node.tag is etree.Comment
        what = "comment" if is_comment else f"processing instruction {node.target}"
        yield _note(node.sourceline or 1, what, (node.text or "") if is_comment else "")


def _of_yaml(data: bytes) -> Iterator[Note]:
    import yaml

    from rtkit.profile.tree_read import decoded

    text = decoded(data, "")
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    end = 0
    for token in yaml.scan(text, Loader=loader):
        # Comments are all that lies between tokens, beside blanks.
        yield from _comments(text, end, token.start_mark.index)
        end = token.end_mark.index


def _comments(text: str, start: int, end: int) -> Iterator[Note]:
    line = text.count("\n", 0, start) + 1
    for number, part in enumerate(text[start:end].split("\n")):
        _, mark, comment = part.partition("#")
        if mark:
            yield _note(line + number, "comment", comment)


def _note(line: int, what: str, text: str) -> Note:
    shown = " ".join(text.split())
    quoted = f" {shown[:40]!r}" if shown else ""
    return Note(line, f"{what}{quoted} is no part of the profile and left out", rule=_RULE)
