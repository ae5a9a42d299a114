"""Knows the property services that are there, by what they say that they are."""

from __future__ import annotations

from collections.abc import Iterable
from time import monotonic
from typing import NamedTuple

from rtkit.api.asked import Ask
from rtkit.api.client import Client
from rtkit.errors import RtkitError
from rtkit.link import places
from rtkit.property.codes import PropertyError

_GOOD_S = 2.0
"""How long what was found is taken for true."""
_BOUND_S = 1.0
_MOST_LAYERS = 40


class FoundService(NamedTuple):
    """A service of this host, or of one that is linked.

    Attributes:
        target: Names it.
        types: What it says that it is; empty of one that does not answer.
    """

    target: str
    types: tuple[str, ...]


class PropertyServices:
    """Services, looked at again after a while."""

    def __init__(self, client: Client) -> None:
        """Know none yet."""
        self._client = client
        self._known: tuple[FoundService, ...] = ()
        self._until = 0.0

    def all(self) -> tuple[FoundService, ...]:
        """Return all services; those of linked hosts begin with ``/HOST/``. It may take 2 s."""
        if monotonic() >= self._until:
            names = [*places.services(), *self._far()]
            asks = [Ask(f"{each}.type") for each in names]
            answers = self._client.ask_all(asks, _BOUND_S)
            pairs = zip(names, answers, strict=True)
            self._known = tuple(FoundService(name, _words(answer)) for name, answer in pairs)
            self._until = monotonic() + _GOOD_S
        return self._known

    def of_type(self, word: str) -> list[str]:
        """Return the services that say that they are of a type."""
        return [each.target for each in self.all() if word in each.types]

    def layers(self) -> list[str]:
        """Return properties that show places in the frame of the world, for maps."""
        found = [f"{each}.markers" for each in self.of_type("environment")]
        found += [f"{each}.location" for each in self.of_type("mobilerobot")]
        for world in self.of_type("world"):
            found += [f"{world}.rooms.{each}" for each in self.names(f"{world}.rooms")]
        return found[:_MOST_LAYERS]

    def names(self, target: str, **options: int) -> list[str]:
        """Return the names below a property, none where that cannot be told."""
        try:
            return list(_words(self._client.get(f"{target}.properties", **options)))
        except RtkitError:
            return []

    def _far(self) -> Iterable[str]:
        try:
            hosts = _words(self._client.get("/localhost.hosts"))
        except RtkitError:
            return
        asks = [Ask(f"/{each}.services") for each in hosts]
        answers = self._client.ask_all(asks, _BOUND_S)
        for host, answer in zip(hosts, answers, strict=True):
            yield from (f"/{host}/{each}" for each in _words(answer))


def _words(answer: object) -> tuple[str, ...]:
    """Return the words of a list; none of an error, or of what is no list."""
    if isinstance(answer, PropertyError) or not isinstance(answer, tuple):
        return ()
    return tuple(str(each) for each in answer)
