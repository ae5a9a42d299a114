"""World service of another process or host, for robots there: it takes no numpy to be in one."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from types import SimpleNamespace
from typing import Any

import rtkit
from rtkit.errors import RtkitError


class RemoteWorld:
    """World service elsewhere, asked through a client as if it were here.

    Args:
        name: Of the service.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._client = rtkit.Client()
        self._pace: float | None = None
        self.bodies = SimpleNamespace(set=self._put_body)

    @property
    def pace(self) -> float:
        """Return how fast robots move there; 1 until it has answered."""
        if self._pace is None:
            with suppress(RtkitError):
                self._pace = float(self.get_pace())
        return 1.0 if self._pace is None else self._pace

    def close(self) -> None:
        """Ask it no longer."""
        self._client.close()

    def set_moves(self, moves: Sequence[tuple[str, float, float, float, float]]) -> None:
        """Move bodies; see `HomeWorld`."""
        self._client.set(f"{self._name}.moves", moves)

    def _put_body(self, name: str, marker: rtkit.Marker | None) -> None:
        self._client.set(f"{self._name}.bodies.{name}", marker)

    def __getattr__(self, name: str) -> Any:
        """Return what gets a property: ``get_image(width=100)``."""
        if not name.startswith("get_"):
            raise AttributeError(name)
        return lambda **parameters: self._client.get(f"{self._name}.{name[4:]}", **parameters)
