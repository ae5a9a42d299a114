"""Identity of component types by the properties that their modules give them."""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.rtc.profiles import TypeProfile


def type_of(described: Mapping[str, str], class_name: str = "") -> TypeProfile:
    """Return the identity of a component type by its properties."""
    given = described.get
    return TypeProfile(
        type_name=given("type_name") or given("implementation_id") or class_name,
        vendor=given("vendor", ""),
        category=given("category", ""),
        version=given("version", ""),
        description=" ".join(given("description", "").split()),
        language=given("language") or "Python",
    )
