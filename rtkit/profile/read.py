"""Read profiles: parse, normalise, validate, build.

What can be put right is put right and noted, unless `strict` asks for an error instead.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rtkit.profile.common import Note, Reading
from rtkit.profile.findings import Findings, InvalidProfile
from rtkit.profile.spec import Spec
from rtkit.profile.xmlnames import clark, short, split

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import RtsProfile

STDIN = "<stdin>"

_Check = Callable[[Any, Findings], None]
_Violations = Callable[[Any, str], list[Note]]


def read_rts(data: bytes, source: str = STDIN, *, strict: bool = False) -> Reading[RtsProfile]:
    """Read an RTS profile; `source` names it in messages.

    Raises:
        InvalidProfile: All that is wrong with it, by line.
    """
    reading: Reading[RtsProfile] = _read(data, source, strict, *_rts())
    return reading


def read_rtc(data: bytes, source: str = STDIN, *, strict: bool = False) -> Reading[RtcProfile]:
    """Read an RTC profile; `source` names it in messages.

    Raises:
        InvalidProfile: All that is wrong with it, by line.
    """
    reading: Reading[RtcProfile] = _read(data, source, strict, *_rtc())
    return reading


def explain_rts(data: bytes, source: str = STDIN) -> tuple[Note, ...]:
    """Tell in full what is wrong with an RTS profile; slow."""
    return _explain(data, source, *_rts())


def explain_rtc(data: bytes, source: str = STDIN) -> tuple[Note, ...]:
    """Tell in full what is wrong with an RTC profile; slow."""
    return _explain(data, source, *_rtc())


def profile_kind(data: bytes, source: str = STDIN) -> str:
    """Tell whether a document is an ``rts`` or an ``rtc`` profile, by its root.

    Raises:
        InvalidProfile: It is neither.
    """
    from rtkit.profile.parse import parse

    root = parse(data, source)
    for kind, tag in (("rts", "rts:RtsProfile"), ("rtc", "rtc:RtcProfile")):
        if root.tag == clark(tag):
            return kind
    text = f"root is {short(root.tag)}; a profile's is rts:RtsProfile or rtc:RtcProfile"
    raise InvalidProfile(source, [Note(root.sourceline or 1, text, rule="wrong-root")])


def _rts() -> tuple[Spec, str, str, _Check]:
    from rtkit.profile.references import check_references
    from rtkit.profile.rts_spec import RTS_PROFILE
    from rtkit.profile.validate import RTS

    return RTS_PROFILE, "rts:RtsProfile", RTS, check_references


def _rtc() -> tuple[Spec, str, str, _Check]:
    from rtkit.profile.rtc_rules import check_names
    from rtkit.profile.rtc_spec import RTC_PROFILE
    from rtkit.profile.validate import RTC

    return RTC_PROFILE, "rtc:RtcProfile", RTC, check_names


def _normalised(data: bytes, source: str, spec: Spec, tag: str, check: _Check) -> Any:
    from rtkit.profile.normalise import normalise
    from rtkit.profile.parse import parse

    root = parse(data, source)
    if root.tag != clark(tag):
        namespace, local = split(clark(tag))
        text = f"root is {short(root.tag)}; it must be {local} of namespace {namespace}"
        raise InvalidProfile(source, [Note(root.sourceline or 1, text, rule="wrong-root")])
    is_flat = data.count(b"xmlns") == len(root.nsmap)
    found = Findings(source, dict(root.nsmap) if is_flat else None)
    normalise(root, spec, found)
    check(root, found)
    return root, found


def _read(
    data: bytes, source: str, strict: bool, spec: Spec, tag: str, schema: str, check: _Check
) -> Any:
    from rtkit.profile.build import build
    from rtkit.profile.validate import violations

    root, found = _normalised(data, source, spec, tag, check)
    problems = found.errors or violations(root, schema)
    if strict:
        problems = problems + found.repairs
    if problems:
        raise InvalidProfile(source, problems)
    return Reading(build(root, spec), tuple(sorted(found.repairs + found.remarks)))


def _explain(
    data: bytes, source: str, spec: Spec, tag: str, schema: str, check: _Check
) -> tuple[Note, ...]:
    from rtkit.profile.validate import explained_violations

    try:
        root, found = _normalised(data, source, spec, tag, check)
    except InvalidProfile as error:
        return error.problems
    return tuple(sorted(found.errors + explained_violations(root, schema)))
