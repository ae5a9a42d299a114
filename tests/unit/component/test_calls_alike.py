"""Calls of services: the same outcome in one process and between two."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Protocol

import pytest

from rtkit.component import Component, Long, ServicePort, raises
from rtkit.component.contexts.callbacks import attempt
from rtkit.component.factory import Factories
from rtkit.component.services.interface import Interface
from rtkit.component.services.invocation import Direct, ProvidedInterface, Remote, answer
from rtkit.errors import Malformed, Refused


class Busy(Exception):
    def __init__(self, task: str, seconds: float) -> None:
        super().__init__(task, seconds)
        self.task = task
        self.seconds = seconds


class Empty(Exception):
    """It carries nothing but its text."""


class Worse(Busy):
    """It is not declared, its base is."""


class Arm(Protocol):
    @raises(Busy, Empty)
    def move(self, what: str, path: list[Long], *, steps: Long = 0) -> Long: ...

    def stop(self) -> None: ...


class Doer:
    def move(self, what, path, *, steps=0):
        if what == "worse":
            raise Worse("dig", 2.5)
        if what in kinds:
            raise kinds[what]
        path.append(1)
        return "many" if what == "text" else len(path) + steps

    def stop(self):
        raise Busy("stop", 1.0)


kinds = {
    "busy": Busy("dig", 0.1),
    "empty": Empty("nothing there"),
    "bare": Empty(),
    "bad": Busy("dig", "long"),
    "exit": SystemExit(3),
    "interrupt": KeyboardInterrupt(),
    "generator": GeneratorExit(),
    "value": ValueError("no"),
}


def targets():
    there = Interface(Arm)
    served = ProvidedInterface(there, Doer(), "P.arm", lambda: None)
    clock = time.monotonic_ns
    yield "direct", Direct(served)
    yield "remote", Remote("Arm", "C.arm", lambda data, _s: answer(data, [served], clock()), clock)


CASES = [
    *((name, []) for name in (*kinds, "worse")),
    *[("fine", []), ("fine", [1, 2]), ("text", []), ("fine", [2**40]), (5, []), ("fine", (7,))],
]


@pytest.mark.parametrize(("what", "path"), CASES, ids=lambda each: str(each))
def test_a_call_has_the_same_outcome_in_one_process_and_between_two(what, path):
    move = Interface(Arm).methods["move"]
    outcomes = []
    for _, target in targets():
        given = list(path) if isinstance(path, list) else path
        try:
            outcomes.append(("result", target.call(move, (what, given), {"steps": 4}, 5.0)))
        except Exception as error:
            outcomes.append((type(error), error.args))
        assert given == path, "the caller's list was changed"
    assert outcomes[0] == outcomes[1]


@pytest.mark.parametrize(("kind", "target"), list(targets()))
def test_a_declared_exception_arrives_as_itself(kind, target):
    move, stop = Interface(Arm).methods["move"], Interface(Arm).methods["stop"]
    with pytest.raises(Busy) as caught:
        target.call(move, ("busy", []), {}, 5.0)
    assert (caught.value.task, caught.value.seconds) == ("dig", 0.1)
    with pytest.raises(Empty, match=r"^nothing there$"):
        target.call(move, ("empty", []), {}, 5.0)
    with pytest.raises(Refused, match=r"P\.arm: Arm\.stop failed: Busy: .*stop"):
        target.call(stop, (), {}, 5.0)
    with pytest.raises(Refused, match=r"P\.arm: Arm\.move failed: Busy: .*long"):
        target.call(move, ("bad", []), {}, 5.0)


def test_a_caller_catches_its_own_class_of_an_exception():
    @dataclass
    class Other(Exception):
        task: str
        seconds: float

    Other.__name__ = "Busy"

    class Mine(Protocol):
        @raises(Other)
        def move(self, what: str, path: list[Long], *, steps: Long = 0) -> Long: ...

    move = Interface(Mine, "Arm").methods["move"]
    for _, target in targets():
        with pytest.raises(Other) as caught:
            target.call(move, ("busy", []), {}, 5.0)
        assert caught.value == Other("dig", 0.1)
        with pytest.raises(Refused, match="Empty: nothing there"):
            target.call(move, ("empty", []), {}, 5.0)


class Odd(Exception):
    def __init__(self, what) -> None:
        self.what = what


@pytest.mark.parametrize(
    ("exception", "why"), [(Odd, "Odd.what cannot be carried"), (int, "is no exception: <class")]
)
def test_an_exception_that_cannot_arrive_is_refused_with_its_interface(exception, why):
    class Wrong(Protocol):
        @raises(exception)
        def f(self) -> None: ...

    with pytest.raises(Malformed, match=why):
        Interface(Wrong)


def test_what_nothing_would_await_is_refused_early():
    class Asking(Component):
        async def on_execute(self, context):
            """Do nothing."""

    class Yielding(Component):
        def on_initialize(self):
            yield

    class Serving(Component):
        arm = ServicePort.provided(Arm)

        async def move(self, what, path, *, steps=0):
            return 0

        def stop(self):
            """Do nothing."""

    factories = Factories()
    with pytest.raises(Refused, match=r"^Asking\.on_execute is a coroutine function"):
        factories.register(Asking)
    with pytest.raises(Refused, match=r"^Yielding\.on_initialize is a generator function"):
        factories.register(Yielding)
    with pytest.raises(Refused, match=r"^S0\.arm: Serving\.move is a coroutine function"):
        Serving("S0")


def test_a_coroutine_that_a_callback_returns_is_told():
    async def wait():
        """Do nothing."""

    assert str(attempt(lambda: wait())).startswith("returned a coroutine, which nothing awaits")
