"""A failure of a callback is a failure of that component and of nothing else."""

from __future__ import annotations

import pytest

from rtkit.component import Component
from rtkit.component.contexts.callbacks import Callbacks, attempt, overrides
from rtkit.component.contexts.lifecycle import ACTIVE, ERROR, INACTIVE
from rtkit.errors import Refused
from rtkit.rtc.enums import LifeCycleState, ReturnCode, Transition

CALLBACKS = [name for name in vars(Callbacks) if name.startswith("on_")]


class Odd(Exception):
    def __str__(self):
        raise KeyError("no text")


def raise_value_error():
    raise ValueError("bad\nvalue")


def raise_exit():
    raise SystemExit(3)


def raise_interrupt():
    raise KeyboardInterrupt


def raise_memory():
    raise MemoryError


def recurse():
    recurse()


def raise_generator_exit():
    raise GeneratorExit


def raise_odd():
    raise Odd


def return_error():
    return ReturnCode.ERROR


def return_nonsense():
    return 5


FAILURES = {
    "ValueError: bad value": raise_value_error,
    "SystemExit: 3": raise_exit,
    "KeyboardInterrupt": raise_interrupt,
    "MemoryError": raise_memory,
    "RecursionError": recurse,
    "GeneratorExit": raise_generator_exit,
    "Odd: (its text cannot be shown)": raise_odd,
    "returned RTC_ERROR": return_error,
    "returned 5": return_nonsense,
}


class Faulty(Component):
    """Fails in the callback that is named."""

    fails_in = ""
    failure = staticmethod(raise_value_error)

    def __init__(self, instance, fails_in="", failure=raise_value_error):
        super().__init__(instance)
        self.fails_in, self.failure = fails_in, failure
        self.calls, self.reports = [], []
        self.report = self.reports.append

    def _do(self, name):
        self.calls.append(name)
        return self.failure() if name == self.fails_in else None


def _callback(name):
    if name in ("on_initialize", "on_finalize"):
        return lambda self: self._do(name)
    return lambda self, context: self._do(name)


for _name in CALLBACKS:
    setattr(Faulty, _name, _callback(_name))


class Neighbour(Component):
    """Counts its periods in the context of another."""

    count = 0

    def on_execute(self, context):
        self.count += 1


# What happens to the component, by the callback that fails: state afterwards, and whether the
# failure is its cause, is reported, or refuses its creation.
OUTCOME = {
    "on_initialize": (None, "refused"),
    "on_startup": (ACTIVE, "reported"),
    "on_activated": (ERROR, "cause"),
    "on_execute": (ERROR, "cause"),
    "on_state_update": (ERROR, "cause"),
    "on_rate_changed": (ERROR, "cause"),
    "on_deactivated": (INACTIVE, "reported"),
    "on_aborting": (ERROR, "reported"),
    "on_error": (ERROR, "reported"),
    "on_reset": (ERROR, "cause"),
    "on_shutdown": (INACTIVE, "reported"),
    "on_finalize": (INACTIVE, "reported"),
}


def walk(component, neighbour):
    """Bring a component to where its callback fails; return its state there."""
    component.initialize()
    neighbour.initialize()
    (context,) = component.contexts.values()
    context.add_component(neighbour)
    context.activate_component(neighbour)
    context.activate_component(component)
    context.tick()
    name = component.fails_in
    if name == "on_rate_changed":
        context.set_rate(10.0)
        context.tick()
    if name in ("on_aborting", "on_error", "on_reset"):
        component.on_execute = lambda context: ReturnCode.ERROR
        context.tick()
        context.tick()
    if name == "on_reset":
        context.reset_component(component)
    if name in ("on_deactivated", "on_shutdown", "on_finalize"):
        context.deactivate_component(component)
    state = context.state_of(component)
    before = neighbour.count
    context.tick()
    assert neighbour.count == before + 1
    return state


def test_the_table_names_all_twelve():
    assert len(CALLBACKS) == 12
    assert set(OUTCOME) == set(CALLBACKS)


@pytest.mark.parametrize("text", FAILURES)
@pytest.mark.parametrize("name", CALLBACKS)
def test_failure_stays_with_the_component(name, text):
    component, neighbour = Faulty("Faulty0", name, FAILURES[text]), Neighbour("Neighbour0")
    state, effect = OUTCOME[name]
    if effect == "refused":
        with pytest.raises(Refused, match="on_initialize failed") as caught:
            component.initialize()
        assert text in str(caught.value)
        assert "test_callbacks.py:" in str(caught.value)
        assert not component.contexts
        return
    assert walk(component, neighbour) is state
    component.finalize()
    seen = component.cause if effect == "cause" else "; ".join(component.reports)
    assert text in seen
    assert "test_callbacks.py:" in seen
    assert "\n" not in seen
    assert component.calls[-1] == "on_finalize"
    if state is ERROR:
        assert component.calls.count("on_aborting") == 1


@pytest.mark.parametrize("name", CALLBACKS)
def test_every_callback_is_called(name):
    component, neighbour = Faulty("Faulty0"), Neighbour("Neighbour0")
    component.fails_in = name
    component.failure = lambda: None
    walk(component, neighbour)
    component.finalize()
    assert name in component.calls


def test_the_place_is_the_authors_line():
    class Parser:
        def on_execute(self):
            import json

            json.loads("{")

    text = attempt(Parser().on_execute)
    assert text.startswith("JSONDecodeError: ")
    assert text.endswith("in on_execute)")
    assert "test_callbacks.py:" in text


def test_long_text_is_cut():
    def on_execute():
        raise ValueError("x" * 10_000)

    assert len(attempt(on_execute)) < 400


def test_code_ok_and_none_are_success():
    assert attempt(lambda: None) == ""
    assert attempt(lambda: ReturnCode.OK) == ""
    assert attempt(lambda: "RTC_OK") == ""


def test_overrides_sees_class_and_instance():
    plain = Component("Plain0")
    assert not overrides(plain, "on_execute")
    assert overrides(Faulty("Faulty0"), "on_execute")
    plain.on_execute = lambda context: None
    assert overrides(plain, "on_execute")


def test_a_repeated_failure_of_on_error_is_reported_once():
    component = Faulty("Faulty0", "on_error")
    component.initialize()
    (context,) = component.contexts.values()
    component.on_activated = lambda context: ReturnCode.ERROR
    context.activate_component(component)
    for _ in range(5):
        context.tick()
    assert component.calls.count("on_error") == 5
    assert len(component.reports) == 1


def test_activation_that_fails_says_why():
    answers = []
    component = Faulty("Faulty0", "on_activated")
    component.initialize()
    (context,) = component.contexts.values()
    context.request(component, Transition.ACTIVATE, lambda *answer: answers.append(answer))
    context.tick()
    ((code, why),) = answers
    assert code is ReturnCode.ERROR
    assert why.startswith("on_activated failed: ValueError: bad value (test_callbacks.py:")
    assert context.state_of(component) is LifeCycleState.ERROR
