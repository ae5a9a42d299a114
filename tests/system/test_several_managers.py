"""One system in two managers of this host: planned, applied, started, stopped, broken, finished."""

from __future__ import annotations

import json
import os
import re
import signal
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import rts_text

TYPE = "RTC:rtkit:example:{}:1.0"
PAIRS = (("In1", "Out1", ""), ("In2", "Out2", "m1.mgr/"))
STATES = {
    "states": "run, standby",
    "state.standby": "*=Inactive",
    "transitions": "run -halt-> standby; standby -go-> run",
}
"""States of the system, all of it active or all of it at rest."""


def profile(
    path: Path, wires: Sequence[tuple[str, str]] = (("In1", "Out1"), ("In2", "Out2"))
) -> str:
    """Write a source and a sink in each of the managers, the source in a slave."""
    components = [
        rts_text.component(
            name,
            {"create": create},
            type_id=TYPE.format(type_),
            port=port,
            folder=f"localhost/{below}".rstrip("/"),
            rate=10.0,
        )
        for source, sink, below in PAIRS
        for type_, name, port, create in (
            ("ConsoleIn", source, "out", "ConsoleIn?manager_name=source"),
            ("ConsoleOut", sink, "in", "ConsoleOut"),
        )
    ]
    types = [TYPE.format(type_) for type_ in ("ConsoleIn", "ConsoleOut")]
    joined = [rts_text.wire(f"w-{s}-{t}", f"{s}.out", f"{t}.in", types) for s, t in wires]
    path.write_text(rts_text.system("Two", *components, *joined, rts_text.properties(STATES)))
    return str(path)


def states(shell: Any) -> dict[str, str]:
    rows = (line.split() for line in shell.ok("rtls -lR /localhost").splitlines())
    return {row[-1]: row[0] for row in rows if row and row[-1].endswith(".rtc")}


def test_a_system_in_two_managers_is_one_system(manager: Any) -> None:
    shell = manager
    file = profile(shell.folder / "two.xml")

    # Who is missing is named as typed, where nobody starts it; a plan can be shown all the same.
    refused = shell.run(f"rtresurrect --no-create {file}")
    missing = (
        "manager 'm1' is not running (start it with: rtmgr start m1; running: manager);"
        " it is to hold /localhost/m1.mgr/In2.rtc and 1 more"
    )
    assert refused == (1, "", f"rtresurrect: {missing}\n")
    shown = shell.run(f"rtplan {file}")
    assert (shown.status, shown.err) == (0, f"rtplan: {missing}; taken as if nothing lived there\n")
    assert "start manager m1" in shown.out
    assert "create In2 on m1 in slave source" in shown.out
    assert shell.ok("rtls -1 /localhost") == "manager.mgr/\n"

    shell.ok("rtmgr start m1")

    plan = json.loads(shell.ok(f"rtplan --json {file}"))
    assert {step["text"]: step["layer"] for step in plan["steps"]} == {
        **{f"create In{n} on {m} in slave source": 1 for n, m in ((1, "manager"), (2, "m1"))},
        **{f"create Out{n} on {m}": 1 for n, m in ((1, "manager"), (2, "m1"))},
        **{f"connect In{n}.out to Out{n}.in (w-In{n}-Out{n})": 2 for n in (1, 2)},
        **{f"set rate of {kind}{n}=10": 2 for kind in ("In", "Out") for n in (1, 2)},
        **{f"activate {name}{n}": 3 for n in (1, 2) for name in ("In", "Out")},
    }
    assert shell.run(f"rtapply {file}").status == 0
    assert shell.run(f"rtcheck {file}") == (0, "", "")
    assert shell.ok(f"rtplan {file}").startswith("nothing to do")
    assert states(shell) == dict.fromkeys(("In1.rtc", "Out1.rtc", "In2.rtc", "Out2.rtc"), "Active")

    # What is saved of both is the same system.
    shell.ok("rtcryo -o saved.xml /localhost /localhost/m1.mgr")
    assert shell.run("rtcheck saved.xml") == (0, "", "")
    assert shell.ok("rtplan saved.xml").endswith("kept: 2 managers, 4 components, 2 connections\n")

    # The commands of one purpose each; which state that is both managers tell.
    watching = shell.open(f"rtwatch -v -n 1 -f SYSTEM_STATE --system {file} /localhost")
    assert "listening\n" in iter(watching.stderr.readline, "")
    assert shell.run(f"rtstop {file}").status == 0
    assert shell.end_of(watching).out.endswith(" RTSystem:Me:Two:1.0 state standby (was run)\n")
    assert shell.run(f"rtstate --event go {file}").status == 0
    assert set(states(shell).values()) == {"Active"}
    assert shell.run(f"rtstop {file}").status == 0
    assert set(states(shell).values()) == {"Inactive"}
    shell.ok(f"rtteardown --exit {file}")
    assert states(shell) == {}
    shell.ok(f"rtresurrect {file}")
    started = shell.run(f"rtstart {file}")
    assert started.status == 0
    assert "Activate /localhost/m1.mgr/Out2.rtc" in started.err
    assert shell.run(f"rtcheck {file}") == (0, "", "")


