"""A SET that was given up while its service was stopped is not done later, whatever carried it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import icekit
import pytest
from mosquittokit import MOSQUITTO, PASSWORD, Mosquitto
from serialkit import Cable

from rtkit.errors import Unreachable
from rtkit.wires.http.client import connect_http
from rtkit.wires.ice.client import connect_ice
from rtkit.wires.serial.client import connect_serial

PATIENCE_S = 1.0
needs_ice = pytest.mark.skipif(not icekit.IS_THERE, reason=icekit.MISSING)
needs_mosquitto = pytest.mark.skipif(MOSQUITTO is None, reason="there is no mosquitto")
ENDPOINTS = ["http", "serial", pytest.param("ice", marks=needs_ice)]
CONNECT: dict[str, Callable[[str, float], Any]] = {
    "http": lambda address, timeout_s: connect_http(
        address.removesuffix("/ps/bot"), timeout_s, "bot"
    ),
    "serial": connect_serial,
    "ice": connect_ice,
}


@pytest.fixture
def cable(shell: Any) -> Iterator[Cable]:
    cable = Cable(str(shell.folder))
    yield cable
    cable.close()


@pytest.fixture
def served(
    shell: Any, cable: Cable, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Callable[[str], tuple[Any, str]]]:
    """Serves an object over a wire; returns the process and the address there."""
    (shell.folder / "bot.py").write_text("class Bot:\n    speed: float = 1.0\n")
    for name in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
        monkeypatch.setenv(name, shell.environment[name])
    if icekit.FOLDER:
        shell.environment["PYTHONPATH"] += os.pathsep + icekit.FOLDER
    services = []

    def serve(wire: str) -> tuple[Any, str]:
        more = {"serial": "--serial far --allow-set speed"}.get(wire, f"--{wire} 0")
        services.append(shell.open(f"rtserve bot:Bot bot {more if wire else ''}"))
        told = services[0].stdout.readline()
        found = re.search(rf"{wire}://\S+", told) if wire else None
        return services[0], f"serial:{cable.near}" if wire == "serial" else found[
            0
        ] if found else ""

    yield serve
    for each in services:
        each.terminate()
        each.communicate(timeout=30)


@contextmanager
def stopped(process: subprocess.Popen[str]) -> Iterator[None]:
    """Have a process stand still."""
    process.send_signal(signal.SIGSTOP)
    try:
        yield
    finally:
        process.send_signal(signal.SIGCONT)


@pytest.mark.parametrize("wire", ENDPOINTS)
def test_a_value_set_before_a_stopped_service_is_not_set_later(
    shell: Any, served: Callable[[str], tuple[Any, str]], wire: str
) -> None:
    service, address = served(wire)
    with CONNECT[wire](address, PATIENCE_S) as client:
        client.ask("speed", "2").value()
        with stopped(service), pytest.raises(Unreachable, match="no answer within"):
            client.ask("speed", "7")
        assert client.ask("speed").value() == "2.0"  # behind what lies in the queue
        assert shell.ok("rtget bot/speed") == "2.0\n"


@pytest.mark.parametrize("wire", ["", "zenoh", *ENDPOINTS])
def test_a_proxy_passes_on_how_much_time_is_left(
    shell: Any, served: Callable[[str], tuple[Any, str]], wire: str
) -> None:
    service, address = served("" if wire == "zenoh" else wire)
    origin = {
        "": "bot",
        "zenoh": "zenoh:bot",
    }.get(wire, address)
    with carried(shell, origin, "far"):
        shell.ok("rtset far/speed 2")
        with stopped(service):
            given_up(shell, "far/speed")
        assert shell.ok("rtget far/speed bot/speed") == "2.0\n2.0\n"


@needs_mosquitto
def test_a_broker_passes_on_how_much_time_is_left(
    shell: Any, served: Callable[[str], tuple[Any, str]]
) -> None:
    served("")
    broker = Mosquitto(shell.folder)
    shell.environment["RTKIT_MQTT_PASSWORD"] = PASSWORD
    try:
        topic = broker.address("lab")
        with carried(shell, "bot", topic) as near, carried(shell, f"{topic}/bot", "far"):
            shell.ok("rtset far/speed 2")
            with stopped(near):
                given_up(shell, "far/speed")
            assert shell.ok("rtget far/speed") == "2.0\n"
    finally:
        broker.stop()


def given_up(shell: Any, name: str) -> None:
    """Set a value that nobody can take in time."""
    status, _, err = shell.run(f"rtset --timeout {PATIENCE_S} {name} 7")
    assert (status, "timeout" in err) == (1, True), err


@contextmanager
def carried(shell: Any, origin: str, target: str) -> Iterator[subprocess.Popen[str]]:
    """Run a proxy."""
    proxy = shell.open(f"rtproxy {origin} {target} --allow-set '*'")
    assert proxy.stdout.readline(), proxy.stderr.read()
    try:
        yield proxy
    finally:
        proxy.terminate()
        proxy.communicate(timeout=30)
