"""Records of packages: what is installed, what offers types, and what a system asks about a host.

Most systems need no package, and should not load what handles them.
"""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.fast_dataclass import Record, field
from rtkit.rtc.profiles import TypeProfile


class Installed(Record):
    """A version of a package that is installed; `wheels` are its own and those that it needs."""

    name: str
    version: str
    path: str
    types: tuple[str, ...]
    requires: tuple[str, ...]
    wheels: Mapping[str, str]

    @property
    def text(self) -> str:
        """``NAME==VERSION``."""
        return f"{self.name}=={self.version}"


class Offering(Record):
    """Offer of a package to make components of a type; the module is ``NAME==VERSION:INIT``."""

    package: Installed
    type: TypeProfile
    module: str


class Survey(Record):
    """Packages of a host as a system sees them.

    Attributes:
        installed: All, ``NAME==VERSION``.
        offers: What offers the types that were asked for, by id, the newest first.
        surplus: What the system was installed with and needs no longer: folders by package.
        unknown: Why some may be surplus, too.
    """

    installed: tuple[str, ...] = ()
    offers: Mapping[str, tuple[Offering, ...]] = field(default_factory=dict)
    surplus: Mapping[str, str] = field(default_factory=dict)
    unknown: str = ""


class Question(Record):
    """Question of a system about the packages of a host.

    Attributes:
        system: Id of the system.
        types: Ids of the types that it needs on the host.
        managers: Its managers there: what no other uses may be surplus.
        notes: Note that it needs what was installed for others.
    """

    system: str
    types: tuple[str, ...]
    managers: tuple[str, ...]
    notes: bool = False
