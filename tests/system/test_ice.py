"""Ice with the real commands: served, asked, listened to, carried on."""

from __future__ import annotations

import os
import signal
from typing import Any

import icekit
import pytest

ARM = """
class Arm:
    def __init__(self):
        self.angle = 0.5
        self.name = "right"
"""


@pytest.mark.skipif(not icekit.IS_THERE, reason=icekit.MISSING)
def test_an_object_is_served_and_asked_over_ice(shell: Any) -> None:
    (shell.folder / "arm.py").write_text(ARM, encoding="utf-8")
    if icekit.FOLDER:
        shell.environment["PYTHONPATH"] = icekit.FOLDER
    owner = shell.open("rtserve arm:Arm robots/arm --ice 0 --rule 'deny ice * SET name'")
    address = owner.stdout.readline().split()[1]
    assert address.startswith("ice://localhost:")
    near = shell.open(f"rtproxy {address} ice:0 --allow-set angle")
    carried = near.stdout.readline().strip()
    listening = shell.open(f"rtlisten --queue 9 {carried}/angle")
    assert listening.stdout.readline() == "0.5\n"
    assert shell.ok(f"rtset --echo {carried}/angle 2") == "2\n"
    assert listening.stdout.readline() == "2\n"
    endpoint = address.removesuffix("/robots/arm")
    assert shell.ok(f"rtget --at {endpoint} robots/arm.angle robots/arm.name") == '2\n"right"\n'
    assert shell.ok(f"rtget {address}") == "(angle name)\n"
    refused = shell.run(f"rtset {address}/name x")
    assert (refused.status, refused.err) == (
        1, f"rtset: {address}/name: denied: SET by rtkit-{os.getuid()}: name\n")  # fmt: skip
    unknown = shell.run(f"rtget {endpoint}/nobody/angle")
    assert unknown.err == f"rtget: {endpoint}/nobody/angle: no-service: there is robots/arm\n"
    owner.send_signal(signal.SIGTERM)
    assert owner.communicate(timeout=30)[0] == ""
    assert owner.returncode == 0
    assert near.stderr.readline() == f"rtproxy: {address}: gone: the connection has ended\n"
    assert listening.stdout.readline() == "2  (stale)\n"
    gone = shell.run(f"rtget {address}/angle")
    assert gone.err.endswith(f"no-service: cannot reach {endpoint}: Connection refused\n")
    near.send_signal(signal.SIGINT)
    near.communicate(timeout=30)
    assert near.returncode == -signal.SIGINT
    ended = "no-service: the connection has ended\n"
    assert listening.communicate(timeout=30)[1] == f"rtlisten: {carried}/angle: {ended}"


def test_without_ice_one_line_tells_the_cure(shell: Any) -> None:
    (shell.folder / "Ice.py").write_text("raise ImportError", encoding="utf-8")
    shell.environment["PYTHONPATH"] = str(shell.folder)
    told = (
        "Ice needs the package zeroc-ice: pip install 'rtkit[ice]', or python3-zeroc-ice of Debian"
    )
    for line in ("rtserve builtins:object arm --ice 0", "rtproxy ice://localhost:1/arm tcp:0"):
        outcome = shell.run(line)
        assert outcome.status == 1
        assert outcome.err.endswith(f": {told}\n")
        assert outcome.err.count("\n") == 1
