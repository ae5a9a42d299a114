"""Packages of a wanted system: which component needs which, and what installs them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Protocol

from rtkit.errors import Refused
from rtkit.fast_dataclass import dataclass, field
from rtkit.rtc.names import LOCAL, split_manager

if TYPE_CHECKING:
    from rtkit.deployment.live_index import LiveIndex


class Installer(Protocol):
    """Installs packages on hosts, and removes them: ``HOST/NAME==VERSION``."""

    def install(self, package: str) -> None:
        """Install a package with all that it needs."""
        ...

    def uninstall(self, package: str) -> None:
        """Remove a package that no manager uses."""
        ...


class NoInstaller:
    """Refuses to install anything."""

    def install(self, package: str) -> None:
        """Refuse; the message names the command that installs it."""
        raise Refused(f"nothing installs it here (rtpkg install {package.partition('/')[2]})")

    uninstall = install


@dataclass(frozen=True, slots=True)
class Packages:
    """Packages that a wanted system needs.

    Attributes:
        of: ``NAME==VERSION`` by instance name, of components that a package offers.
        installed: Those that are installed, ``HOST/NAME==VERSION``.
        digests: Of those to be installed, by ``HOST/NAME==VERSION``, the SHA-256 of all wheels, by
            file.
        surplus: Folders of those that the system was installed with and needs no longer.
        installer: Installs them.
    """

    of: Mapping[str, str] = field(default_factory=dict)
    installed: frozenset[str] = frozenset()
    digests: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    surplus: Mapping[str, str] = field(default_factory=dict)
    installer: Installer = NoInstaller()


NO_PACKAGES = Packages()


def unused(
    packages: Packages, live: LiveIndex, ended: Collection[str]
) -> Iterator[tuple[str, list[str]]]:
    """Yield surplus packages of which nothing lives but what will have `ended`.

    With each come the modules of it that are loaded, ``MANAGER/PATH:INIT``.
    """
    alive = [c for c in live.snapshot.components if not c.zombie and c.instance not in ended]
    for package in sorted(packages.installed & packages.surplus.keys()):
        host, folder = package.partition("/")[0], f"{packages.surplus[package]}/"
        managers = [m for m in live.managers if (split_manager(m)[1] or LOCAL) == host]
        if not any(f" {folder}" in c.code and live.home(c.instance) in managers for c in alive):
            loaded = ((m, each) for m in managers for each in live.managers[m].modules)
            yield (
                package,
                [f"{m}/{e.path}:{e.init}" for m, e in loaded if e.file.startswith(folder)],
            )
