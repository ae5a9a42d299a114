"""Properties that every service has: ``name``, ``type``, ``status``, ``version``.

They are answered also where an object has no such members, and none is empty then; they are listed
only where it has them.
"""

from __future__ import annotations

import sys

from rtkit.property.live_values import LiveValues
from rtkit.property.node import PropertyNode
from rtkit.property.property_spec import PropertySpec
from rtkit.property.types import Content, parse_type
from rtkit.property.writing import worded

TYPE = parse_type("list<word>")
"""Of ``type``: words, the most telling one first."""


def add_standard(values: LiveValues, name: str, thing: object) -> None:
    """Have a service answer what an object does not: its name, type, status and version."""
    cls = type(thing)
    given: dict[str, tuple[str, str, Content]] = {
        "name": ("string", "Under which it is served", name),
        "type": (TYPE.name, "Words for the kind of thing", (worded(cls.__name__.lower()),)),
        "status": ("string", "How it is", "ready"),
        "version": ("string", "Of its code; unknown where that tells none", _version(cls)),
    }
    for each, (kind, doc, value) in given.items():
        if each in values.standard.nodes:
            continue  # a service that was served before
        spec = PropertySpec(parse_type(kind), "r", doc=doc)
        values.standard.add(PropertyNode(each, spec, value, values.wall()))


def _version(cls: type) -> str:
    package = cls.__module__.partition(".")[0]
    holders = (cls, sys.modules.get(cls.__module__), sys.modules.get(package))
    found = (getattr(each, "__version__", None) for each in holders)
    return next((each for each in found if isinstance(each, str) and each), "unknown")
