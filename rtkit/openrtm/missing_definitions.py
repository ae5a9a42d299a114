"""Tells that a module would come of an IDL file, and where these were looked for."""

from __future__ import annotations

import re
from collections.abc import Sequence

from rtkit.openrtm.definitions import PLACES, SERVANTS, STUB


def missing_definition(name: str, source: bytes, folders: Sequence[str]) -> str:
    """Return why a module of IDL is not there; empty for one that may be of another kind.

    Args:
        name: As it is imported.
        source: Of what imports it; with ``X``, such a file names ``X__POA``, ``X_idl`` or ``X::``.
        folders: In which IDL files are looked for.
    """
    scope = name.removesuffix(SERVANTS).removesuffix(STUB)
    others = rf"\b{re.escape(name)}(?:(?:{SERVANTS}|{STUB})\b|::\w)".encode()
    if scope == name and not re.search(others, source):
        return ""
    wanted = f"{scope}.idl" if name.endswith(STUB) else f"IDL file that declares module {scope}"
    return (
        f"No module named {name!r}: there is no {wanted} in {', '.join(folders)};"
        f" {PLACES}=FOLDER names further folders"
    )
