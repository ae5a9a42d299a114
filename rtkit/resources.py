"""Finds the data that ship with rtkit: schemas, profiles, examples."""

from __future__ import annotations

import os.path

from rtkit.errors import NotFound

_PACKAGE = os.path.dirname(os.path.abspath(__file__))


def resource(*parts: str) -> str:
    """Return the path of a shipped file or folder, e.g. ``resource("schemas", "RtsProfile.xsd")``.

    The wheel carries them below ``rtkit/_data``, a checkout beside the package.

    Raises:
        NotFound: Neither place has it.
    """
    for base in (os.path.join(_PACKAGE, "_data"), os.path.dirname(_PACKAGE)):
        path = os.path.join(base, *parts)
        if os.path.exists(path):
            return path
    raise NotFound(
        f"{'/'.join(parts)} does not ship with this rtkit; is the installation complete?"
    )
