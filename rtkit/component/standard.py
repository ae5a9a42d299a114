"""Finds the standard data types in the interface definitions beside this module.

These files keep to a simple form, each declaration below a line of documentation, so that all of
them are read in the time that a few classes take.

See decision 50.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

FAMILIES = {
    **dict.fromkeys(("timed", "geometry", "extended", "sensors", "actuators", "navigation"), "RTC"),
    "images": "Img",
}
"""Modules of standard data types, those that others are made of first; a file in ``idl`` each.

With each the module that its interface definitions have.
"""

SCOPES = ("RTC", "Img")
"""Modules of the interface definitions; a name without module stands for one of the first."""

_BY_HAND = {"Time": "types"}
"""Module of each type that is no class made of its definition."""


class StandardType(NamedTuple):
    """A declaration as it stands in its file.

    Attributes:
        home: Module of `rtkit.component` that has it.
        kind: ``struct``, ``enum`` or ``typedef``.
        body: Text between its braces; of a type definition, the type that it defines.
    """

    home: str
    kind: str
    body: str
    doc: str


@cache
def declared_in(family: str) -> Mapping[str, StandardType]:
    """Return what the file of a family declares, by name."""
    with open(f"{__file__.rpartition('/')[0]}/idl/{family}.idl", encoding="utf-8") as file:
        _, *declarations = file.read().partition("\nmodule ")[2].split("\n  // ")
    found = {}
    for text in declarations:
        doc, _, code = text.partition("\n  ")
        kind, _, rest = code.partition(" ")
        if kind == "typedef":
            body = rest.partition(";")[0]
            name = body.split()[-1].partition("[")[0]
        else:
            name, _, rest = rest.partition(" {")
            body = rest.partition("}")[0]
        found[name] = StandardType(_BY_HAND.get(name, family), kind, body, doc)
    return found


def find(scope: str, name: str) -> StandardType | None:
    """Return the declaration of that name in a module of the interface definitions."""
    families = (family for family, each in FAMILIES.items() if each == scope)
    return next(filter(None, (declared_in(family).get(name) for family in families)), None)


def home_of(scope: str, name: str) -> str:
    """Return the module of `rtkit.component` that has a data type; "" where there is none."""
    found = find(scope, name)
    return found.home if found and found.kind != "typedef" else ""


def names_of(scope: str) -> list[str]:
    """Return the names of all data types of a module of the interface definitions."""
    families = (family for family, each in FAMILIES.items() if each == scope)
    declared = (item for family in families for item in declared_in(family).items())
    return [name for name, each in declared if each.kind != "typedef"]
