"""Way to a host, as OpenSSH's files say it: address, port, user, keys, and hosts in between."""

from __future__ import annotations

import getpass
import os
import shlex
from typing import NamedTuple

from rtkit.errors import Malformed
from rtkit.hosts.host import Host, host_at

SYSTEM_FILE = "/etc/ssh/ssh_config"
_MOST_JUMPS = 8
_KNOWN_HOSTS = "~/.ssh/known_hosts ~/.ssh/known_hosts2"
_OF_ALL = "/etc/ssh/ssh_known_hosts /etc/ssh/ssh_known_hosts2"


class SshRoute(NamedTuple):
    """Way to an sshd, and how to be let in.

    Attributes:
        known_hosts: Files with the keys of hosts, the user's first.
        identities: Files of the user's keys; none for the usual ones.
        certificates: Files of certificates of these keys.
        agent: The socket of the user's agent; empty for none.
        uses_all_keys: Other keys of the agent than those of `identities` are tried, too.
        alias: The name in ``known_hosts`` if it is another one.
        hashes_names: Names are hashed in ``known_hosts``.
        through: The way to the host over which it goes.
        unused: What is set for it in OpenSSH's files and does not count.
    """

    address: str
    port: int
    user: str
    known_hosts: tuple[str, ...]
    identities: tuple[str, ...] = ()
    certificates: tuple[str, ...] = ()
    agent: str = ""
    uses_all_keys: bool = True
    alias: str = ""
    hashes_names: bool = False
    through: SshRoute | None = None
    unused: tuple[str, ...] = ()

    @property
    def place(self) -> str:
        """The name of the place in ``known_hosts``."""
        address = self.address.lower()
        return self.alias or (address if self.port == 22 else f"[{address}]:{self.port}")


def way_to(host: Host, jumps: str = "", _depth: int = 0) -> SshRoute:
    """Return the way to a host, over `jumps` if they are given.

    Raises:
        Malformed: A file cannot be read, or hosts in between go in a circle.
        Refused: A stranger can have written a file; or the host is reached over TLS.
    """
    from rtkit.hosts.ssh_files import expanded_path

    host.check_shell()
    if _depth > _MOST_JUMPS:
        raise Malformed(f"{host.name}: more than {_MOST_JUMPS} hosts in between (ProxyJump)")
    found, unused = _settings(host)

    def word(key: str, usual: str) -> str:
        return str(found.get(key, usual))

    def paths(key: str, usual: str = "") -> tuple[str, ...]:
        value = found.get(key, usual)
        texts = value if isinstance(value, list) else shlex.split(value)
        return tuple(expanded_path(each) for each in texts if each.lower() != "none")

    port = word("port", "22")
    if not (port.isdecimal() and 0 < int(port) < 65536):
        raise Malformed(f"{host.name}: Port of OpenSSH's files is not a port: {port}")
    *before, last = (jumps or word("proxyjump", "none")).split(",")
    through = None
    if last.strip().lower() != "none":
        jump = host_at(host.name, last.strip().removeprefix("ssh://"))
        through = way_to(jump, ",".join(before), _depth + 1)
        unused = (*through.unused, *unused)
    return SshRoute(
        word("hostname", host.address),
        int(port),
        word("user", getpass.getuser()),
        paths("userknownhostsfile", _KNOWN_HOSTS) + paths("globalknownhostsfile", _OF_ALL),
        paths("identityfile"),
        paths("certificatefile"),
        _agent(word("identityagent", "SSH_AUTH_SOCK")),
        word("identitiesonly", "no").lower() != "yes",
        word("hostkeyalias", "").lower(),
        word("hashknownhosts", "no").lower() == "yes",
        through,
        unused,
    )


def remarks(hosts: list[Host]) -> list[str]:
    """Return what is set for hosts in OpenSSH's files and does not count, each once.

    Raises:
        Malformed: A file cannot be read.
    """
    over_ssh = [host for host in hosts if not host.is_tls]
    unused = dict.fromkeys(each for host in over_ssh for each in way_to(host).unused)
    return [f"of OpenSSH's files this does not count: {each}" for each in unused]


def _settings(host: Host) -> tuple[dict[str, str | list[str]], tuple[str, ...]]:
    """Return the values of OpenSSH's files; what the inventory says counts before them."""
    from rtkit.hosts.ssh_files import ExpandedConfig

    user = [f"User {host.user}"] if host.user else []
    port = [f"Port {host.port}"] if host.port else []
    config = ExpandedConfig(host.address, *user, *port)
    own = os.path.expanduser("~/.ssh")
    if only := os.environ.get("RTKIT_SSH_CONFIG"):  # as ssh -F: without the machine's own
        config.add(only, own)
    else:
        config.add(os.path.join(own, "config"), own)
        config.add(SYSTEM_FILE, os.path.dirname(SYSTEM_FILE))
    return config.lookup()


def _agent(text: str) -> str:
    from rtkit.hosts.ssh_files import expanded_path

    if text.lower() == "none":
        return ""
    if text == "SSH_AUTH_SOCK" or (text.startswith("$") and "{" not in text):
        return os.environ.get(text.removeprefix("$"), "")
    return expanded_path(text)
