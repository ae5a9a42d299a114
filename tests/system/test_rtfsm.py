"""``rtfsm`` on real processes."""

from __future__ import annotations

from typing import Any

import pytest

KEEPS_MANAGER = True
MANAGER = "/localhost/manager.mgr"
OVEN = "/localhost/Microwave0.rtc"


@pytest.mark.parametrize("place", ["", "?manager_name=kitchen"])
def test_a_machine_is_looked_at_and_changed(manager: Any, place: str) -> None:
    manager.ok(f"rtmgr -c Microwave{place} {MANAGER}")
    assert manager.ok(f"rtfsm {OVEN} getstate") == "\n"
    manager.ok(f"rtact {OVEN}")
    assert manager.ok(f"rtfsm {OVEN} getstate") == "Operational.Idle\n"
    events = ["open", "close", "minute", "start", "stop", "tick"]
    told = ", ".join(f"{event}:TimedLong" for event in events)
    assert manager.ok(f"rtfsm {OVEN} geteventprofiles") == f"{told}\n"

    text = manager.ok(f"rtfsm {OVEN} getstructure")
    assert text.startswith("<scxml")
    (manager.folder / "oven.scxml").write_text(text.replace("Idle", "Waiting"))
    manager.ok(f"rtfsm {OVEN} setstructure oven.scxml")
    assert manager.ok(f"rtfsm {OVEN} getstate") == "Operational.Waiting\n"
    assert manager.ok(f"rtfsm {OVEN} getstructure") == text.replace("Idle", "Waiting")

    manager.ok(f"rtfsm {OVEN} seteventprofiles toggle:TimedShort,toggle2:TimedString")
    assert (
        manager.ok(f"rtfsm {OVEN} geteventprofiles") == "toggle:TimedShort, toggle2:TimedString\n"
    )


def test_what_a_component_refuses(manager: Any) -> None:
    manager.ok(f"rtmgr -c Microwave -c ConsoleOut {MANAGER}")
    none = "rtfsm: No state machine: /localhost/ConsoleOut0.rtc\n"
    assert manager.run("rtfsm /localhost/ConsoleOut0.rtc getstate") == (1, "", none)
    status, out, err = manager.run(f"rtfsm {OVEN} seteventprofiles a:NoSuchType")
    assert (status, out) == (1, "")
    assert "NoSuchType" in err
    assert err.count("\n") == 1
