"""Supervises the manipulator for an operator, who talks to it by live properties."""

from __future__ import annotations

import threading
import time
from pathlib import Path

from manipulation import store
from manipulation.desk import Desk
from manipulation.dialogue import Dialogue
from manipulation.orders import Order, Report
from manipulation.sites import site_named
from rtkit.component import Component, InPort, Manager, OutPort, Parameter
from rtkit.link.places import state_dir

_AGAIN_S = 0.5


class Supervisor(Component):
    """Hear an operator by live properties, plan, and command a manipulator over ports."""

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 100.0

    felt = InPort(Report, doc="What the manipulator tells")
    order = OutPort(Order, doc="What the manipulator is to do")
    site = Parameter("switch", doc="Which site of sites.json it knows the walls of")
    service = Parameter("table", doc="Name of its live properties")
    memory = Parameter("", doc="File of what it knows; by default in the folder of states")

    def on_activated(self, context: str) -> None:
        """Recall what was known, and listen to the operator."""
        self._desk: Desk | None = None
        self._lock = threading.Lock()
        self._sent: tuple[int, float] = (0, 0.0)
        usual = f"{state_dir()}/manipulation/{self.instance}-{self.site}.json"
        self._path = Path(self.memory or usual)
        dialogue = store.read(self._path)
        if dialogue is None:
            dialogue = Dialogue(store.site_of(site_named(self.site)))
        self._dialogue = dialogue
        self._kept = -1
        self._desk = Desk(dialogue, self.service, self._lock, self._heard)

    def on_execute(self, context: str) -> None:
        """Take reports, and give the next order."""
        reports = self.felt.read_all()
        with self._lock:
            for report in reports:
                self._dialogue.see(report)
            self._heard()
        if reports and self._desk is not None:
            self._desk.publish()

    def _heard(self) -> None:
        """Give what order there is, and keep what was learnt."""
        dialogue = self._dialogue
        if dialogue.revision != self._kept:
            store.write(dialogue, self._path)
            self._kept = dialogue.revision
        order = dialogue.order
        number, at = self._sent
        if order is not None and (order.number != number or time.monotonic() - at > _AGAIN_S):
            self._sent = (order.number, time.monotonic())
            self.order.write(order)

    def on_deactivated(self, context: str) -> None:
        """Listen no longer."""
        if self._desk is not None:
            self._desk.close()

    on_aborting = on_deactivated


def SupervisorInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Supervisor)
