"""What a manager does at its start, and what it tells of what failed."""

from __future__ import annotations

import pytest
from fake_shell import wire

from rtkit.errors import Malformed, NotFound
from rtkit.manager.core.startup import StartUp, connector
from rtkit.rtc.profiles import PortRef


def start(shell, warned=None, **given):
    """Run a start-up on fakes; return its failures."""
    for key, value in given.items():
        shell.state.settings.take(f"manager.{key.replace('__', '.')}", value)
    outcome = []
    posted = []
    start_up = StartUp(
        shell.state,
        shell.requests,
        posted.append,
        outcome.append,
        ([] if warned is None else warned).append,
    )
    start_up.begin()
    while posted:
        shell.feed(posted.pop(0))
        for name in list(shell.spawned):
            shell.fork(name)
        shell.serve()
    (failures,) = outcome
    return failures


def test_nothing_is_to_be_done(shell):
    assert start(shell) == []


def test_all_is_done_in_order(shell):
    order = []
    feed = shell.feed
    shell.feed = lambda event: (order.append(event), feed(event))[1]
    failures = start(
        shell,
        components__preactivation="A, B",
        components__preconnect="A.out?port=B.in&dataflow_type=pull",
        components__precreate="Thing?instance_name=A, Thing?instance_name=B&manager_name=s",
        modules__preload="a.py (aInit), b",
        preload__modules="first.py",
    )
    assert failures == []
    asked = [each.batch.actions for each in order if hasattr(each, "batch")]
    assert [type(actions[0]).__name__ for actions in asked] == [
        "Load",
        "Load",
        "Load",
        "Create",
        "Create",
        "Connect",
        "ChangeState",
        "ChangeState",
    ]
    assert [actions[0].path for actions in asked[:3]] == ["first.py", "a.py", "b"]
    (made,) = shell.state.connectors.values()
    assert made.properties["dataport.dataflow_type"] == "pull"
    assert made.properties["dataport.data_type"] == "TimedLong"


def test_what_fails_is_told_and_the_rest_done(shell):
    failures = start(
        shell,
        components__precreate="?x, Thing?instance_name=A",
        components__preconnect="A.out?port=C.in,A.out",
        components__preactivation="A,C",
    )
    assert dict(failures) == {
        "manager.components.precreate: ?x": "option 'x' is not KEY=VALUE in create string: ?x",
        "manager.components.preconnect: A.out?port=C.in": "no such port: C.in (did you mean A.in?)",
        "manager.components.preconnect: A.out": "not COMPONENT.PORT?port=COMPONENT.PORT: A.out",
        "manager.components.preactivation: C": "no component named C",
    }
    assert list(shell.state.components) == ["A"]


def test_a_component_that_lives_already_is_what_was_wanted(shell):
    shell.make("A", "s")
    assert start(shell, components__precreate="Thing?instance_name=A") == []
    assert list(shell.state.components) == ["A"]


ODD = "subscripton_type=flush"
TOLD = (
    "unknown connector property: dataport.subscripton_type"
    " (did you mean dataport.subscription_type?)"
)


def test_what_is_odd_in_connections_is_warned_of(shell):
    warned = []
    shell.make("A")
    shell.make("B")
    assert start(shell, warned, components__preconnect=f"A.out?port=B.in&{ODD}") == []
    assert warned == [f"manager.components.preconnect: A.out?port=B.in&{ODD}: {TOLD}"]
    assert list(shell.state.connectors) == ["A.out-B.in"]


def test_what_is_odd_in_connections_fails_a_strict_start(shell):
    warned = []
    shell.make("A")
    shell.make("B")
    shell.state.settings.take("rtkit.start.strict", "YES")
    item = f"A.out?port=B.in&{ODD}"
    failed = [(f"manager.components.preconnect: {item}", TOLD)]
    assert start(shell, warned, components__preconnect=item) == failed
    assert (warned, shell.state.connectors) == ([], {})


@pytest.mark.parametrize("is_strict", [False, True])
def test_notes_on_what_is_made_are_warnings_or_failures(shell, is_strict):
    warned = []
    shell.make("A", "s")
    shell.state.settings.take("rtkit.start.strict", "YES" if is_strict else "NO")
    item = "Thing?instance_name=A&manager_name=t"
    note = "A exists already, in s: nothing was made"
    failed = start(shell, warned, components__precreate=item)
    told = f"manager.components.precreate: {item}"
    assert failed == ([(told, note)] if is_strict else [])
    assert warned == ([] if is_strict else [f"{told}: {note}"])


def test_ports_are_put_in_order_and_may_have_dots(shell):
    shell.make("A")
    shell.make("B.x")
    made = connector(shell.state, "B.x.in?port=A.out&subscription_type=flush&rtkit.x=1")
    assert made.ports == (PortRef("A", "out"), PortRef("B.x", "in"))
    assert made.properties["dataport.subscription_type"] == "flush"
    assert made.properties["rtkit.x"] == "1"
    assert made.connector_id == "A.out-B.x.in"


def test_ports_that_are_connected_stay_so(shell):
    shell.make("A")
    shell.make("B")
    shell.state.connectors["w"] = wire("w")
    assert connector(shell.state, "A.out?port=B.in") is None


def test_service_ports_are_connected(shell):
    shell.make("A")
    shell.make("B")
    made = connector(shell.state, "A.svc?port=B.svc")
    assert made.properties == {"port.port_type": "CorbaPort"}


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("A.out", Malformed),
        ("A.out?port=", Malformed),
        ("A.out?x", Malformed),
        ("A?port=B.in", NotFound),
        ("A.nix?port=B.in", NotFound),
        ("A.out?port=B", NotFound),
    ],
)
def test_connections_that_cannot_be_read(shell, text, error):
    shell.make("A")
    shell.make("B")
    with pytest.raises(error):
        connector(shell.state, text)
