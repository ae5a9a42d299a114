"""What other hosts reach: mutual TLS, or what was told to be insecure and is shown."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from conformance import subject

import rtkit
from rtkit.errors import Refused
from rtkit.keys import reach
from rtkit.link import insecure
from rtkit.proxy.bridge import bridge
from rtkit.wires.http.client import connect_http
from rtkit.wires.serve import serve

_LISTEN = {
    "serving/acceptor.py", "link/unix.py", "link/tcp_endpoint.py",
    "wires/line/endpoint.py", "manager/daemon.py", "manager/slaves/warm_up.py",
    "cli/managers/doctor/live.py",
}  # fmt: skip
"""Modules that bind sockets: of a folder of this user, of loopback, or where the rule lets them."""


@pytest.mark.parametrize("scheme", ["tcp", "http", "mqtt", "ice", "tcps", "https", "mqtts", "tls"])
@pytest.mark.parametrize("host", ["0.0.0.0", "::", "10.0.0.7", "robot1", "127.0.0.1.example.org"])
def test_beyond_loopback_there_is_tls_or_it_is_told_insecure(scheme: str, host: str) -> None:
    for is_insecure in (False, True):
        is_let = scheme in reach.BEHIND_TLS or (is_insecure and scheme != "ice")
        if is_let:
            reach.check(scheme, host, is_insecure=is_insecure)
        else:
            with pytest.raises(Refused, match="nothing would be encrypted"):
                reach.check(scheme, host, is_insecure=is_insecure)


@pytest.mark.parametrize("host", ["", "localhost", "127.0.0.1", "127.9.9.9", "::1", "[::1]"])
def test_this_host_is_let_in_without(host: str) -> None:
    reach.check("ice", host)


def test_only_few_modules_bind_sockets() -> None:
    """Whoever adds a way to listen has to ask the rule."""
    root = Path(rtkit.__file__).parent
    found = {
        str(file.relative_to(root))
        for file in root.rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
        and node.func.attr == "bind" and not node.keywords and len(node.args) == 1
    } - {"component/services/interface.py"}  # fmt: skip
    assert found <= _LISTEN, found - _LISTEN


@pytest.mark.parametrize("wire", ["port", "http", "ice"])
def test_no_wire_opens_a_plain_port_to_others_unless_told(place: str, wire: str) -> None:
    with pytest.raises(Refused, match="on this host only, not"):
        serve(subject(), "robot", is_on_zenoh=False, **{wire: "0.0.0.0:0"})
    with serve(subject(), "robot", is_on_zenoh=False) as served:
        source = f"unix:{served.socket}"
        with pytest.raises(Refused, match="on this host only, not"):
            bridge(source, f"{wire.replace('port', 'tcp')}:0.0.0.0:0")
    assert insecure.noted() == []


def test_what_is_insecure_is_noted_as_long_as_it_listens(place: str) -> None:
    with serve(
        subject(), "robot", is_on_zenoh=False, is_insecure=True, port="0.0.0.0:0",
        http="0.0.0.0:0", tls=None,
    ) as served, serve(subject(), "other", is_on_zenoh=False, port=0):  # fmt: skip
        assert insecure.noted() == sorted(served.addresses.values())
        address = served.addresses["http"].partition("/ps")[0]
        with connect_http(address, 20.0, "robot") as client:
            assert client.ask("count").payload == "7"
        elsewhere = address.replace(address.split(":")[1], "//127.0.0.2")
        with connect_http(elsewhere, 20.0, "robot") as client:
            assert client.ask("count").payload == "7"
        assert "not the host 'evil.example.org'" in _ask_by_other_name(address)
    assert insecure.noted() == []


def _ask_by_other_name(address: str) -> str:
    """Ask as a page does whose name was bound anew to this host."""
    from http.client import HTTPConnection

    connection = HTTPConnection("127.0.0.1", int(address.rpartition(":")[2]), timeout=20)
    connection.request("GET", "/ps/robot/count", headers={"Host": "evil.example.org"})
    text = connection.getresponse().read().decode()
    connection.close()
    return text
