"""Sites of the table: where walls are, and where things are told to lie."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rtkit.errors import NotFound

_FILE = Path(__file__).parent / "sites.json"


def sites() -> Mapping[str, Any]:
    """Return all sites by name."""
    found: Mapping[str, Any] = json.loads(_FILE.read_text(encoding="utf-8"))
    return found


def site_named(name: str) -> Mapping[str, Any]:
    """Return a site.

    Raises:
        NotFound: There is none of that name.
    """
    known = sites()
    if name not in known:
        raise NotFound(f"no such site: {name} (there is {', '.join(known)})")
    site: Mapping[str, Any] = known[name]
    return site
