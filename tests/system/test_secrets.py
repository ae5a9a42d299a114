"""Secrets stay where they were put: in no argument, log or file that others read."""

from __future__ import annotations

from pathlib import Path

from forked import Commands
from robotkit import AT, Robot
from shells import opened_shell

SECRET = "hunter2-7c1"


def _arguments_of(mark: bytes) -> dict[int, bytes]:
    """Return the arguments of the processes whose environment or arguments have a mark."""
    found = {}
    for each in Path("/proc").glob("[0-9]*"):
        try:
            arguments, environment = ((each / n).read_bytes() for n in ("cmdline", "environ"))
        except OSError:
            continue
        if mark in arguments + environment:
            found[int(each.name)] = arguments
    return found


def test_no_process_shows_a_secret_of_a_manager(commands: Commands) -> None:
    """`ps` shows everybody the arguments of all processes, for as long as they run."""
    with opened_shell(commands) as shell:
        robot = Robot(shell)
        start = f"rtmgr start -a --tls {AT}:0 -o my.password:{SECRET}"
        assert robot.there(start).status == 0  # it warns of a property that nobody knows
        made = f"rtmgr -c 'ConsoleIn?manager_name=s&password={SECRET}' /localhost/manager.mgr"
        assert robot.there(made).err == ""
        assert robot.there("rtmgr restart").status == 0
        assert SECRET in robot.there("rtmgr -g /localhost/manager.mgr").out
        door = (shell.folder / "robot.run").joinpath("door.secret")
        secrets = [SECRET.encode()]
        secrets += [door.read_bytes().strip()] if door.exists() else []
        secrets += [Path(robot.keys + ".robot1", "own.key").read_bytes().splitlines()[1]]
        shown = _arguments_of(str(shell.folder).encode())
        assert len(shown) >= 3  # manager, zygote, gateway, slave
        for secret in secrets:
            assert [each for each in shown.values() if secret in each] == []
        logs = list((shell.folder / "robot.state").glob("*.log"))
        assert logs
        for file in [*logs, *(shell.folder / "robot.state").glob("*.out")]:
            assert SECRET not in file.read_text()
        assert robot.there("rtmgr stop") == (0, "", "")
