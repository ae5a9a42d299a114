"""Heats a room that is too cold."""

from rtkit.component import Component, InPort, OutPort, Parameter, TimedDouble


class Thermostat(Component):
    """Heats a room that is too cold."""

    vendor = "example"
    category = "home"
    version = "1.0.0"
    rate = 20.0

    temperature = InPort(TimedDouble, doc="Of the room [degC]")
    power = OutPort(TimedDouble, doc="Of the heater, 0 to 1")
    target = Parameter(21.0, unit="degC", constraint="5<=x<=30")

    def on_execute(self, context):
        if self.temperature.is_new():
            missing = self.target - self.temperature.read().data
            self.power.write(TimedDouble(data=min(1.0, max(0.0, missing / 2))))


def ThermostatInit(manager):
    manager.register_factory(Thermostat)
