"""A state machine: a microwave oven."""

from __future__ import annotations

from typing import Any, ClassVar

from rtkit.component import FsmComponent, Manager, OutPort, Time, TimedLong

IDLE, PROGRAMMED, COOKING = (f"Operational.{name}" for name in ("Idle", "Programmed", "Cooking"))
DISABLED = "Disabled"


class Microwave(FsmComponent):
    """Cook for as many minutes as were asked for, and never with an open door.

    The values of the events do not matter, but for `minute`: how many to add.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"

    states: ClassVar = {
        IDLE: {"minute": PROGRAMMED},
        PROGRAMMED: {"minute": PROGRAMMED, "start": COOKING, "stop": IDLE},
        COOKING: {"minute": COOKING, "tick": COOKING, "stop": IDLE},
        "Operational": {"open": DISABLED},
        DISABLED: {"close": "Operational"},
    }
    events: ClassVar = {
        "open": TimedLong,
        "close": TimedLong,
        "minute": TimedLong,
        "start": TimedLong,
        "stop": TimedLong,
        "tick": TimedLong,
    }
    left = OutPort(TimedLong, doc="Minutes left")

    def on_activated(self, context: str) -> None:
        """Begin with no time set."""
        self._minutes = 0
        super().on_activated(context)

    def on_event(self, event: str, value: Any) -> str | None:
        """Count minutes; they decide where `tick` and `close` lead."""
        if event == "minute":
            self._minutes += max(0, value.data)
        elif event == "tick":
            self._minutes -= 1
            return None if self._minutes else IDLE
        elif event == "stop":
            self._minutes = 0
        elif event == "close":
            return PROGRAMMED if self._minutes else IDLE
        return None

    def on_action(self, context: str) -> None:
        """Tell the time that is left, after every transition."""
        self.left.write(TimedLong(Time.now(), self._minutes))


def MicrowaveInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Microwave)
