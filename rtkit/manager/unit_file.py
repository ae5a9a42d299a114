"""Writes the text of the systemd unit that runs a manager as a service; no input or output.

Each line of it must leave the manager and its slaves working, also slaves whose manager was
killed: decision 58 tells which settings cannot be taken for that, and why.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rtkit.errors import Malformed

ROOT = "root"
_MARK = "# Written by rtmgr install: what is changed below differs from checksum "
_SUBGROUP_SINCE = 254
_TMP = "/tmp"


class ManagerService(NamedTuple):
    """A manager as a service.

    Attributes:
        name: Of the manager.
        program: Words of the command ``rtmgr``.
        options: Of its start.
        folder: Working directory, where modules are looked for.
        environment: Variables besides those that systemd sets.
        user: User of a service of the machine; empty for a service of its user.
        systemd: Version of systemd; 0 if it is not known.
    """

    name: str
    program: Sequence[str]
    options: Sequence[str]
    folder: str
    environment: Mapping[str, str]
    user: str = ""
    systemd: int = 0

    @property
    def runtime_folder(self) -> str:
        """Folder of sockets of a service of the machine."""
        return f"/run/{self._folder}"

    @property
    def state_folder(self) -> str:
        """Folder of logs and of the store of a service of the machine."""
        return f"/var/lib/{self._folder}"

    @property
    def _folder(self) -> str:
        return f"rtkit-{re.sub('[^A-Za-z0-9_.-]', '_', self.user)}"

    def text(self) -> str:
        """Return the text of the unit.

        Raises:
            Malformed: A word cannot be written into a unit.
        """
        own = self._of_machine() if self.user else self._of_user()
        target = "multi-user.target" if self.user else "default.target"
        body = _TEMPLATE.format(
            name=_escaped(self.name),
            folder=_escaped(self.folder),
            start=self._command("run", self.name, *self.options),
            reload=self._command("restart", self.name),
            stop=self._command("stop", "--keep", self.name),
            environment="".join(
                f"Environment={_word(f'{key}={value}')}\n"
                for key, value in self.environment.items()
            ),
            subgroup=_SUBGROUP if self.systemd >= _SUBGROUP_SINCE else "",
            own=own,
            target=target,
        )
        return f"{_MARK}{_checksum(body)}\n{body}"

    def _command(self, *words: str) -> str:
        if any(set(word) & set("\"'\\") for word in self.program):
            raise Malformed(f"systemd runs no program with quotes in its path: {self.program[0]}")
        return " ".join([*map(_word, self.program), *(_word(w, is_expanded=True) for w in words)])

    def _of_user(self) -> str:
        is_usual = "RTKIT_RUNTIME_DIR" not in self.environment
        return _OF_USER.format(runtime=_RUNTIME_OF_USER if is_usual else "")

    def _of_machine(self) -> str:
        paths = (self.folder, *self.options, *self.environment.values())
        is_in_tmp = any(path == _TMP or f"{_TMP}/" in path for path in paths)
        return _OF_MACHINE.format(
            user=_escaped(self.user),
            folder=self._folder,
            tmp="" if is_in_tmp else _PRIVATE_TMP.format(folder=self._folder),
            capabilities="" if self.user == ROOT else "CapabilityBoundingSet=\n",
        )


def unit_name(manager: str) -> str:
    r"""Return the name of a manager's unit.

    >>> print(unit_name("manager"), unit_name("left arm"))
    rtkit-manager.service rtkit-left\x20arm.service
    """
    escape = re.sub(
        rb"[^A-Za-z0-9:_.-]", lambda found: b"\\x%02x" % ord(found[0]), manager.encode()
    )
    return f"rtkit-{escape.decode()}.service"


def is_as_written(text: str) -> bool:
    """Return whether nobody has changed a unit since it was written."""
    head, _, body = text.partition("\n")
    return head == _MARK + _checksum(body)


def _checksum(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()[:16]


def _word(text: str, *, is_expanded: bool = False) -> str:
    r"""Return one word as systemd splits lines; a dollar is doubled where it `is_expanded`.

    >>> print(_word("a b"), _word("100%"), _word('"$HOME"', is_expanded=True))
    "a b" 100%% "\"$$HOME\""
    """
    escaped = _escaped(text.replace("\\", "\\\\"))
    if is_expanded:
        escaped = escaped.replace("$", "$$")
    if re.fullmatch(r"[^\s\"';#\\]+", text):
        return escaped
    return '"' + escaped.replace('"', '\\"') + '"'


def _escaped(text: str) -> str:
    if any(ord(letter) < ord(" ") for letter in text):
        raise Malformed(f"cannot be written into a unit: {text!r}")
    return text.replace("%", "%%")


_TEMPLATE = """\
[Unit]
Description=Manager of RT components: {name}
StartLimitIntervalSec=60
StartLimitBurst=5

[Service]
Type=notify
NotifyAccess=main
WorkingDirectory={folder}
{environment}ExecStart={start}
ExecReload={reload}
# Keeps what is to be there at the next start: rtmgr stop forgets it. A manager that ended by
# itself leaves nothing to stop.
ExecStop=-{stop}
Restart=on-failure
RestartSec=500ms
WatchdogSec=30s
# Slaves outlive a manager that was killed; the next one finds them, and its sockets.
KillMode=process
OOMPolicy=continue
{subgroup}{own}NoNewPrivileges=yes
LockPersonality=yes
RestrictNamespaces=yes
RestrictSUIDSGID=yes
RestrictAddressFamilies=AF_UNIX AF_INET AF_INET6 AF_NETLINK AF_CAN AF_BLUETOOTH
SystemCallArchitectures=native
SystemCallFilter=~@clock @cpu-emulation @module @mount @obsolete @raw-io @reboot @swap
SystemCallErrorNumber=EPERM

[Install]
WantedBy={target}
"""

_SUBGROUP = """\
# Limits of slaves are control groups beside that of the manager.
Delegate=yes
DelegateSubgroup=rtkit-manager
"""

_OF_USER = """\
{runtime}# Neither ProtectSystem nor PrivateTmp: for users these need a namespace of users, from
# which a manager cannot see its clients; and a user cannot write the system anyway.
"""

_RUNTIME_OF_USER = """\
RuntimeDirectory=rtkit
RuntimeDirectoryMode=0700
RuntimeDirectoryPreserve=yes
"""

_OF_MACHINE = """\
User={user}
Environment=RTKIT_RUNTIME_DIR=/run/{folder} RTKIT_STATE_DIR=/var/lib/{folder}
RuntimeDirectory={folder}
RuntimeDirectoryMode=0700
RuntimeDirectoryPreserve=yes
StateDirectory={folder}
StateDirectoryMode=0700
{tmp}ProtectSystem=full
ProtectKernelLogs=yes
ProtectKernelModules=yes
ProtectHostname=yes
{capabilities}"""

_PRIVATE_TMP = """\
# PrivateTmp=yes would remove the files of slaves whose manager is restarted; this stays.
RuntimeDirectory={folder}/tmp
BindPaths=/run/{folder}/tmp:/tmp
"""
