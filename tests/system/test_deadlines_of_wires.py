"""A SET that was given up while its service was stopped is not done later, whatever carried it."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import icekit
import pytest
from mosquittokit import MOSQUITTO, PASSWORD, Mosquitto
from property_endpoints import SERVED, params
from serialkit import Cable

from rtkit.keys.reach import BEHIND_TLS
from rtkit.wires.table import WIRES, wire_of

PATIENCE_S = 1.0
needs_mosquitto = pytest.mark.skipif(MOSQUITTO is None, reason="there is no mosquitto")


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
        option = WIRES[wire].option if wire else None
        if wire in BEHIND_TLS:
            shell.ok("rtkeys init")
        value = {"DEVICE": "far --allow-set speed", "PATH": "bot.sock"}
        more = "" if option is None else f"--{option.name} {value.get(option.metavar, 0)}"
        services.append(shell.open(f"rtserve bot:Bot bot {more}"))
        *_, address = services[0].stdout.readline().split()
        if option is not None and not option.knows_clients:
            address = wire_of(wire).source.replace("DEVICE", cable.near)
        port = address.removeprefix("tcps:")
        is_of_tcp = port.startswith("localhost:")
        return services[0], f"{wire}:{port}/bot" if is_of_tcp else address

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


@pytest.mark.parametrize("wire", params(*SERVED))
def test_a_value_set_before_a_stopped_service_is_not_set_later(
    shell: Any, served: Callable[[str], tuple[Any, str]], wire: str
) -> None:
    service, address = served(wire)
    shell.ok(f"rtset {address}/speed 2")
    with stopped(service):
        given_up(shell, f"{address}/speed")
    assert shell.ok(f"rtget {address}/speed") == "2.0\n"  # behind what lies in the queue
    assert shell.ok("rtget bot/speed") == "2.0\n"


@pytest.mark.parametrize("wire", ["", "zenoh", *params(*SERVED)])
def test_a_proxy_passes_on_how_much_time_is_left(
    shell: Any, served: Callable[[str], tuple[Any, str]], wire: str
) -> None:
    service, address = served("" if wire == "zenoh" else wire)
    with carried(shell, {"": "bot", "zenoh": "zenoh:bot"}.get(wire, address), "far"):
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
