"""Process of a link: joins the router of a manager here with that of a manager on another host.

It is a child of the manager here (`rtkit.manager.host_links`) and ends with it. The far router is
reached through an SSH connection, at whose end `rtkit.hosts.relay` runs, or over TLS; both routers
see one more router between them, whose access rules let nothing from the far side through but
replies and news of that host itself: a host that was taken over commands nobody here.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING

from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.hosts import far_program
from rtkit.hosts.connection import HostConnection, connect
from rtkit.hosts.host import Host
from rtkit.hosts.relay import READY, pump
from rtkit.hosts.ssh_config import way_to
from rtkit.link import host_links, places, unix, zenoh_keys
from rtkit.link.host_links import HostLink
from rtkit.link.processes import ProcessWatch
from rtkit.link.threads import start_thread
from rtkit.link.zenoh import ask_router_id, await_answerer, open_between, unix_endpoint
from rtkit.rtc.serde import decode_text

if TYPE_CHECKING:
    from paramiko.channel import Channel

    from rtkit.hosts.tls_connection import TlsConnection

_FIRST_S, _SOON_S, _DENIED_S, _MOST_S = 0.05, 1.0, 2.0, 30.0
"""Pause before a next try [s]: at first, for a host just lost, where nobody is let in, most."""
_AWAY_PART = 1 / 60
"""What part of the time that a host has been away may pass until it is looked for again."""
_KNOCK_S = 1.0
_CLOSE_S = 0.5
_MORE_S = 1.0
"""How much longer the far router bears silence than the process of the link, which says why [s]."""
_CHUNK = 1 << 16
_EVER_S = 1e6
_READY_S, _MOST = 10.0, 1 << 16
"""How long the relay may take until it is ready [s], and how much may come before [bytes]."""
_SHOWN = 500
_DIGITS = 10
"""Longer is no id of a process."""
_ROUTE_S = 5.0
"""How long the far manager may take to be heard of once the routers are joined [s]."""


def main() -> None:
    """Be the process: ``MANAGER HOST``, the host as JSON."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # meant for the manager, which says when to end
    manager, text = sys.argv[1:]
    host = decode_text(Host, text)
    with open("/proc/self/comm", "w", encoding="utf-8", errors="replace") as comm:
        comm.write(f"{host_links.COMM}{host.name}")
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGCONT])  # `_keep` waits for it
    watch = ProcessWatch(os.getppid())
    state = HostLink(host.name, manager, host.manager, host_links.NOT_YET, os.getpid())
    host_links.write(state)

    def await_manager() -> None:
        watch.await_end(_EVER_S)
        host_links.remove(host.name, os.getpid())
        os._exit(0)  # whatever the link waits for now

    start_thread(await_manager, "manager")
    _keep(host, state)


def _keep(host: Host, state: HostLink) -> None:
    """Hold the link, and make it again whenever it is lost; a signal of the manager hastens it."""
    linked_at, tries, relay = time.monotonic(), 0, ""
    while True:
        is_denied, tried_at = False, time.monotonic()
        with ExitStack() as stack:
            try:
                if tries:
                    _knock(host)
                lost, relay = _join(host, state.manager, stack, relay)
                host_links.write(state._replace(why=""))
                began = time.monotonic()
                why = lost()
                linked_at = time.monotonic()
                tries = 0 if linked_at - began > _SOON_S else tries
            except RtkitError as error:
                why, is_denied = str(error), isinstance(error, Refused)
            host_links.write(state._replace(why=why, refused_at=tried_at if is_denied else 0.0))
        pause_s = pause_until(tries, time.monotonic() - linked_at, is_denied=is_denied)
        signal.sigtimedwait([signal.SIGCONT], pause_s)
        tries += 1


