"""Proxies with the real command: what passes, what is said, how they end."""

from __future__ import annotations

import os
import shlex
import signal
from typing import Any

import pytest
from make_commands import examples
from mosquittokit import MOSQUITTO, PASSWORD, Mosquitto, Stranger

ARM = """
class Arm:
    def __init__(self):
        self.angle = 0.5
        self.name = "right"
"""


def arm(shell: Any) -> Any:
    (shell.folder / "arm.py").write_text(ARM, encoding="utf-8")
    process = shell.open("rtserve arm:Arm robots/arm --port 0")
    process.address = process.stdout.readline().split()[1]
    return process


def end(process: Any) -> str:
    """End a proxy as a service manager does; return what it said on stderr."""
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=30)
    assert (out, process.returncode) == ("", 0)
    return str(err)


def test_a_proxy_passes_what_it_may_and_says_when_the_owner_goes(shell: Any) -> None:
    owner = arm(shell)
    near = shell.open("rtproxy robots/arm tcp:0 --allow-set 'ang*'")
    address = near.stdout.readline().strip()
    assert address.startswith("tcp:localhost:")
    far = shell.open(f"rtproxy {address} far/arm --prefix left --allow-set '*'")
    assert far.stdout.readline() == "/localhost/far/arm\n"
    assert shell.ok(f"rtget --at {address[4:]} robots/arm.angle") == "0.5\n"
    assert shell.ok("rtget far/arm far/arm.left") == "(left)\n(angle name)\n"
    listening = shell.open("rtlisten --queue 9 far/arm.left.angle")
    assert listening.stdout.readline() == "0.5\n"
    assert shell.ok("rtset --echo far/arm left.angle 2") == "2\n"
    assert listening.stdout.readline() == "2\n"
    outcome = shell.run("rtset far/arm.left.name x")
    denied = "denied: SET of name: the proxy lets nobody set it"
    assert (outcome.status, outcome.err) == (1, f"rtset: far/arm.left.name: {denied}\n")
    owner.kill()
    owner.communicate()
    assert near.stderr.readline() == f"denied: SET name by 'rtkit-{os.getuid()}'\n"
    gone = "rtproxy: robots/arm: gone: the connection has ended\n"
    assert near.stderr.readline() == gone
    assert listening.stdout.readline() == "2  (stale)\n"
    assert shell.run("rtget far/arm.left.angle").err.startswith(
        "rtget: far/arm.left.angle: no-service: "
    )
    owner = arm(shell)
    assert near.stderr.readline() == "rtproxy: robots/arm: back\n"
    assert listening.stdout.readline() == "0.5\n"
    assert end(far) == ""
    near.send_signal(signal.SIGINT)
    near.communicate(timeout=30)
    assert near.returncode == -signal.SIGINT
    assert listening.communicate(timeout=30)[1] == (
        "rtlisten: far/arm.left.angle: no-service: the connection has ended\n"
    )
    end(owner)


def test_an_address_is_taken_as_it_was_printed(shell: Any) -> None:
    owner = arm(shell)
    for number, printed in enumerate((owner.address, f"{owner.address}/robots/arm")):
        far = shell.open(f"rtproxy {printed} far{number}")
        assert far.stdout.readline() == f"/localhost/far{number}\n"
        assert shell.ok(f"rtget far{number}.angle") == "0.5\n"
        end(far)
    end(owner)


@pytest.mark.skipif(MOSQUITTO is None, reason="there is no mosquitto")
def test_every_example_runs(manager: Any) -> None:
    broker = Mosquitto(manager.folder)
    manager.environment["RTKIT_MQTT_PASSWORD"] = PASSWORD
    stranger = Stranger(broker.port, "lab/#")
    manager.ok("rtmgr /localhost/manager.mgr -c 'ConsoleIn?instance_name=Motor0'")
    processes = [arm(manager)]
    addresses: dict[str, str] = {}
    replaced = {
        "tcp:4711": "tcp:0",
        "tcp:4712": "tcp:0",
        "@localhost/": f"@localhost:{broker.port}/",
    }
    for line, _ in examples()["rtproxy"]:
        wanted = line.replace("tcp:localhost:4711", addresses.get("tcp:4711", ""))
        for old, new in replaced.items():
            wanted = wanted.replace(old, new)
        process = manager.open(wanted)
        processes.append(process)
        address = process.stdout.readline().strip()
        assert address, line + process.stderr.read()
        addresses[shlex.split(line)[2]] = address
    assert manager.ok("rtget far/arm.left.angle") == "0.5\n"
    stranger.awaits(lambda: stranger.known.get("lab/robots/arm/angle") == b"0.5")
    motor = addresses["tcp:4712"].removeprefix("tcp:")
    assert manager.ok(f"rtget --at {motor} Motor0.state Motor0.type") == 'Inactive\n"ConsoleIn"\n'
    listening = manager.open(f"rtlisten --at {motor} -n 2 Motor0.state")
    assert listening.stdout.readline() == "Inactive\n"
    manager.ok(f"rtset --at {motor} Motor0.state Active")
    assert listening.stdout.readline() == "Active\n"
    assert listening.communicate(timeout=30)[1] == ""
    stranger.awaits(lambda: stranger.known.get("lab/robots/arm/$state") == b"ready")
    at_broker = processes.pop()
    at_broker.kill()
    at_broker.communicate()
    stranger.awaits(lambda: stranger.known["lab/robots/arm/$state"] == b"lost")
    for process in reversed(processes):
        end(process)
    stranger.close()
    broker.stop()
