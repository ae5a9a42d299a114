"""A batch of actions, and its results, as the text that a manager's ``batch`` property takes."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any, get_args

from rtkit.deployment.actions import Action, Result
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass
from rtkit.rtc.serde import decode, encode, parse_json

_NAMES: dict[type, str] = {cls: cls.__name__ for cls in get_args(Action)}
_TYPES: dict[str, type] = {name: cls for cls, name in _NAMES.items()}
MAX_TIMEOUT_S = 86_400.0
"""The longest time that a manager waits for one action [s]."""
_STAMPED = re.compile(r"([0-9a-f]{8})-([0-9a-f]{1,15})-[0-9a-f]+")
MAX_ID = 64
"""The longest id of a batch."""


@dataclass(frozen=True, slots=True)
class Batch:
    """Actions for one manager.

    Attributes:
        is_ordered: One after the other, stop at the first failure; else all at once.
        timeout_s: Bound on each action [s].
        id: Of the request: one that comes again with it is answered, and not done again. None
            if it is empty.
    """

    actions: tuple[Action, ...]
    is_ordered: bool = True
    timeout_s: float = 10.0
    id: str = ""


def stamped_id(boot: str, since_boot_us: int, random: str) -> str:
    """Return the id of a request that states when it was made, and is like no other.

    Args:
        boot: Identity of a run of a machine.
        since_boot_us: How long that has run [us].
        random: Distinguishes requests of one moment.
    """
    return f"{boot[:8]}-{since_boot_us:x}-{random}"


def stamp_of(id: str) -> tuple[str, int] | None:
    """Return the run of a machine in which an id was made, and when [us]; None if it has none."""
    found = _STAMPED.fullmatch(id)
    return None if found is None else (found[1], int(found[2], 16))


def action_to_plain(action: Action) -> dict[str, Any]:
    """Return an action as plain data, its name under ``do``."""
    return {"do": _NAMES[type(action)], **encode(action)}


def action_from_plain(data: object) -> Action:
    """Rebuild an action.

    Raises:
        Malformed: The data is no action that is known here.
    """
    if not isinstance(data, Mapping):
        raise Malformed("an action is a table")
    cls = _TYPES.get(data.get("do", ""))
    if cls is None:
        raise Malformed(f"unknown action: {data.get('do')!r}")
    action: Action = decode(cls, {key: value for key, value in data.items() if key != "do"})
    return action


def batch_to_text(batch: Batch) -> str:
    """Return a batch as text."""
    actions = [action_to_plain(action) for action in batch.actions]
    return json.dumps(
        {
            "actions": actions,
            "ordered": batch.is_ordered,
            "timeout": batch.timeout_s,
            "id": batch.id,
        },
        separators=(",", ":"),
    )


def batch_from_text(text: str) -> Batch:
    """Rebuild a batch.

    Raises:
        Malformed: The text is no batch.
    """
    data = parse_json(text)
    try:
        actions = tuple(action_from_plain(item) for item in data["actions"])
        timeout_s = float(data["timeout"])
        is_ordered = bool(data["ordered"])
        id = str(data.get("id", ""))
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise Malformed(f"not a batch: {error}") from error
    if len(id) > MAX_ID:
        raise Malformed(f"the id of a batch has more than {MAX_ID} characters")
    if not timeout_s > 0:
        raise Malformed(f"time-out is not a positive number of seconds: {timeout_s:g}")
    return Batch(actions, is_ordered, min(timeout_s, MAX_TIMEOUT_S), id)


def results_to_text(results: Sequence[Result]) -> str:
    """Return the results of a batch as text."""
    return json.dumps([encode(result) for result in results], separators=(",", ":"))


def results_from_text(text: str) -> tuple[Result, ...]:
    """Rebuild the results of a batch.

    Raises:
        Malformed: The text is no list of results.
    """
    data = parse_json(text)
    if not isinstance(data, list):
        raise Malformed("not a list of results")
    return tuple(decode(Result, item) for item in data)
