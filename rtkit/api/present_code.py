"""Checksums module files, to tell whether live components run the present code."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts


def present_code(components: Iterable[ComponentFacts]) -> dict[str, str]:
    """Return the CRC-32 of each file that these components come from, as facts tell it.

    A file that cannot be read is left out: whether it has changed is not known.
    """
    lines = (line for facts in components for line in facts.code.splitlines())
    files = {line.partition(" ")[2] for line in lines}
    if not files:
        return {}
    import zlib

    found = {}
    for file in files:
        try:
            with open(file, "rb") as stream:
                found[file] = f"{zlib.crc32(stream.read()):08x}"
        except OSError:
            continue
    return found
