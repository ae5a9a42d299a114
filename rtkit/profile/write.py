"""Writes profiles in any form: strict XML, YAML or JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rtkit.profile.forms import XML as XML_FORM
from rtkit.profile.forms import YAML as YAML_FORM
from rtkit.profile.forms import check_form
from rtkit.profile.xml_write import XmlWriter
from rtkit.profile.xmlnames import clark

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import RtsProfile


def write_rts(profile: RtsProfile) -> bytes:
    """Write an RTS profile.

    Raises:
        Malformed: A text holds a character that XML cannot carry, or a number is not finite.
    """
    from rtkit.profile.rts_spec import RTS_PROFILE

    return XmlWriter(("rts", "rtsExt", "xsi")).document(profile, RTS_PROFILE, "rts:RtsProfile")


def write_rtc(profile: RtcProfile) -> bytes:
    """Write an RTC profile.

    Raises:
        Malformed: A text holds a character that XML cannot carry, or a number is not finite.
    """
    from rtkit.profile.rtc_spec import RTC_PROFILE

    prefixes = ("rtc", "rtcDoc", "rtcExt", "xsi")
    return XmlWriter(prefixes).document(profile, RTC_PROFILE, "rtc:RtcProfile")


def write_profile(profile: RtcProfile | RtsProfile, form: str = XML_FORM) -> bytes:
    """Write a profile of either kind in a form of `rtkit.profile.forms.FORMS`.

    Raises:
        Malformed: There is no such form, a text holds a character that XML cannot carry, or a
            number is not finite.
    """
    from rtkit.profile.rts_model import RtsProfile

    check_form(form)
    if form == XML_FORM:
        return write_rts(profile) if isinstance(profile, RtsProfile) else write_rtc(profile)
    data = plain_profile(profile)
    if form == YAML_FORM:
        from rtkit.profile.yaml_text import write_yaml as write
    else:
        from rtkit.profile.json_text import write_json as write
    return write(data).encode("utf-8")


def plain_profile(profile: RtcProfile | RtsProfile) -> dict[str, Any]:
    """Return a profile as the plain data that its YAML and JSON forms hold.

    Raises:
        Malformed: A text holds a character that XML cannot carry, or a number is not finite.
    """
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.profile.tree_form import ROOTS
    from rtkit.profile.tree_write import plain

    if isinstance(profile, RtsProfile):
        from rtkit.profile.rts_spec import RTS_PROFILE

        return {ROOTS["rts"]: plain(profile, RTS_PROFILE, clark("rts:RtsProfile"))}
    from rtkit.profile.rtc_spec import RTC_PROFILE

    return {ROOTS["rtc"]: plain(profile, RTC_PROFILE, clark("rtc:RtcProfile"))}
