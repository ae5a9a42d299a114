"""Installs on all hosts of a system what its plan says: here itself, elsewhere over SSH."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

from rtkit import fault
from rtkit.deployment.packages import Installer
from rtkit.hosts import far_packages, far_side, inventory, provisioned
from rtkit.hosts.connection import connect
from rtkit.hosts.host import named
from rtkit.hosts.progress import by_lines
from rtkit.hosts.wheels import target_of
from rtkit.packages.installed import work_folder
from rtkit.packages.wheel_target import WheelTarget

Wheels = Callable[[str, str, WheelTarget], Mapping[str, Sequence[str]]]
"""Returns the wheels of a ``HOST/NAME==VERSION`` for a target; a folder gets those it fetches."""


class HostsInstaller:
    """Installs packages, ``HOST/NAME==VERSION``, on several hosts, of which `here` is this one."""

    def __init__(
        self,
        here: str,
        near: Installer,
        wheels: Wheels,
        system: str,
        bare: Collection[str],
        notify: Callable[[str], object],
        timeout_s: float,
    ) -> None:
        """Prepare to install.

        Args:
            here: Name of this host.
            near: Installs on it.
            wheels: Finds what is pushed to the others.
            system: For which it is installed.
            bare: Hosts on which no manager runs: they get this rtkit before, if they lack it.
            notify: Is told what is done there.
            timeout_s: How long a host may take to answer [s].
        """
        self._here = here
        self._near = near
        self._wheels = wheels
        self._system = system
        self._bare = bare
        self._show = by_lines(notify)
        self._timeout_s = timeout_s

    def install(self, package: str) -> None:
        """Install a package; one that is there already is left as it is.

        Raises:
            RtkitError: See `rtkit.hosts.far_packages.push`; the wheels cannot be had.
        """
        host = package.partition("/")[0]
        if host == self._here:
            self._near.install(package)
            return
        known = inventory.host(host)
        with work_folder() as folder, connect(known, self._timeout_s) as connection:
            look, is_bare = far_side.look(connection), host in self._bare
            with named(host):
                target = target_of(look, known.extras, is_bare=is_bare)
                wheels = self._wheels(package, folder, target)
            if is_bare:
                provisioned.provision(connection, look, self._show)
            fault.point("packages.push")
            far_packages.push(connection, wheels, self._system, self._show)
            fault.point("packages.pushed")

    def uninstall(self, package: str) -> None:
        """Remove a package.

        Raises:
            Refused: A manager uses it.
            Unreachable: The host does not answer.
        """
        host, _, name = package.partition("/")
        if host == self._here:
            self._near.uninstall(package)
            return
        with connect(inventory.host(host), self._timeout_s) as connection:
            far_packages.remove(connection, [name], is_forced=False)
