"""A simulated plotting-table manipulator: jaws with three degrees of freedom."""

from __future__ import annotations

from manipulation.orders import Order, Report
from manipulation.sites import site_named
from manipulation.table import table_of
from rtkit.component import Component, InPort, Manager, OutPort, Parameter

_AGAIN_S = 0.2


class Manipulator(Component):
    """Move jaws over a table of things, an order at a time, and report what they feel."""

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 100.0

    order = InPort(Order, doc="What to do")
    felt = OutPort(Report, doc="What the sensors tell")
    site = Parameter("switch", doc="Which site of sites.json it stands on")
    seed = Parameter(1, doc="Where things really lie")
    displaced = Parameter(
        0.5,
        unit="places",
        constraint="0<=x<=0.5",
        doc="How far off things lie at most",
    )
    speed = Parameter(0.2, unit="m/s", constraint="0.001<=x<=20", doc="Of travel")
    turning = Parameter(2.0, unit="rad/s", constraint="0.01<=x<=200", doc="Of turns")

    def on_activated(self, context: str) -> None:
        """Put the things on the table, unless they lie there."""
        self._since = 0.0
        wanted = (self.site, self.seed, self.displaced)
        if getattr(self, "_wanted", None) != wanted:
            site = site_named(self.site)
            self._table = table_of(site, seed=self.seed, displaced=self.displaced)
            self._wanted = wanted

    def on_execute(self, context: str) -> None:
        """Go on with the order; report what is new, and now and then what is not."""
        table = self._table
        table.speed, table.turning = self.speed, self.turning
        for order in self.order.read_all():
            table.take(order)
        before = table.report
        period = 1.0 / self.context_rate(context)
        report = table.tick(period)
        self._since += period
        if report != before or self._since >= _AGAIN_S:
            self._since = 0.0
            self.felt.write(report)


def ManipulatorInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Manipulator)
