"""Way to a host, as OpenSSH's files say it: address, port, user, keys, and hosts in between."""

from __future__ import annotations

import getpass
import os
from typing import NamedTuple

from rtkit.errors import Malformed
from rtkit.hosts.host import Host, host_at

HONOURED = (
    "Host",
    "Match",
    "HostName",
    "Port",
    "User",
    "IdentityFile",
    "IdentitiesOnly",
    "UserKnownHostsFile",
    "GlobalKnownHostsFile",
    "ProxyJump",
)
"""Keywords of ``ssh_config`` that count."""

_MOST_JUMPS = 8
_KNOWN_HOSTS = "~/.ssh/known_hosts"
_OF_ALL = "/etc/ssh/ssh_known_hosts"


class SshRoute(NamedTuple):
    """Way to an sshd, and how to be let in.

    Attributes:
        known_hosts: Files with the keys of hosts, the user's first.
        identities: Files of the user's keys; none for the usual ones.
        uses_agent: Keys of the user's agent are tried.
        through: The way to the host over which it goes.
    """

    address: str
    port: int
    user: str
    known_hosts: tuple[str, ...]
    identities: tuple[str, ...] = ()
    uses_agent: bool = True
    through: SshRoute | None = None

    @property
    def place(self) -> str:
        """The name of the place in ``known_hosts``."""
        return self.address if self.port == 22 else f"[{self.address}]:{self.port}"


def config_file() -> str:
    """Return the user's own file: ``RTKIT_SSH_CONFIG``, else ``~/.ssh/config``."""
    return os.environ.get("RTKIT_SSH_CONFIG") or os.path.expanduser("~/.ssh/config")


def way_to(host: Host, _depth: int = 0) -> SshRoute:
    """Return the way to a host.

    Raises:
        Malformed: A file cannot be read, or hosts in between go in a circle.
    """
    import paramiko

    if _depth > _MOST_JUMPS:
        raise Malformed(f"{host.name}: more than {_MOST_JUMPS} hosts in between (ProxyJump)")
    config = paramiko.SSHConfig()
    path = config_file()
    try:
        if os.path.exists(path):
            with open(path, encoding="utf-8", errors="replace") as file:
                config.parse(file)
        found = config.lookup(host.address)
    except (OSError, paramiko.SSHException, ValueError) as error:
        raise Malformed(f"{path}: {error}") from error
    user = host.user or found.get("user") or getpass.getuser()
    known = found.get("userknownhostsfile", _KNOWN_HOSTS).split()
    known += found.get("globalknownhostsfile", _OF_ALL).split()
    jump = found.get("proxyjump", "none")
    through = None
    if jump.lower() != "none":
        *_, last = (each.strip() for each in jump.split(","))
        through = way_to(host_at(host.name, last), _depth + 1)
    return SshRoute(
        str(found.get("hostname", host.address)),
        host.port or int(found.get("port", 22)),
        user,
        tuple(os.path.expanduser(each) for each in known),
        tuple(os.path.expanduser(each) for each in found.get("identityfile", ())),
        found.get("identitiesonly", "no") != "yes",
        through,
    )
