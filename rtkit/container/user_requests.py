"""Remembers user requests to the components of a process, for the next manager.

A manager may be killed when it has had something done and has not recorded it yet, or before it
has done all that a component needs: only the process that holds the component knows both.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rtkit.deployment.message import MISSING, Message

_FIELDS: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "set": (("set_id",), ("values",)),
    "remove_set": (("set_id",), ()),
    "activate_set": ((), ("set_id",)),
    "change_state": (("context",), ("transition",)),
    "set_rate": (("context",), ("rate",)),
    "set_structure": ((), ("states",)),
    "set_events": ((), ("events",)),
    "attach": (("context", "participant"), ()),
    "detach": (("context", "participant"), ()),
}
"""Operations that set how a component shall be: the keys that distinguish requests of a kind, and
their other values."""


_OPPOSITES = {"detach": "attach", "remove_set": "set"}
"""Operations that take back what another one did: the last of both counts."""


class UserRequests:
    """User requests carried out since each component was made, the last of each kind."""

    def __init__(self) -> None:
        self._requests: dict[str, dict[tuple[str, ...], dict[str, Any]]] = {}

    def note(self, message: Message) -> None:
        """Record an operation that was done, if it sets how a component shall be."""
        op = message["op"]
        if op == "set_back":
            self._take_back(message)
        if op not in _FIELDS:
            return
        names, others = _FIELDS[op]
        key = (_OPPOSITES.get(op, op), *(message[name] for name in names))
        requests = self._requests.setdefault(message["instance"], {})
        request = {"op": op, **{name: message[name] for name in (*names, *others)}}
        known = requests.get(key, {})
        if op == "set":
            request["values"] = {**known.get("values", {}), **message["values"]}
            if message.get("adds") or known.get("adds"):
                request["adds"] = MISSING
        requests[key] = request

    def _take_back(self, message: Message) -> None:
        """Drop values that were asked for by somebody who has given up."""
        requests, key = self._requests.get(message["instance"], {}), ("set", message["set_id"])
        request = requests.get(key)
        if message.get("is_added"):
            requests.pop(key, None)
        elif request is not None:
            values, meant = request["values"], message["values"]
            left = {key: value for key, value in values.items() if meant.get(key) != value}
            request["values"] = left

    def forget(self, instance: str) -> None:
        """Drop what was asked of a component that has ended, or of others about it."""
        self._requests.pop(instance, None)
        for requests in self._requests.values():
            for key, request in list(requests.items()):
                if request.get("participant") == instance:
                    del requests[key]

    def by_component(self, instances: Iterable[str]) -> dict[str, list[Message]]:
        """Return the requests by component, for each of these components."""
        return {each: list(self._requests.get(each, {}).values()) for each in instances}
