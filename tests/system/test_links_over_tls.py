"""Hosts that are linked over mutual TLS: connectors, moves, cuts; who may link, and who not."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from forked import Commands
from robotkit import AT, BOUND_S, Robot, opened_robot
from waiting import until

from rtkit.keys.authority import issue, revoke


@pytest.fixture(scope="module")
def robot(commands: Commands) -> Iterator[Robot]:
    """A robot, and a manager here with the keys of an administrator, linked to it."""
    with opened_robot(commands) as robot, robot.keys_of("owner1"):
        shell = robot.shell
        shell.ok("rtmgr start -a")
        shell.ok(f"rthost add robot1 tls:{AT}:{robot.port}")
        assert shell.ok("rtmgr start --host robot1") == ("robot1: linked, manager ran already\n")
        shell.ok("rtmgr -c ConsoleIn?instance_name=Near -c ConsoleOut?instance_name=Sink"
                 " /localhost/manager.mgr")  # fmt: skip
        yield robot
        shell.ok("rtmgr stop")


def _linked(robot: Robot) -> str:
    return robot.shell.ok("rthost list")


def test_a_link_is_on_record_and_shown(robot: Robot) -> None:
    assert _linked(robot).split() == ["robot1", f"tls:{AT}:{robot.port}", "linked"]
    (linked,) = [each for each in robot.record() if each["what"].startswith("link host")]
    assert (linked["name"], linked["role"], linked["result"]) == (
        "owner1", "administrator", "done",
    )  # fmt: skip


def test_connectors_lead_from_host_to_host(robot: Robot) -> None:
    shell = robot.shell
    shell.ok("rtconf /robot1/ConsoleIn0.rtc set values 7")
    shell.ok("rtcon -i over /robot1/ConsoleIn0.rtc:out /localhost/Sink.rtc:in")
    shell.ok("rtact /robot1/ConsoleIn0.rtc")
    shell.ok("rtact /localhost/Sink.rtc")
    until(
        lambda: "received 7" in shell.ok("rtvlog --no-follow /localhost/Sink.rtc"), "values arrive"
    )
    shell.ok("rtdis -i over /localhost/Sink.rtc:in")
    assert "1/0" in shell.ok("rtls -l /robot1")


def test_a_component_moves_there_and_back_with_its_connections(robot: Robot) -> None:
    shell = robot.shell
    shell.ok("rtcon -i moved /localhost/Near.rtc:out /localhost/Sink.rtc:in")
    shell.ok("rtconf /localhost/Near.rtc set values 9")
    for at, to in (("localhost", "robot1"), ("robot1", "localhost")):
        assert shell.run(f"rtmove /{at}/Near.rtc /{to}/manager.mgr").status == 0
        assert "Near.rtc" in shell.ok(f"rtls /{to}")
        assert "Near.rtc" not in shell.ok(f"rtls /{at}")
        assert "Sink.rtc:in" in shell.ok(f"rtcat -l /{to}/Near.rtc:out")
        assert shell.ok(f"rtconf /{to}/Near.rtc get values").strip() == "9"


def test_a_link_is_made_again_when_the_port_is_back(robot: Robot) -> None:
    os.kill(robot.gateway(), signal.SIGKILL)
    until(lambda: "linked" not in _linked(robot), "the loss is told")
    until(lambda: _linked(robot).split()[-1:] == ["linked"], "it is linked again")
    assert "ConsoleIn0.rtc" in robot.shell.ok("rtls /robot1")


def test_a_port_that_is_silent_is_given_up(robot: Robot) -> None:
    gateway = robot.gateway()
    os.kill(gateway, signal.SIGSTOP)
    try:
        until(lambda: "no answer in" in _linked(robot), "the silence is told")
        done = robot.shell.run("rtls /robot1")
        assert done.status == 1
        assert "host robot1 cannot be reached" in done.err
    finally:
        os.kill(gateway, signal.SIGCONT)
    until(lambda: _linked(robot).split()[-1:] == ["linked"], "it is linked again")


@pytest.mark.parametrize("who", ["anna", "bert", "carl"])
def test_only_administrators_link_hosts(robot: Robot, who: str) -> None:
    with robot.connected(who) as client:
        answer = client.ask("%40x%2Frouter", "robot9")
        assert answer.error == "denied"
        assert f"{who} (" in str(answer.payload)
        assert "may not link host robot9: it takes administrator" in str(answer.payload)
    last = robot.record()[-1]
    assert (last["name"], last["what"], last["result"]) == (
        who, "link host robot9 at manager", "denied",
    )  # fmt: skip


def test_rubbish_on_a_link_ends_that_link_only(robot: Robot) -> None:
    with robot.connected("owner1") as client:
        assert client.ask("%40x%2Frouter", "robot9").error == ""
        end = client.detach()
        with contextlib.suppress(OSError):  # what lies unread there may end it without a farewell
            end.sendall(b"\xff" * 100_000)
            until(lambda: not end.recv(1 << 16), "the router hangs up")
    assert robot.is_alive()
    assert _linked(robot).split()[-1:] == ["linked"]


def test_a_link_that_is_made_again_ends_the_one_before(robot: Robot) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", robot.keys)
        issue("mia", "administrator", [], 30, f"{robot.keys}.mia")
    with contextlib.ExitStack() as stack:
        first, second = (stack.enter_context(robot.connected("owner1")) for _ in range(2))
        other = stack.enter_context(robot.connected("mia"))
        id = first.ask("%40x%2Frouter", "robot9").value()
        end = first.detach()
        end.setblocking(False)
        assert other.ask("%40x%2Frouter", f"robot9 {id}").value() not in ("", id)
        with pytest.raises(BlockingIOError):  # nobody else ends it
            end.recv(1 << 16)
        end.settimeout(BOUND_S)
        assert second.ask("%40x%2Frouter", f"robot9 {id}").value() not in ("", id)
        while end.recv(1 << 16):
            pass
    linked = [each["what"] for each in robot.record() if "robot9" in each["what"]]
    assert set(linked) == {"link host robot9 at manager"}
    assert _linked(robot).split()[-1:] == ["linked"]


def test_the_manager_there_is_the_one_that_is_meant(robot: Robot) -> None:
    shell = robot.shell
    shell.ok(f"rthost add robot2 tls:{AT}:{robot.port}")
    done = shell.run("rtmgr start --host robot2")
    assert done.status == 1
    assert "is manager manager of host robot1, not manager of robot2" in done.err
    assert shell.run("rthost add robot3 tls:10.0.0.7").status != 0
    assert shell.run("rthost add robot3 tls:me@10.0.0.7:2811").status != 0
    for line in ("rthost accept robot2 SHA256:x", "rtpkg list --host robot2"):
        done = shell.run(line)
        assert done.status == 1
        assert "robot2 is reached over TLS" in done.err, line
    done = shell.run("rtmgr stop --host robot2")
    assert "not manager of robot2" in done.err
    assert "the link to it has ended" in done.err
    assert robot.is_alive()
    shell.ok("rthost remove robot2")


def test_a_link_ends_with_the_certificate_that_made_it(robot: Robot) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", robot.keys)
        issue("max", "administrator", [], 30, f"{robot.keys}.max")
        with robot.connected("max") as client:
            assert client.ask("%40x%2Frouter", "robot9").error == ""
            revoke("max")
            told = Path(robot.keys, "revoked.crl").read_bytes()
            Path(f"{robot.keys}.robot1", "revoked.crl").write_bytes(told)
            end = client.detach()
            end.settimeout(BOUND_S)
            while end.recv(1 << 16):
                pass
    assert robot.is_alive()


def test_a_link_ends_when_the_host_there_is_revoked(robot: Robot) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", robot.keys)
        revoke("robot1")
    until(lambda: "revoked" in _linked(robot), "the link ends, and says why")
    assert robot.shell.run("rtls /robot1").status == 1
    assert robot.is_alive()
