"""A service that speaks lines and HTTP only has no zenoh in its process until it is needed."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from waiting import until

from rtkit.link import places, zenoh_keys
from rtkit.link.places import host_name
from rtkit.link.zenoh import ask, open_client, open_to_service, unix_endpoint

BOUND_S = 30.0
ARM = """
class Arm:
    def __init__(self):
        self.angle = 0.5
"""


@pytest.fixture(autouse=True)
def same_places(shell: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Clients of the test look for sockets where those of its commands are."""
    for name in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR", "RTKIT_HOSTNAME"):
        if name in shell.environment:
            monkeypatch.setenv(name, shell.environment[name])


@pytest.fixture
def arm(shell: Any) -> Iterator[Any]:
    """A service in a process of its own, where no manager runs."""
    (shell.folder / "arm.py").write_text(ARM, encoding="utf-8")
    process = shell.open("rtserve arm:Arm arm --port 0 --http 0")
    _, process.address, process.web = process.stdout.readline().split()
    yield process
    process.send_signal(signal.SIGTERM)
    assert process.communicate(timeout=BOUND_S) == ("", "")
    assert process.returncode == 0
    assert not os.path.exists(places.service_key_socket("arm"))


def _has_zenoh(process: Any) -> bool:
    with open(f"/proc/{process.pid}/maps", encoding="utf-8") as file:
        return "zenoh" in file.read()


def _angle_by(endpoint: str) -> str:
    session = open_client(endpoint, BOUND_S)
    try:
        key = zenoh_keys.of_target(zenoh_keys.property_service(host_name(), "arm"), "angle")
        found = [reply.ok.payload.to_string() for reply in ask(session, key, BOUND_S) if reply.ok]
    finally:
        session.close()  # type: ignore[no-untyped-call]
    return found[0] if found else ""


def test_lines_and_http_need_none(shell: Any, arm: Any) -> None:
    for target in ("arm.angle", f"tcp:{arm.address}/arm.angle", f"{arm.web}/angle"):
        assert shell.ok(f"rtget {target}") == "0.5\n"
        assert shell.ok(f"rtset {target} 0.5") == ""
    listening = shell.open("rtlisten --queue 9 arm.angle")
    assert listening.stdout.readline() == "0.5\n"
    proxy = shell.open("rtproxy arm tcp:0")
    address = proxy.stdout.readline().strip()
    assert shell.ok(f"rtget {address}/arm.angle") == "0.5\n"
    assert shell.ok("rtls arm") == "angle\n"
    for process in (arm, listening, proxy):
        assert not _has_zenoh(process)
    for process in (listening, proxy):
        process.terminate()
        process.communicate(timeout=BOUND_S)


def test_who_connects_to_its_zenoh_socket_has_it_loaded(shell: Any, arm: Any) -> None:
    near = shell.open("rtproxy zenoh:arm tcp:0")
    address = near.stdout.readline().strip()
    assert shell.ok(f"rtget {address}/arm.angle") == "0.5\n"
    assert _has_zenoh(arm)
    assert _angle_by(unix_endpoint(places.service_key_socket("arm"))) == "0.5"
    assert shell.ok("rtget arm.angle") == "0.5\n"
    near.terminate()
    near.communicate(timeout=BOUND_S)


def test_several_who_connect_at_once_are_all_served(arm: Any) -> None:
    with ThreadPoolExecutor(4) as pool:
        sessions = list(pool.map(lambda _: open_to_service("arm", BOUND_S), range(4)))
    for session in sessions:
        session.close()  # type: ignore[no-untyped-call]
    assert _has_zenoh(arm)


def test_a_manager_that_starts_finds_the_service(shell: Any, arm: Any) -> None:
    assert not _has_zenoh(arm)
    shell.ok("rtmgr start --no-door")
    try:
        manager = unix_endpoint(places.manager_socket("manager"))
        until(lambda: _angle_by(manager) == "0.5", "the manager finds the service")
        assert _has_zenoh(arm)
    finally:
        shell.ok("rtmgr stop")


def test_where_a_manager_runs_it_is_there_from_the_beginning(shell: Any) -> None:
    shell.ok("rtmgr start --no-door")
    (shell.folder / "arm.py").write_text(ARM, encoding="utf-8")
    process = shell.open("rtserve arm:Arm arm")
    assert process.stdout.readline() == "/localhost/arm\n"
    manager = unix_endpoint(places.manager_socket("manager"))
    until(lambda: _angle_by(manager) == "0.5", "the manager finds the service")
    assert _has_zenoh(process)
    process.terminate()
    assert process.communicate(timeout=BOUND_S) == ("", "")
    shell.ok("rtmgr stop")


def test_beside_a_manager_it_can_be_left_out(shell: Any) -> None:
    shell.ok("rtmgr start --no-door")
    (shell.folder / "arm.py").write_text(ARM, encoding="utf-8")
    process = shell.open("rtserve arm:Arm arm --no-zenoh")
    assert process.stdout.readline() == "/localhost/arm\n"
    assert shell.ok("rtget arm.angle") == "0.5\n"
    assert not _has_zenoh(process)
    assert not os.path.exists(places.service_key_socket("arm"))
    process.terminate()
    assert process.communicate(timeout=BOUND_S) == ("", "")
    shell.ok("rtmgr stop")
    outcome = shell.run("rtserve arm:Arm arm --no-zenoh --host robot1")
    assert (outcome.status, outcome.out) == (2, "")
    assert "--host asks over zenoh: it does not go with --no-zenoh" in outcome.err


@pytest.mark.parametrize("name", ["group:Group", "resource:Resource", "storage:Storage ."])
def test_standard_services_need_none(shell: Any, name: str) -> None:
    thing, _, argument = name.partition(" ")
    line = f"rtserve rtkit.services.{thing} it" + f" -a {argument}" * bool(argument)
    process = shell.open(line)
    assert process.stdout.readline() == "/localhost/it\n", process.stderr.read()
    assert not _has_zenoh(process)
    process.terminate()
    process.communicate(timeout=BOUND_S)
