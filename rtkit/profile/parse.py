"""Parses bytes into an XML tree, refusing content that no profile has.

Hostile documents end here: document type declarations (and so every entity), huge or deeply
nested ones, anything that is not well-formed. Nothing else is opened, no network is used.
"""

from __future__ import annotations

import re
from typing import Any

from rtkit.profile.common import Note
from rtkit.profile.findings import InvalidProfile, refused
from rtkit.profile.xmlnames import short

MAX_BYTES = 12 * 2**20
MAX_ATTRIBUTES = 200
MAX_DEPTH = 64
"""Elements nested deeper than this are refused; real profiles need about ten."""

_LONG_TAG = 5 * MAX_ATTRIBUTES
"""A tag that has more attributes is longer, in bytes."""

_MAX_TAGS = 150_000
_MAX_EQUALS = 300_000
_MAX_NAMESPACES = 1_000
_LARGE = "too-large"
# Compiled at first use: most documents need none of them.
_BEFORE_ROOT = rb"(?:\xef\xbb\xbf)?(?:\s+|<\?.*?\?>|<!--.*?-->)*"
_PLACE = r"(?:,? line [0-9]+)?, line [0-9]+, column [0-9]+$"
_ADVICE = r"[,;.]? *(?:please )?(?:use|try) (?:the )?XML_PARSE_HUGE(?: option)?"
"""Advice of libxml2 to its callers; users of a command cannot follow it."""

_DOCTYPE = rb"<!DOCTYPE\s*([^\s\[>]*)"


def may_drop_blanks(data: bytes) -> bool:
    """Return whether white space between elements may be left out of the tree without loss.

    Not where comments or the like could part a text: its beginning would be taken for blank.
    """
    return b"<!" not in data and data.count(b"<?") < 2 and b"\0" not in data[:64]


def parse(data: bytes, source: str, *, drops_blanks: bool = False) -> Any:
    """Return the root element of a document.

    Without blanks the tree is a sixth smaller; then lines from `FAR_LINE` on are not known.

    Raises:
        InvalidProfile: It is too large, has a DOCTYPE, or is not well-formed.
    """
    from lxml import etree

    refuse_size(data, source)
    _refuse_many(data, source)
    _refuse_doctype(data, source)
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
        remove_blank_text=drops_blanks,
    )
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        line = error.lineno or 1
        why = re.sub(_PLACE, "", str(error.msg).removesuffix(f" (<string>, line {error.lineno})"))
        text = f"not well-formed: {_one_line(re.sub(_ADVICE, '', why))}"
        raise refused(source, line, "not-well-formed", text) from error
    _refuse_long_tags(root, data, source)
    doctype = root.getroottree().docinfo
    if doctype.internalDTD is not None:
        raise _doctype_problem(source, 1, doctype.root_name)
    return root


def _refuse_long_tags(root: Any, data: bytes, source: str) -> None:
    """Refuse elements of many attributes: lxml needs their number squared to list them."""
    at = data.find(b"<")
    while at + _LONG_TAG < len(data):
        at = data.rfind(b"<", at + 1, at + _LONG_TAG)
        if at < 0:
            break
    else:
        return
    for element in root.xpath(f"(//*[@*[{MAX_ATTRIBUTES + 1}]])[1]"):
        text = f"more than {MAX_ATTRIBUTES} attributes on {short(element.tag)}"
        rule, allowed = "too-many-attributes", f"at most {MAX_ATTRIBUTES}"
        note = Note(element.sourceline or 1, text, rule=rule, allowed=allowed)
        raise InvalidProfile(source, [note])


def _one_line(text: str) -> str:
    return " ".join(text.split())


def refuse_size(data: bytes, source: str) -> None:
    """Refuse documents larger than any profile.

    Raises:
        InvalidProfile: It is.
    """
    if len(data) > MAX_BYTES:
        why = f"more than {MAX_BYTES} bytes; no profile is so large"
        raise refused(source, 1, _LARGE, why)


def _refuse_many(data: bytes, source: str) -> None:
    is_full = data.count(b"<") > _MAX_TAGS or data.count(b"=") > _MAX_EQUALS
    if is_full or data.count(b"xmlns") > _MAX_NAMESPACES:
        why = "more tags, attributes or namespaces than a profile can have"
        raise refused(source, 1, _LARGE, why)


def _refuse_doctype(data: bytes, source: str) -> None:
    text = data
    if b"\0" in data[:8]:
        text = data.removeprefix(b"\xff\xfe").removeprefix(b"\xfe\xff").replace(b"\0", b"")
    if b"<!DOCTYPE" not in text:
        return
    before = re.match(_BEFORE_ROOT, text, re.DOTALL)
    start = before.end() if before else 0
    found = re.compile(_DOCTYPE).match(text, start)
    if found:
        name = found[1].decode("utf-8", "replace")
        raise _doctype_problem(source, text.count(b"\n", 0, start) + 1, name)


def _doctype_problem(source: str, line: int, name: str | None) -> InvalidProfile:
    shown = "".join(c for c in (name or "")[:40] if c.isprintable())
    text = f"DOCTYPE {shown} is not allowed: a profile declares no entities"
    return InvalidProfile(source, [Note(line, text, "", "doctype", shown, "no DOCTYPE")])
