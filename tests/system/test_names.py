"""Names, searches and ends on real processes; the working directory in a real shell."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
from pathlib import Path
from typing import Any

import pytest

from rtkit.cli.completion.functions import script as functions

KEEPS_MANAGER = True
MANAGER = "/localhost/manager.mgr"
SECOND = "/localhost/manager.mgr/s1.mgr"


def test_a_name_goes_and_its_component_stays(manager: Any) -> None:
    manager.ok(f"rtmgr -c ConsoleOut {MANAGER}")
    manager.ok("rtact /localhost/ConsoleOut0.rtc")
    manager.ok("rtdel /localhost/ConsoleOut0.rtc")
    assert manager.ok("rtfind / -n ConsoleOut0.rtc") == f"{MANAGER}/ConsoleOut0.rtc\n"
    assert manager.ok(f"rtls -l {MANAGER}/ConsoleOut0.rtc").startswith("Active ")
    gone = "rtdel: No such object: /localhost/ConsoleOut0.rtc\n"
    assert manager.run("rtdel /localhost/ConsoleOut0.rtc") == (1, "", gone)


def test_a_manager_s_name_goes_and_it_still_serves(manager: Any) -> None:
    manager.ok(f"rtmgr -c ConsoleOut {MANAGER}")
    manager.ok(f"rtdel {MANAGER}")
    assert manager.ok("rtls /localhost") == "ConsoleOut0.rtc\n"
    manager.ok("rtact /localhost/ConsoleOut0.rtc")


def test_zombies_are_removed_one_by_one_and_all(manager: Any) -> None:
    line = " ".join(f"-c ConsoleOut?manager_name=s{number}" for number in range(3))
    manager.ok(f"rtmgr -c ConsoleIn {line} {MANAGER}")
    told = "rtdel: Not a zombie object: /localhost/ConsoleOut0.rtc\n"
    assert manager.run("rtdel -z /localhost/ConsoleOut0.rtc") == (1, "", told)
    for number in range(3):
        pid = manager.ok(f"rtcat {MANAGER}/s{number}.mgr").splitlines()[2].split(": ")[1]
        os.kill(int(pid), signal.SIGKILL)
    zombies = [f"/localhost/ConsoleOut{number}.rtc" for number in range(3)]
    while manager.ok("rtfind /localhost -m 1 -t z").split() != zombies:
        pass
    manager.ok(f"rtdel -z {zombies[1]}")
    assert manager.ok("rtfind /localhost -m 1 -t z").split() == zombies[::2]
    manager.ok("rtdel -z")
    assert manager.ok("rtfind /") == (
        f"/\n/localhost\n/localhost/ConsoleIn0.rtc\n{MANAGER}\n{MANAGER}/ConsoleIn0.rtc\n"
    )


@pytest.mark.parametrize("place", [MANAGER, SECOND])
def test_nothing_remains_of_a_component_that_was_ended(manager: Any, place: str) -> None:
    manager.ok(f"rtmgr -c SeqOut -c SeqIn?manager_name=s1 {MANAGER}")
    manager.ok("rtcon /localhost/SeqOut0.rtc:Long /localhost/SeqIn0.rtc:Long")
    manager.ok("rtact /localhost/SeqOut0.rtc /localhost/SeqIn0.rtc")
    name, other = ("SeqIn0", "SeqOut0") if place == SECOND else ("SeqOut0", "SeqIn0")
    manager.ok(f"rtexit {place}/{name}.rtc")
    assert manager.ok(f"rtfind / -n {name}.rtc") == ""
    line = manager.ok(f"rtls -l /localhost/{other}.rtc").split()
    assert line[:2] == ["Active", "16/0"]


@pytest.fixture
def scripts(manager: Any, tmp_path: Path) -> Any:
    """A manager, and its commands as programs on the path."""
    for name in ("rtcwd", "rtpwd", "rtls"):
        program, *arguments = manager.command(name)
        line = " ".join(map(shlex.quote, [program, *arguments]))
        script = tmp_path / name
        script.write_text(f'#!/bin/sh\nexec {line} "$@"\n')
        script.chmod(0o755)
    path = os.pathsep.join([str(tmp_path), manager.environment.get("PATH", "")])
    manager.environment["PATH"] = path
    return manager


def test_a_shell_changes_its_working_directory_in_the_tree(scripts: Any) -> None:
    scripts.ok(f"rtmgr -c ConsoleOut {MANAGER}")
    script = f"""{functions("bash")}
rtpwd
rtcwd localhost/manager.mgr/ && rtls
rtcwd ../no || echo "status $?"
rtcwd -h | head -n 1
rtcwd ..; rtpwd
rtcwd; rtpwd
"""
    environment = {k: v for k, v in scripts.environment.items() if k != "RTCSH_CWD"}
    done = subprocess.run(
        ["bash", "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines() == [
        "/",
        "ConsoleOut0.rtc",
        "status 1",
        "Usage: rtcwd [OPTIONS] [PATH]",
        "/localhost",
        "/",
    ]
    assert done.stderr == "rtcwd: Not a directory: ../no\n"


def test_other_managers_are_searched_and_freed_of_zombies_too(manager: Any) -> None:
    manager.ok("rtmgr start two")
    two = "/localhost/two.mgr"
    for place in (MANAGER, two):
        manager.ok(f"rtmgr -c ConsoleOut?manager_name=s1 {place}")
        pid = manager.ok(f"rtcat {place}/s1.mgr").splitlines()[2].split(": ")[1]
        os.kill(int(pid), signal.SIGKILL)
        while not manager.ok(f"rtfind {place} -m 1 -t z"):
            pass
    assert manager.ok("rtfind / -t z").split() == [
        "/localhost/ConsoleOut0.rtc",
        f"{MANAGER}/ConsoleOut0.rtc",
        f"{MANAGER}/s1.mgr/ConsoleOut0.rtc",
        f"{two}/ConsoleOut0.rtc",
        f"{two}/s1.mgr/ConsoleOut0.rtc",
    ]
    manager.ok("rtdel -z")
    assert manager.ok("rtfind / -t z") == ""
    assert manager.ok("rtfind /localhost").split() == ["/localhost", MANAGER, two]


def test_what_could_not_be_searched_is_told(manager: Any) -> None:
    manager.ok("rtmgr start two")
    pid = manager.ok("rtcat /localhost/two.mgr").splitlines()[2].split(": ")[1]
    os.kill(int(pid), signal.SIGSTOP)
    try:
        status, out, err = manager.run("rtfind --timeout 0.5 --exit-detail /localhost")
        assert (status, out.split()) == (5, ["/localhost", MANAGER, "/localhost/two.mgr"])
        assert err.startswith("rtfind: /localhost/two.mgr was not searched: ")
        status, out, err = manager.run("rtdel --timeout 0.5 --exit-detail -z")
        assert (status, out) == (5, "")
        assert err.startswith("rtdel: manager 'two' does not answer")
    finally:
        os.kill(int(pid), signal.SIGCONT)
