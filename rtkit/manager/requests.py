"""What a client may ask of a manager: its properties, and the ready-made views of its facts."""

from __future__ import annotations

import json
from typing import Any

from rtkit.deployment.batch import batch_from_text
from rtkit.deployment.listing import listing_of, listing_to_text
from rtkit.deployment.part import part_of
from rtkit.deployment.watch import watch_from_text
from rtkit.errors import NotFound, Refused
from rtkit.link import keys
from rtkit.manager.events import BatchAsked, Event, StopAsked, WatchAsked
from rtkit.manager.state import State
from rtkit.property.exchange import Reply, Request
from rtkit.rtc.plain import encode


class Desk:
    """Answers what needs no work and turns the rest into events.

    Views are made once and kept until the facts change.
    """

    def __init__(self, state: State) -> None:
        self._state = state
        self._views: dict[str, str] = {}

    def forget_views(self) -> None:
        """Make views anew when they are asked for next: facts have changed."""
        self._views.clear()

    def take(self, request: Request) -> Event | None:
        """Answer a request, or return the event that leads to its answer.

        Raises:
            RtkitError: The request cannot be served.
        """
        if request.is_extension:
            request.answer(Reply(self._view(request.name)))
            return None
        if request.payload is None:
            request.answer(Reply(self._property(keys.unescape(request.name))))
            return None
        if request.name == "batch":
            return BatchAsked(batch_from_text(request.payload), request.answer)
        if request.name == "watch":
            return WatchAsked(watch_from_text(request.payload), request.answer)
        if request.name == "stop":
            request.answer(Reply(str(self._state.pid)))
            return StopAsked()
        raise Refused(f"read-only or unknown property: {request.name}")

    def _view(self, name: str) -> str:
        kind, _, which = name.partition("/")
        if kind == "part":
            instances = keys.unescape(which).split(",")
            return _compact(encode(part_of(self._state.snapshot(), instances)))
        if name not in self._views:
            if name == "listing":
                text = listing_to_text(listing_of(self._state.snapshot()))
            elif name == "snapshot":
                text = _compact(encode(self._state.snapshot()))
            else:
                raise NotFound(f"no such view: {name}")
            self._views[name] = text
        return self._views[name]

    def _property(self, name: str) -> str:
        value = self._state.properties.get(name)
        if value is None:
            raise NotFound(f"no such property: {name}")
        return value


def _compact(data: Any) -> str:
    return json.dumps(data, separators=(",", ":"))
