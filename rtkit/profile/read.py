"""Reads profiles: parses, normalises, validates, builds; from XML, YAML or JSON.

Deviations that can be repaired are repaired and noted, unless `strict` asks for an error instead.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rtkit.errors import NotFound
from rtkit.fast_dataclass import dataclass
from rtkit.profile.common import Note, Reading
from rtkit.profile.findings import FAR_LINE, Findings, InvalidProfile, refused
from rtkit.profile.forms import XML, YAML, check_form, form_of
from rtkit.profile.spec import ElementSpec
from rtkit.profile.xmlnames import clark, short, split

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import RtsProfile

STDIN = "<stdin>"
KINDS = ("rtc", "rts")
_DECLARED = r"(<\?xml[^>]*?)\s+encoding\s*=\s*(\"[^\"]*\"|'[^']*')"


def read_profile(
    data: bytes | str,
    source: str = STDIN,
    *,
    form: str | None = None,
    kind: str | None = None,
    strict: bool = False,
) -> Reading[RtcProfile] | Reading[RtsProfile]:
    """Read a profile of either kind in any form.

    Args:
        data: The document.
        source: Names it in messages; its ending tells the form where the content does not.
        form: One of `rtkit.profile.forms.FORMS`; None finds out.
        kind: ``rtc`` or ``rts``, if only that will do.
        strict: Refuse what would need repair.

    Raises:
        InvalidProfile: All that is wrong with it, by line.
        Malformed: There is no such form.
    """
    reading: Reading[RtcProfile] | Reading[RtsProfile] = _read(data, source, form, kind, strict)
    return reading


def read_file(
    path: str, *, form: str | None = None, kind: str | None = None, strict: bool = False
) -> Reading[RtcProfile] | Reading[RtsProfile]:
    """Read the profile in a file, as `read_profile` does.

    Raises:
        NotFound: The file cannot be read.
        InvalidProfile: All that is wrong with it, by line.
        Malformed: There is no such form.
    """
    return read_profile(read_bytes(path), path, form=form, kind=kind, strict=strict)


def read_rts(
    data: bytes | str, source: str = STDIN, *, form: str | None = None, strict: bool = False
) -> Reading[RtsProfile]:
    """Read an RTS profile in any form; `source` names it in messages.

    Raises:
        InvalidProfile: All that is wrong with it, by line.
    """
    reading: Reading[RtsProfile] = _read(data, source, form, "rts", strict)
    return reading


def read_rtc(
    data: bytes | str, source: str = STDIN, *, form: str | None = None, strict: bool = False
) -> Reading[RtcProfile]:
    """Read an RTC profile in any form; `source` names it in messages.

    Raises:
        InvalidProfile: All that is wrong with it, by line.
    """
    reading: Reading[RtcProfile] = _read(data, source, form, "rtc", strict)
    return reading


def read_bytes(path: str) -> bytes:
    """Return the content of a file, of a larger one than any profile only the beginning.

    Raises:
        NotFound: The file cannot be read.
    """
    from rtkit.profile.parse import MAX_BYTES

    try:
        with open(path, "rb") as stream:
            return stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise NotFound(f"cannot read {path}: {error.strerror}") from error
    except ValueError as error:
        raise NotFound(f"cannot read {path!r}: {error}") from error


@dataclass(frozen=True, slots=True)
class Grammar:
    """Schema, tables and checks of a kind of profile, ``rts`` or ``rtc``."""

    kind: str
    spec: ElementSpec
    schema: str
    check: Callable[[Any, Findings], None]
    is_plain: Callable[[Any], bool]


def _grammar(kind: str) -> Grammar:
    if kind == "rts":
        from rtkit.profile.build import is_plain_system
        from rtkit.profile.rts_spec import RTS_PROFILE
        from rtkit.profile.validate import RTS

        return Grammar(kind, RTS_PROFILE, RTS, _check_references, is_plain_system)
    from rtkit.profile.build import is_plain_component
    from rtkit.profile.rtc_spec import RTC_PROFILE
    from rtkit.profile.validate import RTC

    return Grammar(kind, RTC_PROFILE, RTC, _check_names, is_plain_component)


def _check_references(root: Any, found: Findings) -> None:
    from rtkit.profile.references import check_references

    check_references(root, found)


def _check_names(root: Any, found: Findings) -> None:
    from rtkit.profile.rtc_rules import check_names

    check_names(root, found)


def _opened(
    data: bytes | str, source: str, form: str | None, kind: str | None, *, needs_lines: bool = True
) -> tuple[str, Callable[[ElementSpec], tuple[Any, Findings]]]:
    """Return the kind of a document, and how to get its elements."""
    from rtkit.profile.parse import refuse_size

    if isinstance(data, str):
        data = _encoded(data)
    if form is not None:
        check_form(form)
    refuse_size(data, source)
    form = form or form_of(data, source)
    if form == XML:
        return _opened_xml(data, source, kind, needs_lines=needs_lines)
    return _opened_tree(data, source, form, kind)


def _opened_xml(
    data: bytes, source: str, kind: str | None, *, needs_lines: bool
) -> tuple[str, Callable[[ElementSpec], tuple[Any, Findings]]]:
    from rtkit.profile.parse import may_drop_blanks, parse

    drops_blanks = may_drop_blanks(data)
    is_vague = drops_blanks and data.count(b"\n") >= FAR_LINE - 1
    if is_vague and needs_lines:
        drops_blanks = is_vague = False
    root = parse(data, source, drops_blanks=drops_blanks)
    tags = {clark(f"{each}:{each.capitalize()}Profile"): each for each in KINDS}
    found = tags.get(root.tag)
    if found is None or kind not in (None, found):
        text = f"root is {short(root.tag)}; a profile's is rts:RtsProfile or rtc:RtcProfile"
        if kind is not None:
            tag = clark(f"{kind}:{kind.capitalize()}Profile")
            namespace, local = split(tag)
            text = f"root is {short(root.tag)}; it must be {local} of namespace {namespace}"
        raise refused(source, root.sourceline or 1, "wrong-root", text)

    def elements(_: ElementSpec) -> tuple[Any, Findings]:
        is_flat = data.count(b"xmlns") == len(root.nsmap)
        return root, Findings(source, dict(root.nsmap) if is_flat else None, is_vague=is_vague)

    return found, elements


def _opened_tree(
    data: bytes, source: str, form: str, kind: str | None
) -> tuple[str, Callable[[ElementSpec], tuple[Any, Findings]]]:
    from rtkit.profile.tree_form import ROOTS
    from rtkit.profile.tree_read import decoded, elements_of, root_of

    if form == YAML:
        from rtkit.profile.yaml_text import read_yaml as reader
    else:
        from rtkit.profile.json_text import read_json as reader
    found, key, body = root_of(reader(decoded(data, source), source), source)
    if kind not in (None, found):
        why = f"the root is {key.text}; it must be {ROOTS[kind or found]}"
        raise refused(source, key.line, "wrong-root", why)

    def elements(spec: ElementSpec) -> tuple[Any, Findings]:
        findings = Findings(source)
        root = elements_of(body, key.line, found, spec, findings)
        findings.scope = dict(root.nsmap)
        return root, findings

    return found, elements


def _encoded(text: str) -> bytes:
    """Return a text as UTF-8, without an encoding that an XML declaration names."""
    import re

    text = text.removeprefix("\ufeff")
    if text.startswith("<?xml"):
        text = re.sub(_DECLARED, r"\1", text, count=1)
    return text.encode("utf-8", "surrogatepass")


def as_it_stands(
    data: bytes | str, source: str, form: str | None, kind: str | None, *, needs_lines: bool = True
) -> tuple[Any, Findings, Grammar]:
    """Return the tree of a document without any repair, a place for findings, and its grammar.

    Unless it `needs_lines`, those far down in a very long document may be wrong.

    Raises:
        InvalidProfile: There is no such tree.
    """
    kind, elements = _opened(data, source, form, kind, needs_lines=needs_lines)
    grammar = _grammar(kind)
    return (*elements(grammar.spec), grammar)


@dataclass(frozen=True, slots=True)
class ReadOutcome:
    """Outcome of reading a document: the profile, None where there are errors, and findings.

    Attributes:
        root: The tree that the profile was built from along `spec`; `found` knows its places.
    """

    kind: str
    profile: Any
    errors: list[Note]
    repairs: list[Note]
    remarks: list[Note]
    root: Any
    spec: ElementSpec
    found: Findings


def outcome(data: bytes | str, source: str, form: str | None, kind: str | None) -> ReadOutcome:
    """Read a document: by the fast path if it is in strict form, else with repairs.

    Raises:
        InvalidProfile: There is no tree to look at.
        Malformed: There is no such form.
    """
    with _no_collection():
        root, found, grammar = as_it_stands(data, source, form, kind)
        profile = _plain(root, found, grammar)
        if profile is None:
            return _repaired(root, found, grammar)
        return ReadOutcome(grammar.kind, profile, [], [], [], root, grammar.spec, found)


def _plain(root: Any, found: Findings, grammar: Grammar) -> Any:
    """Return the profile of a valid document in strict form; None of any other."""
    from rtkit.profile.build import built
    from rtkit.profile.validate import violations

    profile = None
    if not found.errors and not found.repairs:
        profile = built(root, grammar.spec, found.scope)
    is_valid = profile is not None and not violations(root, grammar.schema)
    return profile if is_valid and grammar.is_plain(profile) else None


def _repaired(root: Any, found: Findings, grammar: Grammar) -> ReadOutcome:
    """Return the outcome of a document by the full path, with repairs."""
    from rtkit.profile.build import build
    from rtkit.profile.normalise import normalise
    from rtkit.profile.validate import violations

    normalise(root, grammar.spec, found)
    # Names are looked up in the model, which is quicker; the tree is searched for what is wrong.
    profile = None if found.errors else _built(root, grammar)
    if profile is None or not grammar.is_plain(profile):
        grammar.check(root, found)
        profile = None
    errors = found.errors or violations(root, grammar.schema)
    if profile is None and not errors:
        profile = build(root, grammar.spec)
    notes = (errors, found.repairs, found.remarks)
    return ReadOutcome(grammar.kind, None if errors else profile, *notes, root, grammar.spec, found)


def _built(root: Any, grammar: Grammar) -> Any:
    """Return the model of a tree that was repaired; None if it cannot be valid."""
    from rtkit.profile.build import build

    try:
        return build(root, grammar.spec)
    except (KeyError, ValueError):
        return None


def _read(data: bytes | str, source: str, form: str | None, kind: str | None, strict: bool) -> Any:
    with _no_collection():
        root, found, grammar = as_it_stands(data, source, form, kind, needs_lines=False)
        profile = _plain(root, found, grammar)
        if profile is not None:
            return Reading(profile)
        if found.is_vague:
            del root, found
            root, found, grammar = as_it_stands(data, source, form, kind)
        seen = _repaired(root, found, grammar)
        del root, found
    problems = seen.errors + (seen.repairs if strict else [])
    if problems:
        raise InvalidProfile(source, problems)
    return Reading(seen.profile, tuple(sorted(seen.repairs + seen.remarks)))


@contextmanager
def _no_collection() -> Iterator[None]:
    """Suspend garbage collection: reading makes many objects and drops hardly one of them.

    In a process with a large heap, a collection takes longer than reading (decision 35).
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
