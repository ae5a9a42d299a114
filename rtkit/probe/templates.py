"""Reads values that users write: JSON or YAML literals, checked against a type, not evaluated."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from rtkit.component.types import Time
from rtkit.component.values.literal import Literal
from rtkit.errors import Malformed

_TIME = "{time}"
_SHOWN = 60


class Template:
    """A literal for ports of several types; `{time}` in it is the time of each writing."""

    def __init__(self, text: str, types: Mapping[str, type]) -> None:
        self._text = text
        self._types = types
        self._has_time = _TIME in text
        self._literals = self._read(Time())

    def at(self, now: Time) -> dict[str, Any]:
        """Return the value for each port by name; its time stamp is `now` unless it says one."""
        literals = self._read(now) if self._has_time else self._literals
        return {name: literal.at(now) for name, literal in literals.items()}

    def _read(self, now: Time) -> dict[str, Literal]:
        stamp = json.dumps({"sec": now.sec, "nsec": now.nsec})
        text = as_json(self._text.replace(_TIME, stamp))
        return {name: Literal(cls, text) for name, cls in self._types.items()}


def templates(lines: Iterable[str], types: Mapping[str, type], source: str) -> Iterator[Template]:
    """Yield the template on each line; skip empty lines and those that begin with #.

    Raises:
        Malformed: A line is no literal of the types; names `source` and its number.
    """
    for number, line in enumerate(lines, start=1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        try:
            yield Template(text, types)
        except Malformed as error:
            raise Malformed(f"{source}:{number}: {_short(text)}: {error}") from None


def _short(text: str) -> str:
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 1]}…"


def as_json(text: str) -> str:
    """Return the value of a JSON or YAML literal as JSON; text that is JSON already stays as it is.

    Raises:
        Malformed: It is neither.
    """
    try:
        json.loads(text)
    except (ValueError, RecursionError):
        return _from_yaml(text)
    return text


def _from_yaml(text: str) -> str:
    import yaml

    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        if any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text, Loader=loader)):
            raise ValueError("an alias, which could stand for any amount of data")
        return json.dumps(yaml.load(text, Loader=loader))
    except (yaml.YAMLError, ValueError, TypeError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise Malformed(f"neither JSON nor YAML: {text}: {reason}") from None
