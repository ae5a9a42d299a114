"""Hides what is named like a secret, in texts and in data, from whom it is not for."""

from __future__ import annotations

import json
import re
from typing import Any

_SECRET = re.compile(r"passw|secret|token|credential|private.?key", re.IGNORECASE)
_SECRET_IN_TEXT = re.compile(
    r"(?i)((?:passw|secret|token|credential|private.?key)[\w.-]*[\"']?\s*[=:]\s*[\"']?)[^\s&\"',;]+"
    r"|(?<=://)[^/\s@]+(?=@)"
)
HIDDEN = "(hidden)"
"""Stands for what may be a password or another secret."""


def is_secret(key: object, value: object) -> bool:
    """Return whether a value is a text whose key names it as a secret."""
    return isinstance(key, str) and isinstance(value, str) and bool(_SECRET.search(key))


def hidden_in(text: str) -> str:
    """Return a text without the secrets that it names."""
    return _SECRET_IN_TEXT.sub(lambda found: (found[1] or "") + HIDDEN, text)


def hidden_in_json(text: str) -> str:
    """Return data as JSON without the secrets in it, and what is no JSON as a text is."""
    if not _SECRET.search(text) and "://" not in text:
        return text
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return hidden_in(text)
    return json.dumps(_hidden(data), separators=(",", ":"))


def _hidden(data: Any) -> Any:
    if isinstance(data, str):
        return hidden_in(data)
    if isinstance(data, list):
        return [_hidden(item) for item in data]
    if isinstance(data, dict):
        return {k: HIDDEN if is_secret(k, item) else _hidden(item) for k, item in data.items()}
    return data
