"""Tells whether the files that a live component comes from have changed since they were loaded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts


def changed_code(facts: ComponentFacts, present: Mapping[str, str]) -> str:
    """Return a file that a component comes from, if it has changed since it was loaded.

    `present` has the CRC-32 of files as they are now.
    """
    parts = (line.partition(" ") for line in facts.code.splitlines())
    changed = (file for loaded, _, file in parts if present.get(file, loaded) != loaded)
    return next(changed, "")