def pause_until(tries: int, away_s: float, *, is_denied: bool) -> float:
    """Return how long to wait [s] until the next try, after so many that failed."""
    first_s, most_s = (_DENIED_S, _MOST_S) if is_denied else (_FIRST_S, _SOON_S)
    pause_s = min(first_s * (1 << min(tries, 10)), most_s)
    return min(max(pause_s, away_s * _AWAY_PART), _MOST_S)


def _knock(host: Host) -> None:
    """Try whether anything listens there: who is away is seen sooner than by a whole login.

    Raises:
        Unreachable: Nothing does.
    """
    if host.is_tls:
        address, port, place = host.address, host.port, str(host)
    else:
        way = way_to(host)
        while way.through is not None:
            way = way.through
        address, port, place = way.address, way.port, way.place
    try:
        socket.create_connection((address, port), _KNOCK_S).close()
    except OSError as error:
        text = error.strerror or "no answer"
        raise Unreachable(f"{host.name} ({place}): {text}") from error


def _join(host: Host, manager: str, stack: ExitStack, former: str) -> tuple[Callable[[], str], str]:
    """Join both routers; return what waits for the end of that and says why, and the id there.

    That is of the relay, or the connection. The one of the link before, empty without one, is
    ended first.

    Raises:
        RtkitError: They cannot be joined.
    """
    connection: HostConnection | TlsConnection
    channel: Channel | TlsConnection
    if host.is_tls:
        from rtkit.hosts.tls_connection import TlsConnection

        linked = stack.enter_context(TlsConnection(host, places.host_name(), former))
        connection, channel, relay = linked, linked, linked.id
    else:
        connection = stack.enter_context(connect(host))
        channel, relay = open_relay(connection, host, former)
    path = host_links.tunnel_socket(host.name)
    places.check_socket_length(path)
    listener = stack.enter_context(unix.listen(path))
    stack.callback(_wake, listener)
    over = threading.Event()
    reasons: list[str] = []
    counted = _CountedChannel(channel)

    def note(why: str) -> None:
        reasons.append(why)
        over.set()

    start_thread(lambda: splice(listener, counted, note), "tunnel")
    lease_ms = int(1000 * (connection.longest_silence_s + _MORE_S))
    near, tunnel = unix_endpoint(places.manager_socket(manager)), unix_endpoint(path)
    session = open_between((near, tunnel), rules(ask_router_id(near), host.name), lease_ms)
    # Zenoh may take 10 s where a neighbour is silent; the next link need not wait for that.
    stack.callback(lambda: start_thread(session.close, "closing").join(_CLOSE_S))
    # Routers tell each other of what they serve some time after they were joined.
    far = zenoh_keys.property_key(zenoh_keys.service(host.name, host.manager), "manager.pid")
    await_answerer(near, far, _ROUTE_S)
    start_thread(lambda: note(connection.await_silence(counted.seconds_ago)), "pings")

    def lost() -> str:
        over.wait()
        return reasons[0]

    return lost, relay


def open_relay(connection: HostConnection, host: Host, former: str = "") -> tuple[Channel, str]:
    """Start the relay; return its input and output once it is through to the manager there.

    With its id, empty for one that does not tell it. It ends the `former` one, of the link before.

    Raises:
        Unreachable: It is not; tells why.
    """
    python = far_program.python(connection)
    words = [host.manager, *([former] if former else [])]
    channel = connection.open([*python, "-m", "rtkit.hosts.relay", *words])
    until = time.monotonic() + _READY_S
    text, ready = bytearray(), f"{READY}\n".encode()
    with suppress(OSError):
        # The shell of the user may write lines of its own before; what follows is not to be read.
        while not text.endswith(ready) and len(text) < _MOST:
            channel.settimeout(max(0.001, until - time.monotonic()))
            data = channel.recv(1)
            if not data:
                break
            text += data
    if not text.endswith(ready):
        with suppress(OSError):
            text += channel.recv_stderr(2000)
        if channel.status_event.wait(_KNOCK_S) and channel.exit_status == far_program.NO_PROGRAM:
            raise Unreachable(f"{host.name}: {far_program.no_rtkit(host.name)}")
        why = " ".join(text[-_SHOWN:].decode("utf-8", "replace").split()) or "nothing answers"
        raise Unreachable(f"{host.name}: {why}")
    channel.settimeout(None)
    *_, own = b"", *text.removesuffix(ready).split()
    return channel, own.decode() if own.isdigit() and len(own) < _DIGITS else ""


