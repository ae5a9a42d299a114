"""Installs on all hosts of a system what its plan says: here itself, elsewhere over SSH."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import NamedTuple

from rtkit import fault
from rtkit.hosts import far_packages, far_side, inventory, provisioned
from rtkit.hosts.connection import connect
from rtkit.hosts.host import named
from rtkit.hosts.progress import Progress
from rtkit.hosts.wheels import target_of
from rtkit.packages.installed import work_folder
from rtkit.packages.supply import LocalInstaller
from rtkit.packages.wheel_target import WheelTarget
from rtkit.rtc.names import LOCAL

Wheels = Callable[[str, str, WheelTarget], Mapping[str, Sequence[str]]]
"""Returns the wheels of a ``HOST/NAME==VERSION`` for a target; a folder gets those it fetches."""


class HostsInstaller(NamedTuple):
    """Installs packages, ``HOST/NAME==VERSION``, on several hosts.

    Attributes:
        near: Installs on this host.
        wheels: Finds what is pushed to the others.
        bare: Hosts on which no manager runs: they get this rtkit before, if they lack it.
        show: Is shown what is done there.
    """

    near: LocalInstaller
    wheels: Wheels
    bare: Collection[str]
    show: Progress

    def install(self, package: str) -> None:
        """Install a package; one that is there already is left as it is.

        Raises:
            RtkitError: See `rtkit.hosts.far_packages.push`; the wheels cannot be had.
        """
        host = package.partition("/")[0]
        if host == LOCAL:
            self.near.install(package)
            return
        known = inventory.host(host)
        with work_folder() as folder, connect(known, self.near.timeout_s) as connection:
            look, is_bare = far_side.look(connection), host in self.bare
            with named(host):
                target = target_of(look, known.extras, is_bare=is_bare)
                wheels = self.wheels(package, folder, target)
            if is_bare:
                provisioned.provision(connection, look, self.show)
            fault.point("packages.push")
            far_packages.push(connection, wheels, self.near.system, self.show)
            fault.point("packages.pushed")

    def uninstall(self, package: str) -> None:
        """Remove a package.

        Raises:
            Refused: A manager uses it.
            Unreachable: The host does not answer.
        """
        host, _, name = package.partition("/")
        if host == LOCAL:
            self.near.uninstall(package)
            return
        with connect(inventory.host(host), self.near.timeout_s) as connection:
            far_packages.remove(connection, [name], is_forced=False)
