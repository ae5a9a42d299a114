"""Packages of a wanted system: which component needs which, and what installs them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from rtkit.errors import Refused
from rtkit.fast_dataclass import dataclass, field


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
        installed: What is installed, ``HOST/NAME==VERSION``.
        digests: By package, of those to be installed, the SHA-256 of all wheels, by file.
        surplus: Folders of those that the system was installed with and needs no longer.
        installer: What installs them.
    """

    of: Mapping[str, str] = field(default_factory=dict)
    installed: frozenset[str] = frozenset()
    digests: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    surplus: Mapping[str, str] = field(default_factory=dict)
    installer: Installer = NoInstaller()


NO_PACKAGES = Packages()
