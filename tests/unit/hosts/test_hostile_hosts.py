"""Answers of a host that means harm: bounded in size and time, and taken for what they are."""

from __future__ import annotations

import os
import socket
import threading
import time
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from rtkit.errors import Malformed, Refused, Unreachable
from rtkit.hosts import bring_up, far_side, link_process, provisioned, wheels
from rtkit.hosts.connection import Done, read_all
from rtkit.hosts.far_side import FarSide, HostLook
from rtkit.hosts.host import Host
from rtkit.hosts.wheels import WheelSet
from rtkit.link import unix
from rtkit.rtc.serde import encode_text

HOST = Host("robot1", "10.0.0.1")
GOOD = FarSide(
    python=(3, 11, 2), implementation="cpython", abi="", machine="x86_64",
    libc=("glibc", "2.36"), has_venv=True, home="/home/pi", hostname="pi", user="pi",
    has_linger=True, has_systemd=True, free_bytes=1 << 40, is_writable=True,
    memory_bytes=1 << 30, processors=4, time_s=0.0, current="",
)  # fmt: skip


class Answering:
    """Connection to a host that says the same to every command."""

    host = HOST

    def __init__(self, out: str) -> None:
        self.out = out

    def run(self, *_command: Any, **_options: Any) -> Done:
        return Done(0, self.out, "")


@pytest.mark.parametrize(
    "machine", ["x/../../../../root/.ssh/id", "../x", "", "x" * 99, "x86_64\n", "--pre"]
)
def test_a_machine_is_a_name_of_a_folder_or_refused(machine: str) -> None:
    assert not GOOD.obstacles()
    assert replace(GOOD, machine=machine).obstacles()


@pytest.mark.parametrize("version", ["../..", "2.x", "", "2.36/..", "2." + 99 * "9"])
def test_a_c_library_has_a_number_or_is_refused(version: str) -> None:
    assert replace(GOOD, libc=("glibc", version)).obstacles()


@pytest.mark.parametrize("text", ["", "no", "[]", "[" * 99_999, "{}", '{"python": "3"}'])
def test_what_makes_no_sense_is_told_of_its_host(text: str, monkeypatch: Any) -> None:
    made = WheelSet("1", {"a.whl": "/a.whl"}, {"a.whl": "00"})
    monkeypatch.setattr(wheels, "wheels_for", lambda _kind: made)
    connection: Any = Answering(text)
    with pytest.raises(Malformed, match="robot1"):
        far_side.look(connection)
    with pytest.raises(Malformed):
        provisioned.provision(connection, HostLook(GOOD), print)


def test_only_wheels_of_rtkit_are_sent(monkeypatch: Any) -> None:
    made = WheelSet("1", {"a.whl": "/a.whl"}, {"a.whl": "00"})
    monkeypatch.setattr(wheels, "wheels_for", lambda _kind: made)
    connection: Any = Answering('{"wheels": "/x", "lacking": ["/etc/shadow"], "made": false}')
    with pytest.raises(Malformed, match="no wheel of rtkit"):
        provisioned.provision(connection, HostLook(GOOD), print)


def test_wheels_that_others_may_change_are_sent_nowhere(tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv("RTKIT_RUNTIME_DIR", raising=False)
    os.makedirs(wheels.cache_folder())
    os.chmod(wheels.cache_folder(), 0o777)
    with pytest.raises(Refused):
        wheels.wheels_for(GOOD.kind)


def test_a_host_that_bears_the_name_of_this_one_is_not_even_asked() -> None:
    near: Any = SimpleNamespace(host="robot1.local")
    with pytest.raises(Refused, match="the name of this host"):
        bring_up.start(HOST, near, print, replaces=True, timeout_s=1.0)


def test_what_a_host_writes_without_end_is_broken_off() -> None:
    near, far = socket.socketpair()
    with near, far:
        channel: Any = near
        with pytest.raises(TimeoutError):
            read_all(channel, near.recv, time.monotonic() + 0.01)
        with pytest.raises(Refused, match="more than 16 MiB"):
            read_all(channel, lambda most: b"x" * most, time.monotonic() + 60.0)


def test_the_first_line_of_a_relay_is_not_awaited_for_ever() -> None:
    channel = SimpleNamespace(
        settimeout=lambda _s: None, recv=lambda most: b"x" * most, recv_stderr=lambda _most: b"\x1b"
    )
    connection: Any = SimpleNamespace(host=HOST, open=lambda _command: channel)
    with pytest.raises(Unreachable, match="robot1: xxx"):
        link_process.open_relay(connection, HOST)


def test_a_tunnel_from_which_the_router_here_hangs_up_is_over(tmp_path: Any) -> None:
    near, far = socket.socketpair()
    over, path = threading.Event(), str(tmp_path / "tunnel")
    channel: Any = near
    with near, far, unix.listen(path) as listener:
        arguments = (listener, channel, lambda _why: over.set())
        splicing = threading.Thread(target=link_process.splice, args=arguments, daemon=True)
        splicing.start()
        unix.connect(path).close()
        assert over.wait(10.0)
    splicing.join(10.0)


def test_a_host_is_as_it_was_given() -> None:
    assert far_side.look(Answering(encode_text(GOOD))).far == GOOD  # type: ignore[arg-type]
