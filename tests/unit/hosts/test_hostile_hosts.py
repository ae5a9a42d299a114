"""Answers of a host that means harm: bounded in size and time, and taken for what they are."""

from __future__ import annotations

import itertools
import os
import socket
import threading
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from rtkit.errors import Malformed, NotFound, Refused, Unreachable
from rtkit.hosts import bring_up, far_program, far_side, link_process, provisioned, wheels
from rtkit.hosts.far_program import MARK
from rtkit.hosts.far_side import FarSide
from rtkit.hosts.host import Host
from rtkit.hosts.progress import unshown
from rtkit.hosts.relay import READY
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
    """Connection to a host that says the same to every command, and then nothing, or the same."""

    host = HOST

    def __init__(self, out: str, *, is_endless: bool = False) -> None:
        self.out, self.is_endless = out.encode(), is_endless

    def open(self, _command: object) -> Any:
        texts = itertools.repeat(self.out) if self.is_endless else iter([self.out, b""])
        ended = threading.Event()
        ended.set()
        names = ("settimeout", "set_combine_stderr", "sendall", "shutdown_write", "close")
        ended_text: dict[str, Any] = {"recv_stderr": lambda _most: b""}
        ignored: dict[str, Any] = {name: lambda *_words: None for name in names}
        return SimpleNamespace(
            recv=lambda _most: next(texts),
            status_event=ended,
            exit_status=0,
            **ignored,
            **ended_text,
        )


def test_what_a_program_reads_is_sent_piece_by_piece() -> None:
    connection, sizes = Answering(f"{MARK}done\n"), list[int]()
    opened = connection.open(())
    opened.sendall = lambda data: sizes.append(len(data))
    connection.open = lambda _command: opened  # type: ignore[method-assign]
    with open("/dev/zero", "rb") as zeros:
        file = SimpleNamespace(read=lambda most: zeros.read(most) if sum(sizes) < 9 << 20 else b"")
        assert far_program.ask(connection, (), file, timeout_s=1.0) == "done"  # type: ignore[arg-type]
    assert (sum(sizes) >= 9 << 20, max(sizes) <= 1 << 20) == (True, True)


def test_a_program_that_takes_nothing_is_waited_for_once() -> None:
    connection, waits = Answering(""), list[int]()

    def take_nothing(_data: bytes) -> None:
        waits.append(1)
        raise TimeoutError

    opened = connection.open(())
    opened.sendall, opened.recv = take_nothing, take_nothing
    connection.open = lambda _command: opened  # type: ignore[method-assign]
    with pytest.raises(Unreachable, match="robot1: no answer in 1 s"):
        far_program.ask(connection, (), bytes(9), timeout_s=1.0)  # type: ignore[arg-type]
    assert len(waits) == 1


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
    monkeypatch.setattr(wheels, "wheels_for", lambda _kind, _extras: made)
    connection: Any = Answering(f"{MARK}{text}\n")
    with pytest.raises(Malformed, match="robot1"):
        far_side.look(connection)
    with pytest.raises(Malformed, match="robot1"):
        provisioned.provision(connection, GOOD)


def test_only_wheels_of_rtkit_are_sent(monkeypatch: Any) -> None:
    made = WheelSet("1", {"a.whl": "/a.whl"}, {"a.whl": "00"})
    monkeypatch.setattr(wheels, "wheels_for", lambda _kind, _extras: made)
    lacking = '{"wheels": "/x", "lacking": {"/etc/shadow": 0}, "made": false, "removed": []}'
    connection: Any = Answering(f"{MARK}{lacking}\n")
    with pytest.raises(Malformed, match="no wheel of rtkit"):
        provisioned.provision(connection, GOOD)


def test_the_host_for_which_there_is_no_wheel_is_named(monkeypatch: Any) -> None:
    def none(_kind: object, _extras: object) -> WheelSet:
        raise NotFound("no wheels for cp399-glibc2.36-riscv64: none of lxml")

    monkeypatch.setattr(wheels, "wheels_for", none)
    connection: Any = SimpleNamespace(host=HOST)  # nothing is asked there, and nothing copied
    with pytest.raises(NotFound, match="robot1: no wheels for cp399"):
        provisioned.provision(connection, GOOD)


def test_a_machine_that_is_no_name_is_refused_also_where_a_version_is(monkeypatch: Any) -> None:
    monkeypatch.setattr(
        wheels, "wheels_for", lambda _kind, _extras: pytest.fail("looked for wheels")
    )
    connection: Any = Answering("")
    far = replace(GOOD, machine="../x", current="1", free_bytes=0)
    with pytest.raises(Refused, match="no machine with wheels"):
        provisioned.provision(connection, far)


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
        bring_up.start(HOST, near, unshown, replaces=True, timeout_s=1.0)


def test_what_a_host_writes_without_end_is_broken_off() -> None:
    connection: Any = Answering("x" * (1 << 16), is_endless=True)
    with pytest.raises(Refused, match="it writes without end: xxx"):
        far_program.ask(connection, ["python3"], timeout_s=60.0)
    connection = Answering("x", is_endless=True)
    with pytest.raises(Refused, match="it writes without end: x"):
        far_program.ask(connection, ["python3"], timeout_s=0.001)


def test_the_first_line_of_a_relay_is_not_awaited_for_ever() -> None:
    channel = SimpleNamespace(
        settimeout=lambda _s: None,
        recv=lambda most: b"x" * most,
        recv_stderr=lambda _most: b"\x1b",
        status_event=threading.Event(),
    )
    connection: Any = SimpleNamespace(host=HOST, open=lambda _command: channel)
    with pytest.raises(Unreachable, match="robot1: xxx"):
        link_process.open_relay(connection, HOST)


def test_a_host_that_has_lost_its_rtkit_is_told_with_the_cure() -> None:
    connection: Any = Answering("")
    channel = connection.open(())
    channel.recv_stderr = lambda _most: b"env: 'python': No such file or directory"
    channel.exit_status = 127
    connection.open = lambda _command: channel
    with pytest.raises(
        Unreachable, match=r"robot1: there is no rtkit.*: rtmgr start --host robot1"
    ):
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


@pytest.mark.parametrize("noise", ["", "Welcome\n", "\x1b[1mWelcome, {you}", f"{MARK}no\n"])
def test_a_host_is_as_it_says_whatever_its_shell_says(noise: str) -> None:
    connection: Any = Answering(f"{noise}{MARK}{encode_text(GOOD)}\nBye\n")
    assert far_side.look(connection) == GOOD


@pytest.mark.parametrize(
    ("told", "relay"),
    [("", ""), ("\n4711\n", "4711"), (f"\n{'9' * 5000}\n", ""), ("\n-1\n", ""), ("\n1e3\n", "")],
)
def test_a_relay_is_heard_behind_what_the_shell_says(told: str, relay: str) -> None:
    said = iter(b"Welcome\nhow do you do? " + f"{told}{READY}\n\0binary".encode())
    channel = SimpleNamespace(
        settimeout=lambda _s: None, recv=lambda most: bytes(itertools.islice(said, most))
    )
    connection: Any = SimpleNamespace(host=HOST, open=lambda _command: channel)
    opened: Any = link_process.open_relay(connection, HOST)
    assert (opened[0].recv(99), opened[1]) == (b"\0binary", relay)
