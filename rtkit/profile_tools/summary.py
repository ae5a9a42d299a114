"""Summarises a profile of either kind for a person to read."""

from __future__ import annotations

from rtkit.profile.rtc_model import RtcProfile
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile_tools.outline import Outline


def summary(profile: RtcProfile | RtsProfile) -> Outline:
    """Return the summary of a profile of either kind, under one entry."""
    if isinstance(profile, RtsProfile):
        from rtkit.profile_tools.system_summary import system_summary

        return system_summary(profile)
    from rtkit.profile_tools.component_summary import component_summary

    return component_summary(profile)
