"""Polling: reads anew what is computed and listened to, or remembered, from time to time."""

from __future__ import annotations

from contextlib import suppress
from functools import partial

from rtkit.property.codes import PropertyError
from rtkit.property.lanes import NAMES
from rtkit.property.live_values import LiveValues
from rtkit.property.messages import Answer
from rtkit.property.node import PropertyNode
from rtkit.property.user_code import Unfolded, result_of


class Poller:
    """Polls the properties of one service.

    Attributes:
        remembered: Computed properties with a history, by name.
    """

    def __init__(self, values: LiveValues) -> None:
        self._values = values
        self.remembered: dict[str, PropertyNode] = {}
        self._under_way: set[PropertyNode] = set()
        self._is_looking = False

    @property
    def is_needed(self) -> bool:
        """Return whether something is to be read anew from time to time."""
        listeners = self._values.listeners
        has_listeners = listeners.is_any and bool(listeners.of_names or listeners.computed())
        return has_listeners or bool(self.remembered)

    def poll(self) -> None:
        """Read the due properties anew; one reading at a time where user code is called."""
        values = self._values
        for node in dict.fromkeys([*values.listeners.computed(), *self.remembered.values()]):
            if not node.calls_user_code:
                self._read(node)
            elif node not in self._under_way:
                self._under_way.add(node)
                work, late = partial(self._read, node), partial(self._mark_bad, node)
                values.user_code.later(node.name, work, late, 0.0)
        if values.on_names is not None and values.listeners.of_names and not self._is_looking:
            self._is_looking = True
            values.user_code.later(NAMES, self._look, lambda answer: None, 0.0)

    def _read(self, node: PropertyNode) -> None:
        try:
            if self._values.look(node):
                self._values.value_of(node)
        except PropertyError as error:
            if node.source is not None and error.code == "unknown":
                self._look()
            else:
                self._mark_bad(node)
        except Unfolded:
            with suppress(PropertyError):
                self._values.names_now()
        self._under_way.discard(node)

    def _mark_bad(self, node: PropertyNode, _why: Answer | None = None) -> None:
        """Notify the listeners that a value cannot be had."""
        if node.quality != "bad" and node.value is not None:
            self._values.keep(node, node.value, "bad")

    def _look(self) -> None:
        with suppress(PropertyError):  # a request for the names tells
            if result_of(self._values.user_code.call(self._values.may_differ)):
                self._values.names_now()
        self._is_looking = False
