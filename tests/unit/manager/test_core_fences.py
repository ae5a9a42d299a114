"""Fences: managers refuse what leads to a component that its owner has made elsewhere."""

from __future__ import annotations

import json

import pytest
from fake_peers import FakeHost

from rtkit.errors import Malformed, Refused
from rtkit.manager.query_server import ManagerQueryServer
from rtkit.property.exchange import Reply, Request


@pytest.fixture
def host():
    """A in m1, which is connected to B in m2."""
    host = FakeHost("m1", "m2")
    assert host.make("m1", "A", "a").result.ok
    assert host.make("m2", "B", "b").result.ok
    asked = host.ask("m1", host.connector("w", "m1"))
    host.calm(1.0)
    assert asked.result.ok
    return host


def fence(host: FakeHost, manager: str, epoch: int, home: str, component: str = "A") -> str:
    shell, replies = host.shells[manager], list[Reply]()
    row = {"component": component, "epoch": epoch, "home": home, "owner": "laptop/manager"}
    server = ManagerQueryServer(shell.state, shell.requests)
    shell.feed(server.take(Request("fence", json.dumps(row), replies.append)))
    host.calm(1.0)
    return replies[0].value()


def at(host: FakeHost, manager: str) -> str:
    return f"{host.shells[manager].state.host}/{manager}"


def test_at_home_nothing_changes(host):
    fence(host, "m1", 5, at(host, "m1"))
    fence(host, "m2", 5, at(host, "m1"))
    assert [host.trouble(name, "w") for name in ("m1", "m2")] == ["", ""]
    assert ("fence", "A") in host.rows["m2"]


def test_a_half_that_leads_to_a_past_one_ends_and_stays_ended(host):
    fence(host, "m2", 5, "robot1/manager")
    assert not any(slave.ends for slave in host.slaves["m2"].values())
    assert [host.trouble(name, "w") for name in ("m1", "m2")] == [None, None]
    asked = host.ask("m1", host.connector("w", "m1"))
    host.calm(1.0)
    assert not asked.result.ok
    assert "is of a past epoch: laptop/manager has it in robot1/manager since 5" in asked.result.why
    assert [host.trouble(name, "w") for name in ("m1", "m2")] == [None, None]


def test_it_is_made_nowhere_else(host):
    fence(host, "m2", 5, at(host, "m1"))
    refused = host.make("m2", "A", "a").result
    assert "A cannot be made here: laptop/manager has it in" in refused.why
    fence(host, "m2", 6, "")
    assert host.make("m2", "A", "a").result.ok


def test_an_earlier_epoch_is_refused_and_the_row_outlasts_its_manager(host):
    fence(host, "m2", 5, "robot1/manager")
    with pytest.raises(Refused, match="A is of epoch 5 now"):
        fence(host, "m2", 4, at(host, "m1"))
    host.kill("m2")
    host.start("m2")
    host.calm(1.0)
    with pytest.raises(Refused, match="A is of epoch 5 now"):
        fence(host, "m2", 4, at(host, "m1"))


def test_nonsense_is_refused(host):
    with pytest.raises(Malformed):
        fence(host, "m2", "5", "robot1/manager")
    with pytest.raises(Malformed):
        fence(host, "m2", 5, "robot1/manager", component="")


def test_the_log_says_that_nothing_moves_without_the_owner(host, caplog):
    fence(host, "m1", 5, at(host, "m1"))
    from rtkit.manager.core.fences import note_lost

    note_lost(host.shells["m1"].state, "laptop/manager", "host laptop cannot be reached")
    assert "it owns A: nothing is moved until it is back" in caplog.text
