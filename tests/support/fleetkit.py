"""A shell whose manager is linked to hosts that `farkit` makes."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import farkit
import pytest
from farkit import FarHost, far_hosts
from forked import Commands
from shells import ROOT, Shell, opened_shell
from waiting import until

NEEDS_HOSTS = pytest.mark.skipif(bool(farkit.missing()), reason=farkit.missing())


def hosts_named(*names: str) -> Any:
    """Return a fixture: hosts of these names, for all tests of a module."""

    @pytest.fixture(scope="module")
    def hosts(tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[FarHost]]:
        with far_hosts(tmp_path_factory.mktemp("far"), *names) as made:
            yield made

    return hosts


def give_home(shell: Shell, hosts: list[FarHost]) -> None:
    """Give a shell a home of its own, from which these hosts can be logged into."""
    home = shell.folder / "home"
    (home / ".ssh").mkdir(parents=True, mode=0o700)
    (home / ".ssh" / "known_hosts").write_text("# no end of line: keys begin on another")
    if hosts:
        key = home / ".ssh" / "id_ed25519"
        key.write_bytes(hosts[0].key.read_bytes())
        key.chmod(0o600)
    wheels = os.environ.get("XDG_CACHE_HOME") or str(ROOT / ".venv" / "cache")
    shell.environment |= {"HOME": str(home), "XDG_CACHE_HOME": wheels}
    _make_wheel(wheels)
    for name in ("XDG_CONFIG_HOME", "SSH_AUTH_SOCK"):
        shell.environment.pop(name, None)


@cache
def _make_wheel(folder: str) -> None:
    """Have the wheel of this rtkit made, which a command takes a minute for on a busy machine."""
    code = "from rtkit.hosts.wheels import own_wheel; own_wheel()"
    environment = {**os.environ, "XDG_CACHE_HOME": folder}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)


def accept_key(shell: Shell, name: str) -> None:
    """Accept the key of a host as a user does, who is told how."""
    told = shell.run(f"rthost check {name}")
    assert told.status == 1
    shell.ok(told.err.strip().rpartition("if that is it: ")[2])


@contextmanager
def linked(commands: Commands, hosts: list[FarHost]) -> Iterator[Shell]:
    """Have a shell whose manager is linked to all hosts."""
    with opened_shell(commands) as shell:
        give_home(shell, hosts)
        for host in hosts:
            shell.ok(f"rthost add {host.name} root@{host.address}")
            accept_key(shell, host.name)
        for host in hosts:  # one by one: on a busy machine each may take most of a command's time
            shell.ok(f"rtmgr start --host {host.name}")
        yield shell
        shell.ok("rtmgr stop")


def cut(shell: Shell, *hosts: FarHost) -> None:
    """Cut the network links of hosts, and wait until the links to them are lost."""
    for host in hosts:
        host.link("down")
    for host in hosts:
        until(lambda h=host: not _answers(shell, h), f"the link to {host.name} is lost")


def linked_again(shell: Shell, *hosts: FarHost) -> None:
    """Heal the network links of hosts, and wait until these are linked."""
    for host in hosts:
        host.link("up")
    for host in hosts:
        until(lambda h=host: _answers(shell, h), f"{host.name} is linked again")


def _answers(shell: Shell, host: FarHost) -> bool:
    return shell.run(f"rtls /{host.name}").status == 0
