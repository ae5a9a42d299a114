"""Events of several properties, of several owners, in the order in which they come."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from queue import Empty, SimpleQueue

from rtkit.errors import RtkitError
from rtkit.property.messages import Event
from rtkit.tree.properties import End, Places, told

_Heard = tuple[str, Event | Exception]


class Heard:
    """Listens to all targets; refused when one of them is.

    Raises:
        PropertyError: As commands tell it.
    """

    def __init__(self, places: Places, targets: Sequence[str], parameters: str) -> None:
        self._queue: SimpleQueue[_Heard] = SimpleQueue()
        names: dict[int, dict[str, str]] = {}
        ends: dict[int, End] = {}
        for typed in targets:
            place, end = places.find(typed)
            target = place.target(parameters)
            try:
                end.listen(target)
            except RtkitError as error:
                raise told(typed, error) from error
            name = target.partition("?")[0]
            names.setdefault(id(end), {})[name] = typed
            ends[id(end)] = end
        for key, end in ends.items():
            arguments = (end, names[key], targets[0])
            threading.Thread(target=self._hear, args=arguments, daemon=True).start()

    def _hear(self, end: End, names: dict[str, str], first: str) -> None:
        try:
            while (event := end.event()) is not None:
                self._queue.put((names.get(event.name, event.name), event))
        except RtkitError as error:
            self._queue.put((next(iter(names.values()), first), error))

    def events(self, until: float | None) -> Iterator[tuple[str, Event]]:
        """Yield events with the target as it was typed, until some time [s, monotonic].

        Raises:
            PropertyError: An owner has gone.
        """
        while True:
            left = None if until is None else max(0.0, until - time.monotonic())
            try:
                typed, heard = self._queue.get(timeout=left)
            except Empty:
                return
            if isinstance(heard, Exception):
                raise told(typed, heard) from heard
            yield typed, heard
