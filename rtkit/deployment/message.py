"""Messages between a manager and its processes, or another manager: tables, as they travel."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from rtkit.errors import Malformed

Message = Mapping[str, Any]
MISSING, NEW = "missing", "new"
"""Ways to write a set: one that is not there is added, or one that is there is refused, too."""


def message_from(text: str) -> Message:
    """Return the message that a text is.

    Raises:
        Malformed: It is none.
    """
    try:
        message = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise Malformed(f"not a message: {error}") from error
    if not isinstance(message, dict):
        raise Malformed(f"not a message: {text[:80]}")
    return message
