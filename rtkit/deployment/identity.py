"""Identities of component types as profiles write them: ``RTC:vendor:category:name:version``.

Old profiles write ``RTC:vendor.category.name:version``.
"""

from __future__ import annotations

from rtkit.rtc.profiles import TypeProfile


def type_of(id: str) -> TypeProfile:
    """Return the type that an identity names; what cannot be read becomes the type's name."""
    parts = id.split(":")
    if parts[0] == "RTC" and len(parts) == 5:
        _, vendor, category, name, version = parts
        return TypeProfile(name, vendor, category, version)
    if parts[0] == "RTC" and len(parts) == 3 and parts[1].count(".") >= 2:
        vendor, category, name = parts[1].rsplit(".", 2)
        return TypeProfile(name, vendor, category, parts[2])
    return TypeProfile(id.replace(":", ".") or "Unnamed")


def is_same_id(one: str, other: str) -> bool:
    """Return whether two identities name the same type."""
    return one == other or type_of(one) == type_of(other)
