"""Looks twice a second at the devices that components require.

Neither udev nor inotify tells all that counts: in a container there is no udev, and a link below
/dev may outlive what it leads to.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

from rtkit.link.devices import identity
from rtkit.manager.core.events import DevicesSeen

PERIOD_S = 0.5


class DeviceWatch:
    """Compares devices with what they were at the last look.

    Attributes:
        look_at: When to look next, monotonic time [s]; None while no device is required.
    """

    def __init__(self, notify: Callable[[DevicesSeen], object]) -> None:
        self._notify = notify
        self.look_at: float | None = None
        self._bound: Mapping[str, tuple[str, ...]] = {}
        self._known: dict[str, str | None] = {}

    def watch(self, bound: Mapping[str, tuple[str, ...]]) -> None:
        """Look at the devices of these components from now on; what is absent is told anew."""
        if bound is not self._bound:
            self._bound = bound
            devices = sorted({device for each in bound.values() for device in each})
            self._known = {each: self._known.get(each) or None for each in devices}
            self.look_at = time.monotonic() if devices else None

    def look(self) -> None:
        """Look, and notify of changes; what is another file now was gone meanwhile."""
        self.look_at = time.monotonic() + PERIOD_S
        before, found = self._known, {each: identity(each) for each in self._known}
        self._known = {**found}
        absent = {each for each, file in found.items() if not file}
        renewed = {e for e, file in found.items() if file and before[e] not in (None, "", file)}
        if renewed:
            self._notify(DevicesSeen(tuple(sorted(absent | renewed))))
        if before != found:
            self._notify(DevicesSeen(tuple(sorted(absent))))
