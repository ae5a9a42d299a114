"""Robot on another host for tests: its manager is reached over mutual TLS.

The other host is one by its name, folders and keys; its manager listens at 127.0.0.2.
"""

from __future__ import annotations

import contextlib
import json
import socket
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from clockkit import WallClock
from forked import Commands
from shells import Outcome, Shell, opened_shell

from rtkit.keys import authority
from rtkit.keys.authority import issue
from rtkit.link.processes import stat_of
from rtkit.wires.line.client import LineClient
from rtkit.wires.secure import connected

AT = "127.0.0.2"
BOUND_S = 20.0
NONE: Mapping[str, str] = {}


class Robot:
    """The other host: commands there, and at its port as somebody."""

    def __init__(self, shell: Shell) -> None:
        """Make its folders and keys; `more` variables are for what is started there."""
        self.shell = shell
        self.keys = str(shell.folder / "keys")
        self.port = 0
        self.more: dict[str, str] = {}
        self.clock: WallClock
        for name in ("robot.run", "robot.state"):
            (shell.folder / name).mkdir(mode=0o700)
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("RTKIT_KEYS", self.keys)
            authority.init("owner1", ["localhost"])
            issue("robot1", "component", [AT], 30, f"{self.keys}.robot1")
            for name, role in (("anna", "viewer"), ("bert", "operator"), ("carl", "component")):
                issue(name, role, [], 30, f"{self.keys}.{name}")

    @property
    def path(self) -> str:
        return f"/{AT}:{self.port}"

    @contextlib.contextmanager
    def _with(self, **more: str) -> Iterator[None]:
        before = dict(self.shell.environment)
        self.shell.environment.update(more)
        yield
        self.shell.environment = before

    def usual(self) -> contextlib.AbstractContextManager[None]:
        """Have commands without a path mean the manager of the robot."""
        return self._with(RTKIT_MANAGER=self.path[1:])

    def keys_of(self, who: str) -> contextlib.AbstractContextManager[None]:
        """Have commands of this host show the certificate of somebody."""
        return self._with(RTKIT_KEYS=self.keys + (f".{who}" if who != "owner1" else ""))

    def there(self, line: str) -> Outcome:
        """Run a command on the robot."""
        with self.at_home():
            return self.shell.run(line)

    def at_home(self) -> contextlib.AbstractContextManager[None]:
        """Have commands of the shell run on the robot."""
        folder = self.shell.folder
        return self._with(
            RTKIT_HOSTNAME="robot1", RTKIT_KEYS=f"{self.keys}.robot1",
            RTKIT_RUNTIME_DIR=f"{folder}/robot.run", RTKIT_STATE_DIR=f"{folder}/robot.state",
            **self.more,
        )  # fmt: skip

    def port_of(self, manager: str) -> int:
        told = json.loads(self.there(f"rtmgr status --json {manager}").out)["tls"]
        return int(told.rpartition(":")[2])

    def by(self, who: str, line: str) -> Outcome:
        """Run a command on this host, with the keys of somebody; AT stands for the robot."""
        with self.keys_of(who):
            return self.shell.run(line.replace("AT", self.path))

    @contextlib.contextmanager
    def connected(self, who: str, port: int = 0) -> Iterator[LineClient]:
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("RTKIT_KEYS", self.keys + (f".{who}" if who != "owner1" else ""))
            end = connected(AT, port or self.port, BOUND_S)
            client = LineClient(end, BOUND_S)  # type: ignore[arg-type]
        with client:
            yield client

    def raw(self) -> socket.socket:
        end = socket.create_connection((AT, self.port), BOUND_S)
        end.settimeout(BOUND_S)
        return end

    def pid(self) -> int:
        return int(json.loads(self.there("rtmgr status --json manager").out)["pid"])

    def gateway(self) -> int:
        """Return the process of its port."""
        manager = self.pid()
        for each in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                words = (each / "cmdline").read_bytes()
                fields = stat_of(int(each.name))
                is_one = b"rtkit.manager.gateway.process" in words
                if is_one and fields and int(fields[1]) == manager:
                    return int(each.name)
        raise AssertionError("no process of the port")

    def is_alive(self) -> bool:
        done = self.by("anna", "rtls AT/manager.mgr/")
        return (done.status, done.err) == (0, "")

    def record(self) -> list[dict[str, str]]:
        text = (self.shell.folder / "robot.state/audit.jsonl").read_text(encoding="utf-8")
        return [json.loads(line) for line in text.splitlines()]


@contextlib.contextmanager
def opened_robot(commands: Commands, modules: Mapping[str, str] = NONE) -> Iterator[Robot]:
    """Start the manager of a robot, with two components, and end it."""
    with opened_shell(commands) as shell:
        for name, text in modules.items():
            (shell.modules / name).write_text(text)
        robot = Robot(shell)
        assert robot.there(f"rtmgr start -a --tls {AT}:0") == (0, "", "")
        robot.port = robot.port_of("manager")
        assert robot.there("rtmgr -c ConsoleIn -c ConsoleOut /localhost/manager.mgr").err == ""
        yield robot
        stopped = robot.there("rtmgr stop")
        assert stopped == (0, "", ""), stopped
