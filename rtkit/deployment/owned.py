"""Owned systems: where their components are that may be made elsewhere when a host is lost.

The owner is the manager on which a system was applied. See decision 79.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from rtkit.deployment.extension import MOVABLE
from rtkit.deployment.placement.profiles import with_paths
from rtkit.deployment.placement.requirements import FREE
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass, field, replace
from rtkit.profile.rts_model import RtsProfile
from rtkit.rtc.connector_properties import finite
from rtkit.rtc.names import LOCAL, manager_on, split_manager

_MOST_S = 86_400.0


class MovableRule(NamedTuple):
    """Policy of a movable component: how long its host may be lost, and where it goes then [s].

    Attributes:
        hosts: Those that it may go to, the first one that will do; the owner's comes last.
    """

    wait_s: float
    hosts: tuple[str, ...] = ()


def read_movable(instance: str, text: str) -> MovableRule:
    """Return the policy that ``SECONDS [HOST…]`` says.

    Raises:
        Malformed: It makes no sense; names the component.
    """
    first, *hosts = text.split() or [""]
    wait_s = finite(first)
    if wait_s is None or not 0 <= wait_s <= _MOST_S:
        raise Malformed(f"{instance}: {MOVABLE}: not SECONDS [HOST...]: {text!r}")
    return MovableRule(wait_s, tuple(hosts))


@dataclass(frozen=True, slots=True)
class OwnedComponent:
    """A movable component of an owned system.

    Attributes:
        home: The manager that it is to be in, called as in plans.
        origin: The one that its profile says.
        epoch: A number that grows each time it is made elsewhere: seconds since 1970, or more.
        stale: Managers in which an older one may live, which was not seen to end.
        why: Why there is no other place for it though its host is lost.
    """

    home: str
    origin: str
    epoch: int
    stale: tuple[str, ...] = ()
    why: str = ""


@dataclass(frozen=True, slots=True)
class OwnedSystem:
    """A system that its owner keeps whole while hosts are lost.

    Attributes:
        system: The identity of its profile.
        source: Names the profile in messages.
        profile: Its text, as XML.
        components: The movable ones, by instance name.
        is_pending: Where they are was changed, and a plan has not led there yet.
        why: Why the last plan failed; empty where it did not.
    """

    system: str
    source: str
    profile: str
    components: Mapping[str, OwnedComponent] = field(default_factory=dict)
    is_pending: bool = False
    why: str = ""

    def moved(self, instance: str, home: str, now: float, *, is_stale: bool) -> OwnedSystem:
        """Return the record once a component is to be elsewhere from `now` on [s since 1970].

        An older one may be left behind (`is_stale`).
        """
        known = self.components[instance]
        stale = tuple(each for each in known.stale if each != home)
        stale += (known.home,) if is_stale and known.home not in stale else ()
        epoch = max(known.epoch + 1, int(now))
        made = OwnedComponent(home, known.origin, epoch, stale)
        return self.with_component(instance, made, is_pending=is_stale)

    def with_component(
        self, instance: str, component: OwnedComponent, *, is_pending: bool | None = None
    ) -> OwnedSystem:
        """Return the record with another row of a component."""
        pending = self.is_pending if is_pending is None else is_pending
        components = {**self.components, instance: component}
        return replace(self, components=components, is_pending=pending)


def rules_of(profile: RtsProfile) -> dict[str, MovableRule]:
    """Return the policies of the movable components of a profile.

    Raises:
        Malformed: One makes no sense.
    """
    return {
        each.instance_name: read_movable(each.instance_name, item.value or "")
        for each in profile.components
        for item in each.properties
        if item.name == MOVABLE
    }


def opened(profile: RtsProfile, owned: OwnedSystem, names: Iterable[str]) -> RtsProfile:
    """Return the same as `placed`, in which the hosts of some components are open."""
    for name in names:
        row = replace(owned.components[name], home=manager_on("", FREE))
        owned = owned.with_component(name, row)
    return placed(profile, owned)


def placed(profile: RtsProfile, owned: OwnedSystem) -> RtsProfile:
    """Return a profile with the components where their owner has them."""
    return with_paths(profile, moved_paths(owned))


def moved_paths(owned: OwnedSystem) -> dict[str, str]:
    """Return the paths of the components that are not where their profile says."""
    return {
        name: f"{split_manager(each.home)[1] or LOCAL}/{name}.rtc"
        for name, each in owned.components.items()
        if each.home != each.origin
    }
