"""A time-out travels with its request: what was not begun in time does not happen later."""

from __future__ import annotations

import os
import signal
from typing import Any

import pytest

import rtkit
from rtkit.errors import Unreachable

HELD = '''
from rtkit.component import Component, Parameter


class Held(Component):
    """Waits in its first cycle until somebody opens the gate."""

    rate = 100.0
    gain = Parameter(1.0)
    other = Parameter(0)
    is_through = False

    def on_execute(self, context):
        if not self.is_through:
            with open("gate") as gate:
                gate.read()
            self.is_through = True


def HeldInit(manager):
    manager.register_factory(Held)
'''


@pytest.fixture
def held(manager: Any) -> Any:
    (manager.modules / "Held.py").write_text(HELD)
    os.mkfifo(manager.folder / "gate")
    return manager


def test_a_request_behind_a_stuck_callback_is_not_done_once_it_returns(held: Any) -> None:
    held.ok("rtmgr /localhost/manager.mgr -c 'Held?instance_name=H&manager_name=s'")
    held.ok("rtact /localhost/H.rtc")
    for line in (
        "rtdeact --timeout 0.3 /localhost/H.rtc",
        "rtconf --timeout 0.3 /localhost/H.rtc set gain 7",
    ):
        status, _, err = held.run(line)
        assert (status, "no answer from s in time: H is stuck in on_execute" in err) == (1, True)
    (held.folder / "gate").write_text("go")
    held.ok("rtconf /localhost/H.rtc set other 3")
    assert held.ok("rtget /localhost/H.rtc.state") == "Active\n"
    assert held.ok("rtconf /localhost/H.rtc get gain") == "1.0\n"


def test_a_request_before_a_stopped_manager_is_not_done_once_it_goes_on(
    manager: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR", "RTKIT_PORT"):
        monkeypatch.setenv(name, manager.environment[name])
    with rtkit.connect() as tree:
        pid = int(tree.get("manager.pid"))
        tree.timeout_s = 0.3
        os.kill(pid, signal.SIGSTOP)
        try:
            with pytest.raises(Unreachable, match="no answer within"):
                tree.create("Sensor?instance_name=Late")
        finally:
            os.kill(pid, signal.SIGCONT)
        tree.timeout_s = 10.0
        tree.create("Sensor?instance_name=InTime")
        assert tree.ls("/localhost") == ["InTime.rtc", "manager.mgr"]


def test_a_value_set_before_a_stopped_service_is_not_set_once_it_goes_on(shell: Any) -> None:
    (shell.folder / "bot.py").write_text("class Bot:\n    speed: float = 1.0\n")
    service = shell.open("rtserve bot:Bot bot")
    service.stdout.readline()
    service.send_signal(signal.SIGSTOP)
    status, _, err = shell.run("rtset --timeout 0.3 bot/speed 7")
    service.send_signal(signal.SIGCONT)
    assert (status, err) == (1, "rtset: bot/speed: timeout: no answer within 0.3 s\n")
    assert shell.ok("rtget bot/speed") == "1.0\n"
    service.terminate()
    service.communicate(timeout=30)
