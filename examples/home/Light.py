"""Light of a room, as a newcomer writes a service: a class, and a line for managers to load it."""

from __future__ import annotations

from typing import Final

import rtkit

Place = tuple[float, float, float]


class Light:
    """Light of a room, which a world shows.

    Args:
        world: Name of the world service.
        lamp: What it is called there.
        at: Where it hangs [m].
    """

    type: Final = ("light",)
    version: Final = "1.0"

    def __init__(self, *, world: str, lamp: str, at: Place = (0.0, 0.0, 2.4)) -> None:
        self._world, self._lamp, self.location, self._on = world, lamp, at, False

    def __enter__(self) -> Light:
        self._client = rtkit.Client()
        self.set_on(self._on)
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()

    def get_on(self) -> bool:
        """Return whether it shines."""
        return self._on

    def set_on(self, on: bool) -> None:
        """Switch it on or off."""
        marker = rtkit.Marker(self.location, type="light", size=0.1, on=on)
        self._client.set(f"{self._world}.objects.{self._lamp}", marker)
        self._on = on


LightInit = rtkit.init_of(Light)
