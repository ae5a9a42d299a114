"""Properties as they are typed: ``SERVICE.NAME``, ``/localhost/SERVICE.NAME``, ``…/SERVICE/NAME``.

The three are the same. The longest name of a present service that fits is the service.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Literal, NamedTuple

from rtkit.property.codes import PropertyError
from rtkit.rtc.names import is_local_host

_MOST_NAMED = 12
"""Services that an error names all."""
OwnerKind = Literal["service", "node", "host", "far", "far host"]


class PropertyTarget(NamedTuple):
    """A property as it was typed.

    Attributes:
        service: Where it is, empty if no service fits.
        name: Of the property, as a target without parameters; empty for the service itself.
        parameters: Text behind the question mark, None for nothing.
    """

    typed: str
    service: str
    name: str
    parameters: str | None = None

    @classmethod
    def of_path(cls, typed: str, path: str) -> PropertyTarget:
        """Return the property of an owner that has one service only, by its path there."""
        name, mark, parameters = path.partition("?")
        return cls(typed, "", name, parameters if mark else None)

    def target(self, more: str = "", extension: str = "") -> str:
        """Return what to ask for; the service itself stands for the names it has."""
        name = self.name or ("" if extension == "listen" else "properties")
        if extension:
            name = f"{name}.{extension}" if name else f"properties.{extension}"
        given = [each for each in (self.parameters, more) if each]
        is_marked = self.parameters is not None or more
        return f"{name}?{'&'.join(given)}" if is_marked else name


def parse(typed: str, cwd: str, services: Iterable[str], hostname: str) -> PropertyTarget:
    """Read what was typed, relative to the working directory `cwd` in the tree."""
    place = PropertyTarget.of_path(typed, typed)
    path = place.name
    whole = path if path.startswith("/") else f"{cwd.rstrip('/')}/{path}"
    steps = [step for step in whole.split("/") if step not in ("", ".")]
    if steps and is_local_host(steps[0], hostname):
        steps.pop(0)
    elif steps and path.startswith("/"):
        return place._replace(name=whole)
    rest = "/".join(steps)
    for service in sorted(services, key=len, reverse=True):
        if rest == service:
            return place._replace(service=service, name="")
        if rest.startswith((f"{service}.", f"{service}/")):
            name = rest[len(service) + 1 :].strip("/")
            return place._replace(service=service, name=name.replace("/", "."))
    return place._replace(name=rest)


def no_service(
    name: str,
    known: Sequence[str],
    more: str = "",
    is_alive: Callable[[str], bool] = lambda _: True,
) -> PropertyError:
    """Return the error that no service present has such a name; of many, names those like it.

    Of those known it names only living ones, as `is_alive` tells; of many it asks only a few.
    """
    first = name.partition(".")[0]
    if len(known) <= _MOST_NAMED:
        there = f"there is {' '.join(filter(is_alive, known)) or 'none'}{more}"
    else:
        from rtkit.rtc.nearest import nearest

        near = list(filter(is_alive, nearest(first, known)))
        like = f", such as {' '.join(near)}" if near else ""
        there = f"there are {len(known)}{like}{more}"
    return PropertyError("no-service", f"no service named {first} ({there})" if first else there)


def no_service_here(name: str, known: Sequence[str], more: str = "") -> PropertyError:
    """Return the error that no service of this host has such a name; see `no_service`."""
    from rtkit.link.running import is_service

    return no_service(name, known, more, is_service)
