"""Serves a panel: its widgets are properties, and what its user does is an event.

The user interface is a sensor: ``PANEL.NAME`` has what a widget shows, ``PANEL.focus`` where the
user is, ``PANEL.input`` what the user has asked for last. SET of a widget does what the user would.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from rtkit.closing import Closing
from rtkit.panel.description import Panel
from rtkit.property.codes import PropertyError
from rtkit.property.conversion import to_value
from rtkit.property.property_spec import PropertySpec
from rtkit.property.service import Service
from rtkit.property.types import Content, parse_type
from rtkit.property.values import Value, Word

_OWN = frozenset({"type", "focus", "input"})
_NO_VALUES = frozenset({"group", "button", "image"})


class ServedPanel(Closing):
    """Service of a panel.

    Args:
        name: Of the service.
        set: Called with the name of a widget and a value that somebody sets it to, on a thread
            of its own; what it raises refuses the SET.

    Raises:
        Refused: A service of that name runs.
    """

    def __init__(self, name: str, set: Callable[[str, Any], object]) -> None:
        from rtkit.wires.serve import serve

        self.name = name
        self._set = set
        self._service = Service()
        self._service.add("type", (Word("gui"), Word("sensor")), PropertySpec(access="r"))
        self._service.add("focus", "", PropertySpec(parse_type("string"), "r"))
        self._service.add("input", (), PropertySpec(parse_type("list"), "r"))
        self._added: dict[str, Panel] = {}
        self._served = serve(self._service, name)

    def show(self, panel: Panel, value: Any) -> None:
        """Take what a widget shows now."""
        if panel.name in _OWN or value is None or isinstance(value, bytes):
            return
        if panel.name in self._added:
            self._put(panel.name, to_value(value))
        elif panel.kind not in _NO_VALUES:
            self._added[panel.name] = panel
            self._served.owned(lambda: self._add(panel, to_value(value)))

    def keep(self, shown: Mapping[str, Panel]) -> None:
        """Serve only those widgets that are shown still, and as they are declared now."""
        for name, panel in list(self._added.items()):
            if name not in shown or shown[name].spec != panel.spec:
                del self._added[name]
                self._served.owned(partial(self._service.remove, name, only=True))

    def _add(self, panel: Panel, value: Content) -> None:
        def changed(value: Content, given: dict[str, Value]) -> None:
            self._set(panel.name, value)

        write = None if panel.is_read_only else changed
        try:
            self._service.add(panel.name, value, panel.spec, write=write)
        except PropertyError:  # bytes that are a text, a number outside of its range
            access = PropertySpec(access=panel.spec.access)
            self._service.add(panel.name, value, access, write=write)

    def focus(self, name: str) -> None:
        """Take where the user is."""
        self._put("focus", name)

    def input(self, name: str, value: Any) -> None:
        """Take what the user has asked for."""
        self._put("input", (name, to_value("" if value is None else value)))  # type: ignore[arg-type]

    def _put(self, name: str, value: Content) -> None:
        def put() -> None:
            with suppress(PropertyError):  # a widget that came later
                self._service.update(name, value)

        self._served.owned(put)

    def close(self) -> None:
        """Serve it no longer."""
        self._served.close()
