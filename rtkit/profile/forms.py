"""Forms of profiles (XML, YAML, JSON), and the detection of a document's form."""

from __future__ import annotations

import re

from rtkit.errors import Malformed

XML, YAML, JSON = "xml", "yaml", "json"
FORMS = (XML, YAML, JSON)
_ENDINGS = {".xml": XML, ".yaml": YAML, ".yml": YAML, ".json": JSON}
_MARKS = (b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff")
_LOOKED_AT = 4096
_COMPONENT_ROOTS = (b"RtcProfile", b"rtcProfile")
_SYSTEM_ROOTS = (b"RtsProfile", b"rtsProfile")
_YAML_ROOT = rb"^(---\s+)?\s*[\"']?[Rr]t[cs]Profile[\"']?\s*:"


def may_be_component(head: bytes) -> bool:
    """Return whether a document that begins so may be an RTC profile, told without parsing."""
    return any(root in head.replace(b"\0", b"") for root in _COMPONENT_ROOTS)


def may_be_system(head: bytes) -> bool:
    """Return whether a document that begins so may be an RTS profile, told without parsing."""
    return any(root in head.replace(b"\0", b"") for root in _SYSTEM_ROOTS)


def check_form(form: str) -> None:
    """Check the name of a form.

    Raises:
        Malformed: There is no such form.
    """
    if form not in FORMS:
        raise Malformed(f"no such form: {form}; there are {', '.join(FORMS)}")


def form_of_name(name: str) -> str | None:
    """Return the form that the ending of a file's name tells.

    >>> form_of_name("system.yml"), form_of_name("<stdin>")
    ('yaml', None)
    """
    for ending, form in _ENDINGS.items():
        if name.lower().endswith(ending):
            return form
    return None


def form_of(data: bytes, name: str = "") -> str:
    """Tell the form of a document by how it begins, else by the ending of its name, else XML."""
    head = data[:_LOOKED_AT]
    for mark in _MARKS:
        head = head.removeprefix(mark)
    head = head.replace(b"\0", b"").lstrip()
    by_name = form_of_name(name)
    if head.startswith(b"<"):
        return XML
    if head.startswith(b"{"):
        return by_name if by_name == YAML else JSON
    if by_name is not None:
        return by_name
    return YAML if re.search(_YAML_ROOT, head, re.MULTILINE) else XML


def has_parameters(data: bytes) -> bool:
    """Return whether a document may have variables, conditions or includes."""
    return b"urn:rtkit:profile" in data or b"rtkit::" in data
