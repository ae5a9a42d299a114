"""A component moves between slaves and managers; command and managers are killed on the way."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path
from typing import Any

import jsonrecords
import pytest
from counting import CHECKER, COUNTER, RELAY
from waiting import until

ROOT = Path(__file__).parents[2]
MOVE = "rtmove /localhost/Sample.rtc /localhost/m2.mgr/arm.mgr"
WHERE = "/localhost/m2.mgr/Sample.rtc"
PATHS = (WHERE, "/localhost/Sample.rtc")


def pid_of(shell: Any, manager: str) -> int:
    return int(json.loads(shell.ok(f"rtmgr status --json {manager}"))["pid"])


def set_up(shell: Any) -> None:
    """Have an Active component with a connection and a value of its own, and a second manager."""
    shell.ok("rtmgr start m2")
    shell.ok("rtmgr -c ConfigSample?instance_name=Other /localhost/manager.mgr")
    shell.ok("rtmgr -c SeqOut?instance_name=Sample&manager_name=s1 /localhost/manager.mgr")
    shell.ok("rtmgr -c SeqIn?instance_name=Sink /localhost/manager.mgr")
    shell.ok("rtcon /localhost/Sample.rtc:Long /localhost/Sink.rtc:Long")
    shell.ok("rtconf /localhost/Sample.rtc set length 3")
    shell.ok("rtact /localhost/Sample.rtc")


def done(shell: Any, line: str) -> None:
    """Have a command do its steps, which it tells."""
    outcome = shell.run(line)
    assert outcome.status == 0, outcome.err


def is_whole(shell: Any, path: str) -> bool:
    """Return whether the component is at a path and nowhere else, as it was set up."""
    listed = shell.ok("rtfind -n Sample.rtc /").splitlines()
    assert [each for each in listed if each in PATHS] == [path]
    assert "Active" in shell.ok(f"rtcat {path}")
    assert "+Connected to  /localhost/" in shell.ok(f"rtcat -l {path}:Long")
    return shell.ok(f"rtconf {path} get length") == "3\n"


def killed_behind(shell: Any, line: str, pid: int | None = None) -> None:
    """Kill the move, or another process, once a step is told to be done."""
    running = shell.open(MOVE)
    told = ""
    while line not in told:
        told = running.stderr.readline()
        assert told
    os.kill(running.pid if pid is None else pid, signal.SIGKILL)
    shell.end_of(running)


def test_a_component_moves_with_all_that_it_has(manager: Any) -> None:
    shell = manager
    set_up(shell)
    planned = shell.ok(f"{MOVE} -n")
    assert "create Sample on m2 in slave arm" in planned
    assert is_whole(shell, "/localhost/Sample.rtc")

    done(shell, MOVE)
    assert is_whole(shell, WHERE)
    assert "/localhost/m2.mgr/arm.mgr/Sample.rtc" in shell.ok("rtfind -n Sample.rtc /")
    plan, *steps = jsonrecords.checked(shell.ok(f"rtmove --json {WHERE} /localhost/manager.mgr"))
    assert {jsonrecords.kind_of(each) for each in steps} == {"step"}
    ended = {each["text"] for each in steps if each["state"] in ("done", "held")}
    assert ended == {each["text"] for each in plan["steps"]}
    assert is_whole(shell, "/localhost/Sample.rtc")
    (nothing,) = jsonrecords.checked(
        shell.ok("rtmove --json /localhost/Sample.rtc /localhost/manager.mgr")
    )
    assert nothing["steps"] == []
    assert shell.run("rtmove -n /localhost/Sample.rtc /localhost/manager.mgr").out.startswith(
        "nothing to do"
    )

    # What cannot be is refused before anything is changed.
    shell.ok("rtmgr -c SeqOut?instance_name=Sample /localhost/m2.mgr")
    taken = "rtmove: Sample cannot be moved: its name is taken at /localhost/m2.mgr\n"
    assert shell.run(MOVE) == (1, "", taken)
    shell.ok("rtexit /localhost/m2.mgr/Sample.rtc")
    unknown = shell.run("rtmove /localhost/Sample.rtc /localhost/m3.mgr")
    assert unknown.status == 1
    assert "manager 'm3' is not running" in unknown.err
    other = shell.run("rtmove /localhost/Sample.rtc /localhost/Sink.rtc")
    assert other.err == "rtmove: Not a manager, and not a slave: /localhost/Sink.rtc\n"
    assert is_whole(shell, "/localhost/Sample.rtc")


@pytest.mark.parametrize("subscription", ["flush", "periodic"])
def test_no_value_on_the_way_is_lost_whose_policy_keeps_it(manager: Any, subscription: str) -> None:
    shell = manager
    shell.ok("rtmgr start m2")
    for kind, text in (("Counter", COUNTER), ("Relay", RELAY), ("Checker", CHECKER)):
        (shell.modules / f"{kind}.py").write_text(text)
        shell.ok(f"rtmgr -c {kind}?manager_name={kind.lower()} /localhost/manager.mgr")
    policy = (
        f"-p dataport.subscription_type={subscription} -p dataport.push_rate=50"
        " -p dataport.publisher.push_policy=all"
        " -p dataport.buffer.write.full_policy=block -p dataport.buffer.length=1000"
    )
    shell.ok(f"rtcon {policy} /localhost/Counter0.rtc:out /localhost/Relay0.rtc:into")
    shell.ok(f"rtcon {policy} /localhost/Relay0.rtc:out /localhost/Checker0.rtc:into")
    for kind in ("Checker", "Relay", "Counter"):
        shell.ok(f"rtact /localhost/{kind}0.rtc")

    def numbers() -> tuple[int, int]:
        file = shell.folder / "count"
        last, gaps = file.read_text().split() if file.exists() else ("0", "0")
        return int(last), int(gaps)

    place = "/localhost/Relay0.rtc"
    for target, there in (
        ("/localhost/manager.mgr/other.mgr", place),
        ("/localhost/m2.mgr", "/localhost/m2.mgr/Relay0.rtc"),
        ("/localhost/manager.mgr", place),
        ("/localhost/manager.mgr/counter.mgr", place),
    ):
        before = numbers()[0]
        until(lambda b=before: numbers()[0] > b + 20, "numbers")
        done(shell, f"rtmove {place} {target}")
        place = there
        before = numbers()[0]
        until(lambda b=before: numbers()[0] > b + 20, "numbers after the move")
    assert numbers()[1] == 0


def test_where_the_module_is_not_found_nothing_ends(manager: Any) -> None:
    shell = manager
    shell.ok("rtmgr start m2")
    file = shell.folder / "mine.py"
    file.write_text((ROOT / "examples/basic/SeqOut.py").read_text())
    shell.ok(f"rtmgr -l {file}:SeqOutInit /localhost/manager.mgr")
    shell.ok("rtmgr -c SeqOut?instance_name=Sample /localhost/manager.mgr")
    file.unlink()
    refused = shell.run(MOVE)
    assert refused.status == 1
    assert refused.err.startswith("rtmove: impossible: Sample")
    assert "mine.py" in refused.err
    assert shell.ok("rtfind -un Sample.rtc /") == "/localhost/Sample.rtc\n"


def test_killed_on_the_way_the_same_command_goes_on(manager: Any) -> None:
    shell = manager
    set_up(shell)
    killed_behind(shell, "delete Sample")
    done(shell, MOVE)
    assert is_whole(shell, WHERE)
    assert shell.run(MOVE).err.startswith("rtmove: No such object: /localhost/Sample.rtc")
    done(shell, f"rtmove {WHERE} /localhost/manager.mgr/s1.mgr")

    killed_behind(shell, "delete Sample", pid_of(shell, "m2"))
    shell.ok("rtmgr start m2")
    done(shell, MOVE)
    assert is_whole(shell, WHERE)
    done(shell, f"rtmove {WHERE} /localhost/manager.mgr/s1.mgr")

    killed_behind(shell, "create Sample", pid_of(shell, "manager"))
    shell.ok("rtmgr start")
    done(shell, MOVE)
    assert is_whole(shell, WHERE)


def test_a_plan_leads_back_what_was_moved_also_from_a_manager_that_ended(manager: Any) -> None:
    shell = manager
    set_up(shell)
    shell.ok("rtcryo -o moved.xml /localhost")
    done(shell, MOVE)
    told = shell.run("rtcheck moved.xml")
    why = f"Component {WHERE} is not where it may be: the profile has it at /localhost/Sample.rtc"
    assert (told.status, why in told.err) == (1, True)
    done(shell, "rtapply moved.xml")
    assert is_whole(shell, "/localhost/Sample.rtc")

    done(shell, MOVE)
    os.kill(pid_of(shell, "m2"), signal.SIGKILL)
    until(lambda: shell.run("rtmgr status m2").status == 1, "the end of m2")
    told = shell.run("rtapply moved.xml")
    why = f"Sample was moved, and may live at {WHERE}: manager m2 does not run, but may go on"
    assert (told.status, why in told.err) == (1, True)
    shell.ok("rtmgr start m2")
    assert shell.ok("rtfind -un Sample.rtc /") == f"{WHERE}\n"

    shell.ok("rtmgr stop m2")  # what it held is not there any more
    done(shell, "rtapply moved.xml")
    assert is_whole(shell, "/localhost/Sample.rtc")
    assert not list(shell.folder.rglob("*.moved"))
