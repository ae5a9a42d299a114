"""Properties of a system profile that look like those of rtkit, and are none."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.deployment.known_keys import odd_properties
from rtkit.report.finding import WARNING
from rtkit.statics.remark import Place, Remark
from rtkit.statics.view import View


def property_remarks(view: View) -> Iterator[Remark]:
    """Yield the properties that nobody heeds because they are misspelt or stand elsewhere."""
    for odd in odd_properties(view.profile):
        place = Place(odd.steps).at("name")
        yield Remark(WARNING, "unknown-property", odd.text, place, odd.key)