def test_a_manager_killed_on_the_way_stops_it_and_run_again_it_finishes(manager: Any) -> None:
    shell = manager
    shell.ok("rtmgr start m1")
    file = profile(shell.folder / "two.xml")
    pid = int(json.loads(shell.ok("rtmgr status --json m1"))["pid"])
    running = shell.open(f"rtapply --parallel 1 {file}")
    told = ""
    while "create In2" not in told:
        told = running.stderr.readline()
        assert told
    os.kill(pid, signal.SIGKILL)
    broken = shell.end_of(running)
    assert broken.status == 1
    assert "start manager m1" in broken.err
    assert re.search(r"rtapply: .*; \d+ steps left; run it again to go on\n$", broken.err)

    # What can be stopped is stopped; what is needed is said.
    stopped = shell.run(f"rtstop {file}")
    assert stopped.status == 0
    assert "manager 'm1' is not running" in stopped.err
    assert "Deactivate /localhost/Out1.rtc" in stopped.err

    # Who is needed is started.
    again = shell.run(f"rtapply {file}")
    assert again.status == 0
    assert re.match(r"\[1/\d\] start manager m1\n", again.err)
    assert shell.run(f"rtcheck {file}") == (0, "", "")


def test_a_system_may_be_connected_across_its_managers(manager: Any) -> None:
    shell = manager
    crossed = profile(shell.folder / "crossed.xml", [("In1", "Out2"), ("In2", "Out1")])
    assert "connect In1.out to Out2.in" in shell.run(f"rtplan {crossed}").out
    assert shell.run(f"rtapply {crossed}").status == 0
    assert shell.run(f"rtcheck {crossed}") == (0, "", "")
    assert shell.ok(f"rtplan {crossed}").startswith("nothing to do")
    shell.ok("rtcryo -o saved.xml /localhost /localhost/m1.mgr")
    assert shell.run("rtcheck saved.xml") == (0, "", "")

    # Half a connection is reported as missing, and made whole again.
    pid = json.loads(shell.ok("rtmgr status --json m1"))["pid"]
    os.kill(pid, signal.SIGKILL)
    shell.ok("rtmgr start m1")
    assert shell.run(f"rtapply {crossed}").status == 0
    shell.ok("rtdis /localhost/m1.mgr/Out2.rtc")
    assert "No connection between /localhost/In1.rtc:out" in shell.run(f"rtcheck {crossed}").err
    assert "connect In1.out to Out2.in" in shell.ok(f"rtplan {crossed}")
    assert shell.run(f"rtapply {crossed}").status == 0
    assert shell.run(f"rtcheck {crossed}") == (0, "", "")
    assert shell.run(f"rtteardown --exit {crossed}").status == 0
    assert states(shell) == {}
