"""Parses values of properties with a structure: ports, processors, modules to load."""

from __future__ import annotations

from ipaddress import ip_address

from rtkit.deployment.supervision import restart_of
from rtkit.errors import Malformed, Refused
from rtkit.rtc.names import LOCAL
from rtkit.rtc.profiles import split_module

DEFAULT_PORT = 2810
"""Where a manager listens by convention."""

MAX_PROCESSOR = 4095
PROCESS_UNIQUE = "process_unique"
POLICIES = (PROCESS_UNIQUE, "node_unique", "ns_unique")
_LOOPBACK = ("", LOCAL, "127.0.0.1")


def endpoint(text: str) -> int | None:
    """Return the port of ``[HOST]:PORT`` (0 for any free one), None for ``none``.

    ``all`` is the usual port. Only this host can be listened on.

    Raises:
        Malformed: It cannot be read.
        Refused: It is an address that other hosts could reach.
    """
    word = text.strip().lower()
    if word in ("none", "no"):
        return None
    if word == "all":
        return DEFAULT_PORT
    host, _, port = word.rpartition(":")
    if "," in word or not (port.isascii() and port.isdigit() and int(port) < 65536):
        raise Malformed(f"not [{LOCAL}]:PORT, all or none: {text}")
    if host not in _LOOPBACK:
        raise Refused(
            f"other hosts could reach {text}, which takes TLS (net.tls, rtmgr start --tls);"
            f" {LOCAL}:{port} can be had"
        )
    return int(port)


def tls_endpoint(text: str) -> tuple[str, int] | None:
    """Return address and port of ``[ADDRESS:]PORT`` (0 for any free one), None for ``none``.

    Without an address it is loopback.

    Raises:
        Malformed: It cannot be read.
    """
    if text.strip().lower() in ("", "none", "no"):
        return None
    address, _, port = text.strip().rpartition(":")
    bare = "127.0.0.1" if address in _LOOPBACK else address.strip("[]")
    try:
        shown = str(ip_address(bare))
    except ValueError:
        shown = ""
    if not shown or not (port.isascii() and port.isdigit() and int(port) < 65536):
        raise Malformed(f"not [ADDRESS:]PORT with a numeric address (0.0.0.0 is all): {text}")
    return shown, int(port)


def processors(text: str) -> frozenset[int]:
    """Return the processors of a list as ``0,2-3``.

    Raises:
        Malformed: It cannot be read.
    """
    found: set[int] = set()
    for item in text.split(","):
        first, dash, last = (part.strip() for part in item.partition("-"))
        numbers = (first, last if dash else first)
        if not all(n.isascii() and n.isdigit() and int(n) <= MAX_PROCESSOR for n in numbers):
            raise Malformed(f"not a list of processors as 0,2-3: {text}")
        low, high = map(int, numbers)
        if high < low:
            raise Malformed(f"not a list of processors as 0,2-3: {text}")
        found.update(range(low, high + 1))
    return frozenset(found)


def naming_policy(text: str) -> str:
    """Return which names of components `TYPE<n>` are to differ from.

    Raises:
        Malformed: There is no such policy.
    """
    if text not in POLICIES:
        raise Malformed(f"no naming policy: {text} (one of {', '.join(POLICIES)})")
    return text


def restart(text: str) -> str:
    """Return the policy word for what is restarted after it has died.

    Raises:
        Malformed: It is none of those that there are.
    """
    return restart_of("restart", text)


def modules(text: str) -> tuple[tuple[str, str], ...]:
    """Return file and init function, empty for the usual one, of each module.

    They are written ``FILE (InitFunc)`` or ``FILE:InitFunc``; FILE may be ``package.module``.

    Raises:
        Malformed: A part is missing.
    """
    found = []
    for item in filter(None, map(str.strip, text.split(","))):
        file, opening, tail = item.partition("(")
        if not opening and ":" in item:
            found.append(split_module(item))
            continue
        init = tail.strip().removesuffix(")").strip()
        if not file.strip() or (opening and not (tail.rstrip().endswith(")") and init)):
            raise Malformed(f"not FILE (InitFunc): {item}")
        found.append((file.strip(), init))
    return tuple(found)