def _wake(listener: socket.socket) -> None:
    """Have who waits in `accept` wait no longer."""
    with suppress(OSError):
        listener.shutdown(socket.SHUT_RDWR)


class _CountedChannel:
    """Tells when the far side was last heard: in a flood of data an answer comes late."""

    def __init__(self, channel: Channel | TlsConnection) -> None:
        self._channel = channel
        self._at = 0.0
        self.sendall = channel.sendall

    def recv(self, size: int) -> bytes:
        data = self._channel.recv(size)
        self._at = time.monotonic()
        return data

    def seconds_ago(self) -> float:
        return time.monotonic() - self._at


def splice(
    listener: socket.socket, channel: Channel | _CountedChannel, note: Callable[[str], object]
) -> None:
    """Pass what the one connection to the tunnel says, and hears."""

    def outward(end: socket.socket) -> None:
        pump(lambda: end.recv(_CHUNK), channel.sendall)
        note("the router there is silent, or says what is no sense")  # so that here has hung up

    with suppress(OSError):
        end, _ = listener.accept()
        with end:
            start_thread(lambda: outward(end), "outward")
            pump(lambda: channel.recv(_CHUNK), end.sendall)
    note("the manager there has hung up: it has ended, or heard nothing in time")


def rules(near_id: str, host: str) -> str:
    """Return the access rules: all to the near router, to the far one what is its host's own.

    Besides, its managers and services may ask those of others what these declare for it alone, and
    send and take data on keys that name its host: who is at their other end has let it.
    """
    own, data = zenoh_keys.all_of_host(host), zenoh_keys.data_between(host)
    to, by = zenoh_keys.questions_to(host), zenoh_keys.questions_by(host)
    every = [*zenoh_keys.all_of_host("*"), *zenoh_keys.questions_by("*")]
    every += zenoh_keys.data_between("*")
    reading = ["query", "declare_subscriber", "liveliness_query", "declare_liveliness_subscriber"]
    answering = ["put", "delete", "reply", "declare_queryable", "liveliness_token"]
    asking = ["query", "declare_subscriber", "liveliness_query"]
    both = ["put", "delete", "query", "declare_subscriber", "reply", "declare_queryable"]
    between = ["answers", "is asked", "asks", "is answered", "data"]
    return json.dumps(
        {
            "enabled": True,
            "default_permission": "deny",
            "rules": [
                _rule("all", ["ingress", "egress"], [*reading, *answering], every),
                _rule("told", ["ingress"], answering, own),
                _rule("asked", ["egress"], reading, own),
                _rule("answers", ["ingress"], answering, to),
                _rule("is asked", ["egress"], asking, to),
                _rule("asks", ["ingress"], asking, by),
                _rule("is answered", ["egress"], answering, by),
                _rule("data", ["ingress", "egress"], both, data),
            ],
            "subjects": [{"id": "near", "zids": [near_id]}, {"id": "both"}],
            "policies": [
                {"rules": ["all"], "subjects": ["near"]},
                {"rules": ["told", "asked", *between], "subjects": ["both"]},
            ],
        }
    )


def _rule(name: str, flows: list[str], messages: list[str], keys: list[str]) -> dict[str, object]:
    rule = {"id": name, "permission": "allow", "flows": flows}
    return {**rule, "messages": messages, "key_exprs": keys}


if __name__ == "__main__":
    main()
    os._exit(0)  # threads of zenoh and paramiko must not keep the process
