"""Links to other hosts as they are seen here: a file each, which the process of the link writes.

The file ``NAME.link`` beside the sockets says which host is linked, and whether it can be reached.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from typing import NamedTuple

from rtkit.errors import Unreachable
from rtkit.link import places

_SUFFIX = ".link"
NOT_YET = "not linked yet"
"""Why a host cannot be reached while its link is being made for the first time."""
SETTLE_S = 0.5
"""How long a router may take to have forgotten what came by a link that has ended [s]. Zenoh
computes its routes 0.1 s after such a change, and tells nobody when that is done."""
COMM = "rtkit-> "
"""How the name of a process of a link begins."""


class HostLink(NamedTuple):
    """State of a link.

    Attributes:
        host: Name of the host in the tree.
        manager: The manager here whose link it is.
        far_manager: The manager there.
        why: Why it cannot be reached; empty while it is linked.
        pid: The process of the link; 0 for none.
        refused_at: When the try began that was refused last [s, monotonic clock]; 0 for none.
    """

    host: str
    manager: str
    far_manager: str
    why: str = ""
    pid: int = 0
    refused_at: float = 0.0


def link_file(host: str) -> str:
    """Return the path of the file of a link."""
    return os.path.join(places.runtime_dir(), f"{host}{_SUFFIX}")


def tunnel_socket(host: str) -> str:
    """Return the path of the socket behind which the router of a host is."""
    return os.path.join(places.runtime_dir(), f"{host}.tunnel")


def is_linked(host: str) -> bool:
    """Return whether there is a link to a host, whether or not it can be reached now."""
    return os.path.exists(link_file(host))


def hosts() -> list[str]:
    """Return the hosts to which there are links, in order."""
    try:
        entries = os.listdir(places.runtime_dir())
    except OSError:
        return []
    return sorted(each.removesuffix(_SUFFIX) for each in entries if each.endswith(_SUFFIX))


def read(host: str) -> HostLink:
    """Return the state of a link; look up what its process can no longer tell.

    Raises:
        Unreachable: There is none.
    """
    try:
        with open(link_file(host), encoding="utf-8") as file:
            fields = json.load(file)
        link = HostLink(**fields)
        return link._replace(why=(link.pid and _why_at_rest(link.pid)) or link.why)
    except FileNotFoundError:
        raise Unreachable(f"no link to host {host} (rthost list names the known ones)") from None
    except (OSError, ValueError, TypeError) as error:
        raise Unreachable(f"the state of the link to {host} cannot be read: {error}") from error


def why_lost(host: str) -> str:
    """Return why a linked host cannot be reached; empty for one that can, and without a link."""
    return read(host).why if is_linked(host) else ""


def is_cured_by_start(why: str) -> bool:
    """Return whether a link is down for want of a manager there: the reason names the start."""
    return "rtmgr start" in why


def router(host: str, manager: str) -> str:
    """Return the manager of this host whose router leads to another host; else the given one."""
    try:
        return read(host).manager
    except Unreachable:
        return manager


def holder(host: str) -> str:
    """Return the running manager of this host that has the link to another host; empty for none."""
    manager = router(host, "")
    return manager if manager and places.owner(manager) is not None else ""


def write(link: HostLink) -> None:
    """Write the state of a link.

    Raises:
        NotFound: It cannot be written.
    """
    from rtkit.link.atomic import write_output

    write_output(json.dumps(link._asdict()).encode(), link_file(link.host), mode=0o600)


def _why_at_rest(pid: int) -> str:
    """Return why a process of a link does nothing, empty if it works."""
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as file:
            head, _, rest = file.read().rpartition(")")
    except OSError:
        head, rest = "", ""
    if f"({COMM}" not in head or rest.split()[0] in "ZX":
        return "the process of the link has ended"
    return "the process of the link was stopped by a signal" if rest.split()[0] in "Tt" else ""


def remove(host: str, pid: int = 0) -> None:
    """Remove what a link leaves that is no more; with `pid`, only if it is of that process."""
    with suppress(Unreachable):
        if pid and read(host).pid != pid:
            return
    for path in (tunnel_socket(host), link_file(host)):
        with suppress(FileNotFoundError):
            os.unlink(path)
