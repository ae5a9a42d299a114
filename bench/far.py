"""Has hosts for measurements: namespaces with a real sshd each, as the tests have them."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bench.harness import command, folders, process
from bench.sshd import Login
from rtkit.hosts import inventory
from rtkit.hosts.host import Host
from rtkit.hosts.wheels import cache_folder

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))

PROGRAM = "/root/.local/share/rtkit/current/bin/rtmgr"
"""The command of rtkit on such a host."""


def missing() -> str:
    """Return why there can be no such hosts here, empty if there can."""
    import farkit  # type: ignore[import-not-found]

    return str(farkit.missing())


@contextmanager
def hosts(count: int) -> Iterator[list[Any]]:
    """Have hosts ``b0``, ``b1`` and so on, and an environment that knows nothing but them.

    Their wheels are those of the cache of this user.
    """
    import farkit

    names = [f"b{index}" for index in range(count)]
    kept = dict(os.environ)
    with folders() as base:
        try:
            os.environ["XDG_CACHE_HOME"] = os.path.dirname(os.path.dirname(cache_folder()))
            os.environ["HOME"] = base
            for name in ("XDG_CONFIG_HOME", "SSH_AUTH_SOCK"):
                os.environ.pop(name, None)
            with farkit.far_hosts(Path(base), *names) as found:
                _know(Path(base) / ".ssh", found)
                yield found
        finally:
            os.environ.clear()
            os.environ.update(kept)


def _know(folder: Path, found: list[Any]) -> None:
    folder.mkdir(mode=0o700)
    (folder / "id_ed25519").write_bytes(found[0].key.read_bytes())
    (folder / "id_ed25519").chmod(0o600)
    key = " ".join((found[0].folder / "hostkey.pub").read_text().split()[:2])
    (folder / "known_hosts").write_text("".join(f"{each.address} {key}\n" for each in found))
    for each in found:
        inventory.add(Host(each.name, each.address, "root"))


def line(word: str, found: list[Any]) -> list[str]:
    """Return the command that starts, or stops, the managers of hosts."""
    return [command("rtmgr"), word, *(text for each in found for text in ("--host", each.name))]


@contextmanager
def linked(found: list[Any]) -> Iterator[None]:
    """Have rtkit on hosts, their managers started, and linked to one here."""
    process([command("rtmgr"), "start", "--no-door"])
    try:
        process(line("start", found))
        yield
        process(line("stop", found))
    finally:
        process([command("rtmgr"), "stop"])


def login(host: Any) -> Login:
    """Return how to log in at a host with the client of OpenSSH."""
    home = os.environ["HOME"]
    options = ("BatchMode=yes", f"UserKnownHostsFile={home}/.ssh/known_hosts")
    words = ["ssh", "-F", "none", "-i", f"{home}/.ssh/id_ed25519", "-q"]
    for option in options:
        words += ["-o", option]
    return Login([*words, f"root@{host.address}"])
