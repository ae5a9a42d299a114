"""Finds properties of a system profile that look like those of rtkit, and are none."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.deployment.known_keys import odd_properties
from rtkit.report.finding import WARNING
from rtkit.static_check.finding import ProfileLocation, StaticFinding
from rtkit.static_check.view import View


def property_remarks(view: View) -> Iterator[StaticFinding]:
    """Yield the properties that nobody heeds because they are misspelt or stand elsewhere."""
    for odd in odd_properties(view.profile):
        place = ProfileLocation(odd.steps).at("name")
        yield StaticFinding(WARNING, "unknown-property", odd.text, place, odd.key)
