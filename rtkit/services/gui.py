"""GUI service: components of user interfaces, named by the type that they draw.

``vector.text`` is a ``<gui>``, which every client of panels draws with its own widgets;
``vector.html`` a page, which a browser shows in a sandbox. Those of the package are there at once;
others are SET, and kept in a storage service if one is named.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from hashlib import sha256
from importlib.resources import files
from time import monotonic
from typing import Final, Self

from rtkit import Client, Names, PropertyError, Text, init_of

LONGEST = 1 << 16
"""The most that a component has [characters]."""
_LOOK_S = 1.0
_NAME = re.compile(r"[A-Za-z][\w-]*\.(text|html|json|svg)")
_DESCRIPTION = re.compile(r"\s*<gui\b[^\0]*(/>|</gui>)\s*")


class GuiService(Names):
    """Keeps components by type: ``TYPE.text``, ``TYPE.html``.

    Args:
        store: A storage service, or a folder of one, in which those are kept that are SET; without
            one they are gone when the service ends.
    """

    type: Final = ("gui",)
    version: Final = "1.0"

    def __init__(self, store: str = "") -> None:
        self.store: Final = store
        self._why = ""
        self._standard = _standard()
        self._set: dict[str, str] = {}
        self._listed: tuple[str, ...] = ()
        self._looked_at = float("-inf")
        self._kept: tuple[str, ...] = ()
        self._client: Client | None = None

    def __enter__(self) -> Self:
        self._client = Client() if self.store else None
        return self

    def __exit__(self, *raised: object) -> None:
        if self._client is not None:
            self._client.close()

    @property
    def status(self) -> str:
        """Return whether the storage, if there is one, can be reached."""
        return f"failed: {self._why}" if self._why else "ready"

    def names(self) -> Collection[str]:
        """Return the components that there are."""
        known = tuple(sorted({*self._standard, *self._set, *self._stored()}))
        self._listed = self._listed if known == self._listed else known
        return self._listed

    def get(self, name: str) -> Text:
        """Return a component; one that was set stands before one of the package."""
        if self._client is not None and name in self._stored():
            stored = self._client.get_bytes(f"{self.store}.{name}")
            return Text(stored.decode("utf-8", "replace"))
        return Text(self._set.get(name) or self._standard[name])

    def set(self, name: str, value: Text) -> None:
        """Keep a component; an empty text takes it away, and that of the package stands again."""
        if not _NAME.fullmatch(name):
            raise PropertyError("unknown", f"expected TYPE.text, TYPE.html, .json or .svg: {name}")
        if len(value) > LONGEST:
            raise PropertyError("too-large", f"longer than {LONGEST} characters")
        if value and name.endswith(".text") and not _DESCRIPTION.fullmatch(value):
            raise PropertyError("bad-value", "expected <gui …/>")
        self._looked_at = float("-inf")
        if self._client is not None:
            more = {} if value else {"delete": 1}
            self._client.set_bytes(f"{self.store}.{name}", value.encode(), **more)
        elif value:
            self._set[name] = value
        else:
            self._set.pop(name, None)

    def stamp(self, name: str) -> object:
        """Return what stays equal while a component does."""
        return sha256(self.get(name).encode()).digest()

    def _stored(self) -> tuple[str, ...]:
        """Return what the storage has, looked at once a second."""
        if self._client is None or monotonic() < self._looked_at + _LOOK_S:
            return self._kept
        self._looked_at = monotonic()
        try:
            listed = self._client.get(f"{self.store}.properties", all=1)
            self._kept = tuple(str(each) for each in listed if _NAME.fullmatch(str(each)))
            self._why = ""
        except PropertyError as error:
            self._kept, self._why = (), str(error)
        return self._kept


def _standard() -> dict[str, str]:
    """Return the components of the package."""
    folder = files("rtkit.services").joinpath("components")
    return {each.name: each.read_text("utf-8") for each in folder.iterdir()
            if _NAME.fullmatch(each.name)}  # fmt: skip


GuiServiceInit = init_of(GuiService)
