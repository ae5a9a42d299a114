"""Process of a link: joins the router of a manager here with that of a manager on another host.

It is a child of the manager here (`rtkit.manager.host_links`) and ends with it. The far router is
reached through an SSH connection, at whose end `rtkit.hosts.relay` runs; both routers see one more
router between them, whose access rules let nothing from the far side through but replies and news
of that host itself: a host that was taken over commands nobody here.
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

from rtkit.errors import RtkitError, Unreachable
from rtkit.hosts import provisioned
from rtkit.hosts.connection import HostConnection, connect
from rtkit.hosts.host import Host
from rtkit.hosts.relay import READY, pump
from rtkit.link import host_links, places, unix, zenoh_keys
from rtkit.link.host_links import HostLink
from rtkit.link.processes import ProcessWatch
from rtkit.link.threads import start_thread
from rtkit.link.zenoh import ask_router_id, await_answerer, open_between, unix_endpoint
from rtkit.rtc.serde import decode_text

if TYPE_CHECKING:
    import zenoh
    from paramiko.channel import Channel

_FIRST_S, _MOST_S = 0.05, 2.0
"""How long until the next try after a failure, at first and at most [s]."""
_LEASE_MS = 1500
_CHUNK = 1 << 16
_EVER_S = 1e6
_READY_S, _LINE = 10.0, 2000
"""How long the relay may take for its first line [s], and how long that is at most [bytes]."""
_ROUTE_S = 5.0
"""How long the far manager may take to be heard of once the routers are joined [s]."""


def main() -> None:
    """Be the process: ``MANAGER HOST``, the host as JSON."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # meant for the manager, which says when to end
    manager, text = sys.argv[1:]
    host = decode_text(Host, text)
    with open("/proc/self/comm", "w", encoding="utf-8", errors="replace") as comm:
        comm.write(f"rtkit-> {host.name}")
    watch = ProcessWatch(os.getppid())
    ended = threading.Event()

    def await_manager() -> None:
        watch.await_end(_EVER_S)
        ended.set()

    start_thread(await_manager, "manager")
    _keep(manager, host, ended)


def _keep(manager: str, host: Host, ended: threading.Event) -> None:
    """Hold the link, and make it again whenever it is lost, until the manager ends."""
    state = HostLink(host.name, manager, host.manager, "not linked yet", os.getpid())
    pause_s = _FIRST_S
    while not ended.is_set():
        began = time.monotonic()
        with ExitStack() as stack:
            try:
                lost = _join(host, manager, stack)
                host_links.write(state._replace(why=""))
                why = lost()
            except RtkitError as error:
                why = str(error)
        host_links.write(state._replace(why=why))
        pause_s = _FIRST_S if time.monotonic() - began > _MOST_S else min(2 * pause_s, _MOST_S)
        ended.wait(pause_s)
    host_links.remove(host.name)


def _join(host: Host, manager: str, stack: ExitStack) -> Callable[[], str]:
    """Join both routers; return what waits for the end of that, and says why it ended.

    Raises:
        RtkitError: They cannot be joined.
    """
    connection = stack.enter_context(connect(host))
    channel = open_relay(connection, host)
    path = host_links.tunnel_socket(host.name)
    places.check_socket_length(path)
    listener = stack.enter_context(unix.listen(path))
    over = threading.Event()
    reasons: list[str] = []

    def note(why: str) -> None:
        reasons.append(why)
        over.set()

    start_thread(lambda: splice(listener, channel, note), "tunnel")
    session = _open(host, places.manager_socket(manager), path)
    stack.callback(session.close)
    # Routers tell each other of what they serve some time after they were joined.
    far = zenoh_keys.property_key(zenoh_keys.service(host.name, host.manager), "manager.pid")
    await_answerer(unix_endpoint(places.manager_socket(manager)), far, _ROUTE_S)
    start_thread(lambda: note(connection.await_silence()), "pings")

    def lost() -> str:
        over.wait()
        return reasons[0]

    return lost


def open_relay(connection: HostConnection, host: Host) -> Channel:
    """Start the relay; return its input and output once it is through to the manager there.

    Raises:
        Unreachable: It is not; tells why.
    """
    python = provisioned.python(connection)
    channel = connection.open([*python, "-m", "rtkit.hosts.relay", host.manager])
    until = time.monotonic() + _READY_S
    line = b""
    with suppress(OSError):
        while not line.endswith(b"\n") and len(line) < _LINE:
            channel.settimeout(max(0.001, until - time.monotonic()))
            data = channel.recv(1)
            if not data:
                break
            line += data
    if line.decode("utf-8", "replace").strip() != READY:
        with suppress(OSError):
            line += channel.recv_stderr(2000)
        text = " ".join(line.decode("utf-8", "replace").split()) or "nothing answers"
        raise Unreachable(f"{host.name}: {text}")
    channel.settimeout(None)
    return channel


def splice(listener: socket.socket, channel: Channel, note: Callable[[str], object]) -> None:
    """Pass what the one connection to the tunnel says, and hears."""

    def outward(end: socket.socket) -> None:
        pump(lambda: end.recv(_CHUNK), channel.sendall)
        note("the router there is silent, or says what is no sense")  # so that here has hung up

    with suppress(OSError):
        end, _ = listener.accept()
        with end:
            start_thread(lambda: outward(end), "outward")
            pump(lambda: channel.recv(_CHUNK), end.sendall)
    note("the manager there has ended, or the relay to it")


def _open(host: Host, near: str, tunnel: str) -> zenoh.Session:
    """Open the router in between.

    Raises:
        Unreachable: One of both does not answer.
    """
    ends = (unix_endpoint(near), unix_endpoint(tunnel))
    return open_between(ends, rules(ask_router_id(ends[0]), host.name), _LEASE_MS)


def rules(near_id: str, host: str) -> str:
    """Return the access rules: all to the near router, to the far one what is its host's own."""
    own, every = zenoh_keys.all_of_host(host), zenoh_keys.all_of_host("*")
    reading = ["query", "declare_subscriber", "liveliness_query", "declare_liveliness_subscriber"]
    answering = ["put", "delete", "reply", "declare_queryable", "liveliness_token"]
    return json.dumps(
        {
            "enabled": True,
            "default_permission": "deny",
            "rules": [
                _rule("all", ["ingress", "egress"], [*reading, *answering], every),
                _rule("told", ["ingress"], answering, own),
                _rule("asked", ["egress"], reading, own),
            ],
            "subjects": [{"id": "near", "zids": [near_id]}, {"id": "both"}],
            "policies": [
                {"rules": ["all"], "subjects": ["near"]},
                {"rules": ["told", "asked"], "subjects": ["both"]},
            ],
        }
    )


def _rule(name: str, flows: list[str], messages: list[str], keys: list[str]) -> dict[str, object]:
    rule = {"id": name, "permission": "allow", "flows": flows}
    return {**rule, "messages": messages, "key_exprs": keys}


if __name__ == "__main__":
    main()
    os._exit(0)  # threads of zenoh and paramiko must not keep the process
