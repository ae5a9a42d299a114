"""Components that count: one sends numbers, one passes them on, one tells the last and the gaps."""

COUNTER = '''
from rtkit.component import Component, OutPort, Time, TimedLong


class Counter(Component):
    """Count."""

    rate = 100.0
    out = OutPort(TimedLong)
    number = 0

    def on_execute(self, context):
        self.number += 1
        self.out.write(TimedLong(Time(0, 0), self.number))


def CounterInit(manager):
    manager.register_factory(Counter)
'''
CHECKER = '''
import os
from rtkit.component import Component, InPort, TimedLong


class Checker(Component):
    """Write the last number and the number of gaps into a file."""

    rate = 100.0
    into = InPort(TimedLong)
    last = gaps = 0

    def on_execute(self, context):
        for value in self.into.read_all():
            self.gaps += self.last not in (0, value.data - 1)
            self.last = value.data
        draft = f"count.{os.getpid()}"  # another one may have the same folder
        with open(draft, "w") as file:
            file.write(f"{self.last} {self.gaps}")
        os.replace(draft, "count")


def CheckerInit(manager):
    manager.register_factory(Checker)
'''
RELAY = '''
from rtkit.component import Component, InPort, OutPort, TimedLong


class Relay(Component):
    """Pass numbers on."""

    rate = 50.0
    into = InPort(TimedLong)
    out = OutPort(TimedLong)

    def on_execute(self, context):
        for value in self.into.read_all():
            self.out.write(value)


def RelayInit(manager):
    manager.register_factory(Relay)
'''
