"""Names that come and go: an owner lists them, and is asked for each, also for one to be made.

Authors derive from `Names`; by the others `rtkit.property.objects` keeps the properties of a
service equal to the list.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from rtkit.property.conversion import to_value
from rtkit.property.mounting import MountPoint
from rtkit.property.property_spec import PropertySpec
from rtkit.property.types import Content

_UNSEEN = object()


class Names(ABC):
    """Properties whose names come and go: files, subgroups, services that register.

    The object that is served derives from it, then they stand beside its other members, which win;
    or an attribute holds one, then they stand below that. `names`, `get`, `set` and the others here
    are never actions. What `get` and `set` take behind the name are parameters of requests; the
    type is that of what `get` returns. They may be called by several threads.

    ``def set(self, name, value)``, if there is one, is called to set a value, and as well for a
    name that is not there: to make it, or to raise ``PropertyError("unknown", …)``.
    """

    @abstractmethod
    def names(self) -> Collection[str]:
        """Return the names that there are now, each part escaped, parts joined by dots.

        The same object as the last time says that nothing has changed.
        """

    @abstractmethod
    def get(self, name: str) -> Any:
        """Return the value of a name that was listed; parameters may follow."""

    def hint(self, name: str) -> Any:
        """Return the annotation of a value that is of another type, None of one that is not."""
        return None

    def mount(self, name: str) -> MountPoint | None:
        """Return who answers for all below a name, None for nobody else."""
        return None

    def stamp(self, name: str) -> object:
        """Return what is equal while a value stays the same, and cheap; None for what is not."""
        return None

    def about(self, name: str) -> Mapping[str, Any]:
        """Return what else ``.meta`` says of a name."""
        return {}

    def has_changed(self) -> bool:
        """Return whether names may be others than those listed last, as far as that is cheap."""
        return True


METHODS = frozenset({"set", *(name for name in vars(Names) if not name.startswith("_"))})
"""Names of methods that are no actions."""


class NameSource:
    """Owner of one property that came with a name.

    Attributes:
        read: The stamp of the value when its listeners were sent it last.
    """

    __slots__ = ("_name", "_seen", "_table", "read")

    def __init__(self, table: NameTable, name: str) -> None:
        self._table = table
        self._name = name
        self._seen: object = _UNSEEN
        self.read: object = _UNSEEN

    def stamp(self) -> object:
        """See `Names.stamp`."""
        return self._table.owner().stamp(self._name)

    def about(self) -> dict[str, Content]:
        """See `Names.about`."""
        about = self._table.owner().about(self._name)
        return {key: to_value(each) for key, each in about.items()}

    def has_other_names(self) -> bool:
        """Return whether its owner lists other names than it did."""
        return self._table.owner().names() is not self._table.known.listed

    def settle(self, stamp: object) -> int | None:
        """Note the present stamp; return by how much the revision grows, None for no change."""
        before, self._seen = self._seen, stamp
        return None if stamp == before else int(before is not _UNSEEN)

    @property
    def is_sent(self) -> bool:
        """Return whether listeners have been sent the value that belongs to the stamp."""
        return self._seen is not None and self._seen == self.read

    def sent(self) -> None:
        """Note that listeners are sent the value that belongs to the stamp."""
        self.read = self._seen


class NameListing(NamedTuple):
    """Names that an owner was found to have; it holds once the table is set to it.

    Attributes:
        listed: Names that the owner returned.
        present: The names, each once.
        hints: The annotations of new ones.
    """

    listed: Collection[str] = ()
    present: Mapping[str, None] = MappingProxyType({})
    hints: Mapping[str, Any] = MappingProxyType({})


class NameTable:
    """Names of one owner as they were listed last.

    Args:
        prefix: Prefix of each name in the service.
        owner: Returns it.
    """

    def __init__(self, prefix: str, owner: Callable[[], Names]) -> None:
        self.prefix = prefix
        self.owner = owner
        self.known = NameListing()
        self.specs: dict[Any, tuple[PropertySpec, Any, Any]] = {}

    def looked(self) -> NameListing | None:
        """List the names, which calls the owner; None if nothing has changed."""
        owner, before = self.owner(), self.known
        listed = owner.names()
        if listed is before.listed:
            return None
        present = dict.fromkeys(listed)
        hints = {name: owner.hint(name) for name in present if name not in before.present}
        return NameListing(listed, present, hints)

    def put(self, listing: NameListing) -> tuple[list[str], dict[str, Any]]:
        """Have the table know what was found; return names that are gone, and new ones with hints.

        Others may have put what they found meanwhile; what went and came again since is left to the
        next look.
        """
        before, present, hints = self.known.present, listing.present, listing.hints
        gone = [name for name in before if name not in present]
        missing = {name for name in present if name not in before and name not in hints}
        added = {name: hint for name, hint in hints.items() if name not in before}
        self.known = listing._replace(hints={})
        if missing:
            kept = {name: None for name in present if name not in missing}
            self.known = NameListing([], kept)  # like none that is listed
        return gone, added
