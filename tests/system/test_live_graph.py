"""A picture of what lives: two managers, processes, a composite, a zombie, rates."""

from __future__ import annotations

import os
import re
import signal
from typing import Any

from lxml import etree
from waiting import facts_of, until

from rtkit.tree.client import Tree

KEEPS_MANAGER = True
MANAGER, SECOND = "/localhost/manager.mgr", "/localhost/m2.mgr"


def test_a_picture_of_what_lives(manager: Any, tree: Tree) -> None:
    manager.ok(f"rtmgr -c 'ConsoleOut?manager_name=z' -c Sensor -c Motor -c ConsoleIn {MANAGER}")
    manager.ok("rtcon /localhost/Motor0.rtc:pose /localhost/Sensor0.rtc:pose")
    manager.ok("rtcon /localhost/ConsoleIn0.rtc:out /localhost/ConsoleOut0.rtc:in")
    manager.ok("rtact /localhost/Motor0.rtc")
    manager.ok("rtmgr start m2")
    try:
        manager.ok(f"rtmgr -c ConsoleIn {SECOND}")
        manager.ok(f"rtcomp -a {SECOND}/ConsoleIn0.rtc:out {SECOND}:Robot0")
        lines = manager.ok("rtprofile graph --live --text").splitlines()
        text = "\n".join(re.sub(r"\d+", "N", line) for line in lines)
        assert "[manager]  manager, pid N\n" in text
        assert "  [z]  slave · pid N\n    ConsoleOutN  ConsoleOut · Inactive" in text
        assert "\n  RobotN  PeriodicECSharedComposite · Inactive\n    ConsoleInN  ConsoleIn" in text
        assert re.search(r"^  Motor0  Motor · Active · [1-9][\d.]* Hz$", "\n".join(lines), re.M)
        assert re.search(r"pose --> Sensor0:pose  [1-9][\d.]* Hz$", "\n".join(lines), re.M)
        process = next(p for p in tree.snapshot().processes if p.name == "z")
        os.kill(process.pid, signal.SIGKILL)
        until(lambda: bool(facts_of(tree, "ConsoleOut0").zombie), "its end")
        text = manager.ok("rtprofile graph --live --text --no-rates")
        assert f"[z]  slave · pid {process.pid} · lost: signal 9" in text
        assert "ConsoleOut0  ConsoleOut · zombie" in text
        picture = etree.fromstring(manager.ok("rtprofile graph --live --no-rates").encode())
        fills = [each.get("style") for each in picture.iter("{*}path") if each.get("style")]
        assert {"fill:lightgrey", "fill:palegreen", "fill:lightblue"} <= set(fills)
        assert "fillcolor=lightgrey" in manager.ok("rtstodot --live")
    finally:
        manager.ok("rtmgr stop m2")
