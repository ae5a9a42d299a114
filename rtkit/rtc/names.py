"""Names and paths in the tree of live properties.

A path is ``/host/dir/…/name.rtc``; the first element is a host (or ``host:port``), a port follows
the last element after a colon: ``/localhost/Motor0.rtc:velocity``.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from rtkit.errors import Malformed

if TYPE_CHECKING:
    from re import Pattern

LOCAL = "localhost"
COMPONENT_SUFFIX = ".rtc"
MANAGER_SUFFIX = ".mgr"
_MAX_NAME = 255
_MAX_HOST = 64


class Path(NamedTuple):
    """A path made absolute, with what the user typed kept for messages.

    Attributes:
        elements: Names below the root; none for the root itself.
        port: The port after the colon, None when none was given.
        is_directory: A trailing slash was typed.
    """

    typed: str
    elements: tuple[str, ...]
    port: str | None = None
    is_directory: bool = False

    def __str__(self) -> str:
        text = "/" + "/".join(self.elements)
        return text if self.port is None else f"{text}:{self.port}"


def parse_path(typed: str, cwd: str = "/") -> Path:
    """Read a path as typed, relative to the working directory `cwd`.

    Raises:
        Malformed: A second colon in the last element, or an unusable character.
    """
    if any(ord(c) < 32 or ord(c) == 127 for c in typed):
        raise Malformed(f"Bad path: {typed!r}")
    whole = typed if typed.startswith("/") else f"{cwd.rstrip('/')}/{typed}"
    steps = whole.split("/")
    last = steps.pop()
    elements: list[str] = []
    for step in steps:
        _walk(elements, step)
    port = None
    name, colon, tail = last.partition(":")
    is_host = not elements and tail.isdigit()
    if colon and not is_host:
        if ":" in tail or not tail:
            raise Malformed(f"Bad path: {typed}")
        last, port = name, tail
    is_directory = last in ("", ".", "..")
    _walk(elements, last)
    return Path(typed, tuple(elements), port, is_directory)


def _walk(elements: list[str], step: str) -> None:
    if step in ("", "."):
        return
    if step == "..":
        if elements:
            elements.pop()
        return
    elements.append(step)


def check_instance_name(name: str) -> str:
    """Return `name` if a component may bear it.

    Raises:
        Malformed: Names the rule that it breaks.
    """
    if not name or name != name.strip():
        raise Malformed(f"instance name is empty or begins or ends with a blank: {name!r}")
    if len(name.encode("utf-8", "replace")) > _MAX_NAME:
        raise Malformed(f"instance name is longer than {_MAX_NAME} bytes: {name[:40]}…")
    bad = sorted({c for c in name if c in "/:?&=,@" or not c.isprintable()})
    if bad:
        raise Malformed(f"instance name {name!r} has characters that are not allowed: {bad}")
    if name.startswith("*"):
        raise Malformed(f"instance name begins with *, the mark of zombies: {name}")
    if name in (".", ".."):
        raise Malformed(f"instance name is reserved: {name}")
    return name


def check_host_name(name: str) -> str:
    """Return a name if another host can bear it.

    Raises:
        Malformed: It cannot be an element of a path, or means this host.
    """
    try:
        check_instance_name(name)
    except Malformed as error:
        raise Malformed(str(error).replace("instance name", "name of a host", 1)) from None
    if any(c.isspace() for c in name):
        raise Malformed(f"name of a host has a blank: {name!r}")
    if name == LOCAL or name.startswith(("-", ".")):
        raise Malformed(f"not a name for a host: {name}")
    if name.endswith((COMPONENT_SUFFIX, MANAGER_SUFFIX)):
        raise Malformed(f"not a name for a host, but for what runs on one: {name}")
    if len(name.encode("utf-8", "replace")) > _MAX_HOST:  # as of Linux; files bear it, too
        raise Malformed(f"name of a host is longer than {_MAX_HOST} bytes: {name[:40]}…")
    return name


@lru_cache(maxsize=1024)  # components of one type have the same ports
def check_port_name(name: str) -> str:
    """Return `name` if a port may bear it.

    Raises:
        Malformed: Names the rule that it breaks.
    """
    bad = sorted({c for c in name if _is_barred(c)})
    if bad or not name or name != name.strip():
        why = (
            f"has characters that are not allowed: {bad}" if bad else "begins or ends with a blank"
        )
        raise Malformed(f"port name {name!r} {why}")
    return name


def check_set_name(name: str) -> str:
    """Return `name` if a further configuration set may bear it.

    Raises:
        Malformed: Names the rule that it breaks.
    """
    bad = sorted({c for c in name if c in ".=&?," or c.isspace() or _is_barred(c)})
    if not name or bad:
        why = f"has characters that are not allowed: {bad}" if bad else "is empty"
        raise Malformed(f"name of a configuration set {name!r} {why}")
    if name.startswith("_"):
        raise Malformed(f"configuration set {name} could not be activated: it begins with _")
    if name == "default":
        raise Malformed("configuration set default is there already: it holds the defaults")
    return name


def near_port_name(name: str) -> str:
    """Return what of a name a port may bear, empty if that is nothing."""
    return "".join("_" if _is_barred(c) else c for c in name).strip()


def _is_barred(character: str) -> bool:
    return character in "/:" or not character.isprintable()


def glob(text: str, *, any_case: bool = False) -> Pattern[str]:
    """Return a pattern of names, in which * stands for any text and ? for any character."""
    import re

    parts = (".*" if c == "*" else "." if c == "?" else re.escape(c) for c in text)
    return re.compile("".join(parts), re.DOTALL | (re.IGNORECASE if any_case else 0))


def is_glob(text: str) -> bool:
    """Return whether a text is a pattern of names."""
    return "*" in text or "?" in text


def manager_on(manager: str, host: str) -> str:
    """Return how plans over several hosts name a manager of another one: ``manager@robot1``."""
    return f"{manager}@{host}"


def split_manager(name: str) -> tuple[str, str]:
    """Return a manager and its host, which is empty for this one."""
    manager, _, host = name.partition("@")
    return manager, host


def is_local_host(host: str, hostname: str) -> bool:
    """Return whether `host` (with or without ``:port``) means the machine named `hostname`."""
    names = (LOCAL, "127.0.0.1", "::1", "[::1]", hostname, hostname.split(".")[0])
    name, _, port = host.rpartition(":")
    return host in names or (port.isdigit() and name in names)
