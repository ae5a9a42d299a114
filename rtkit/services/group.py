"""Group service: many robots that are driven as one, by the client that drives one robot.

A SET goes to all members at once, a GET combines what they answer; one deadline holds for all of
it, and a member that is dead or slow is named and delays no other.

See decision 63.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from time import monotonic
from typing import Annotated, Any, Final

import rtkit
from rtkit import init_of
from rtkit.services.fanout import (
    MemberFailure,
    Members,
    combined,
    error_of,
    formation,
    is_own,
    markers_in,
)
from rtkit.services.frames import Frames

Six = tuple[float, float, float, float, float, float]
_POLLED_S = 0.2
"""How often what somebody listens to is asked for [s]."""


def hint_of(name: str) -> Any:
    """Return the type of a property of all."""
    return Six if name in ("location", "velocity") else Any


class _Led(rtkit.Names):
    """Properties of some members as properties of one robot."""

    def __init__(self, members: Members, selected: Callable[[], Sequence[str]]) -> None:
        self._members = members
        self._selected = selected

    def names(self) -> Collection[str]:
        """Return the names that members have, as far as they are known."""
        return self._members.names()

    def hint(self, name: str) -> Any:
        """Return the type of a property."""
        return hint_of(name)

    def stamp(self, name: str) -> object:
        """Return what differs after a while: members are not asked more often for listeners."""
        return int(monotonic() / _POLLED_S)

    def about(self, name: str) -> Mapping[str, Any]:
        """Return the meta data that a member has of a property."""
        return self._members.about(name)

    def get(self, name: str, form: str = "", frame: str = "") -> Any:
        """Return what the members answer, combined; as ``?form=list`` of each."""
        if form not in ("", "list"):
            raise rtkit.PropertyError("bad-parameter", f"form is list, or not given: {form}")
        selected, parameters = self._selected(), {"frame": frame} if frame else {}
        values, failures = self._members.get(selected, name, parameters)
        if not values:
            raise error_of(failures, len(selected))
        if form == "list":
            return tuple((rtkit.Word(each), value) for each, value in values.items())
        return combined(values, failures, name)

    def set(self, name: str, value: Any, frame: str = "") -> None:
        """Set a property of each; to a target that is a marker with its offset from the middle.

        Raises:
            PropertyError: Some have not done it: the text names each, and why.
        """
        if name == "location":
            raise rtkit.PropertyError("read-only", f"cannot be set: {name}")
        if is_own(name):
            raise rtkit.PropertyError("unknown", f"no such property: {name}")
        members, selected = self._members, self._selected()
        until = monotonic() + members.deadline
        failures: list[MemberFailure] = []
        values: Mapping[str, Any] = dict.fromkeys(selected, value)
        markers = markers_in(value) if name.startswith("behaviors.") else []
        if markers and selected:
            poses, failures = members.get(selected, "location", {}, members.deadline / 2)
            targets = formation(markers, poses, Frames(members.pose_of)) if poses else {}
            is_route = isinstance(value, list | tuple)
            values = {each: tuple(way) if is_route else way[0] for each, way in targets.items()}
        parameters = {"frame": frame} if frame else {}
        done, failed = members.set(values, name, parameters, until - monotonic())
        members.failures = failures = [*failures, *failed]
        if failures or not done:
            raise error_of(failures, len(selected))


class Group(_Led):
    """Group of robots: has the properties of one robot, and all of each below ``robots``.

    Args:
        robots: Its first members, services or ``NAME=SERVICE``; more may `join`.
        deadline: How long members may take for an answer [s].

    Attributes:
        robots: The members, by name; each has all its own properties.
        groups: Some members under a name of their own: ``SET groups.left (r1 r2)``.
    """

    type: Final = ("mobilerobot", "group")
    version: Final = "1.0"

    def __init__(self, *, robots: str = "", deadline: float = 1.0) -> None:
        members = Members(deadline)
        super().__init__(members, members.present)
        self.robots: dict[str, Any] = {}
        self.groups: Final = Subgroups(members)
        for each in robots.split():
            self.join(each)

    def __enter__(self) -> Group:
        self._members.begin()
        return self

    def __exit__(self, *_: object) -> None:
        self._members.end()

    def join(self, robot: str) -> None:
        """Take a service into the group that is there: SERVICE, or NAME=SERVICE."""
        name, target = self._members.add(robot)
        self.robots[name] = rtkit.Mount(target)

    def leave(self, robot: str) -> None:
        """Take a member out of the group, by its name."""
        self._members.remove(robot)
        self.robots.pop(robot, None)

    def get_deadline(self) -> Annotated[float, rtkit.Unit("s"), rtkit.Range(0.001, 3600.0)]:
        """Time that members may take for an answer."""
        return self._members.deadline

    def set_deadline(self, deadline: float) -> None:
        """Have members answer sooner or later."""
        self._members.deadline = deadline

    def get_status(self) -> str:
        """State of its members: ``ready``, ``moving``, ``empty``; or failed, and who."""
        if not self._selected():
            return "empty"
        values, failures = self._members.get(self._selected(), "status", {})
        failed = [each for each, value in values.items() if str(value).startswith("failed")]
        failed += [each.name for each in failures if each.code != "unknown"]
        if failed:
            return f"failed: {' '.join(failed)}"
        return "ready" if {*map(str, values.values())} <= {"ready", "empty"} else "moving"

    def get_failures(self) -> list[tuple[str, str, str]]:
        """Members that did not do what was asked of all last: name, code, text."""
        word = rtkit.Word
        return [(word(each.name), word(each.code), each.text) for each in self._members.failures]


class Subgroups(rtkit.Names):
    """Groups of some members: a list of names each, and what a robot has below it; ``all`` too."""

    def __init__(self, members: Members) -> None:
        self._members = members
        self._groups: dict[str, tuple[str, ...]] = {}
        self._listed: tuple[tuple[object, ...], tuple[str, ...]] = ((), ())

    def names(self) -> Collection[str]:
        """Return the groups, and what is below each."""
        known = (self._members.names(), *self._groups)
        if known != self._listed[0]:
            below = [f"{group}.{name}" for group in self._groups for name in known[0]]
            self._listed = known, ("all", *self._groups, *below)
        return self._listed[1]

    def hint(self, name: str) -> Any:
        """Return the type of a property."""
        return list if "." not in name else hint_of(name.partition(".")[2])

    stamp = _Led.stamp

    def about(self, name: str) -> Mapping[str, Any]:
        """Return the meta data that a member has of a property."""
        return self._members.about(name.partition(".")[2]) if "." in name else {}

    def get(self, name: str, form: str = "", frame: str = "") -> Any:
        """Return the members of a group, or what they answer."""
        group, _, rest = name.partition(".")
        if rest:
            return self._at(group).get(rest, form, frame)
        return tuple(map(rtkit.Word, self._of(group)))

    def set(self, name: str, value: Any, frame: str = "") -> None:
        """Set the members of a group (none: it is gone), or a property of each."""
        group, _, rest = name.partition(".")
        if rest:
            self._at(group).set(rest, value, frame)
            return
        if group == "all":
            raise rtkit.PropertyError("read-only", "all members are in it")
        selected = tuple(dict.fromkeys(map(str, value or ())))
        strangers = set(selected).difference(self._members.present())
        if strangers:
            raise rtkit.PropertyError("bad-value", f"no member: {' '.join(sorted(strangers))}")
        self._groups.pop(group, None)
        if selected:
            self._groups[group] = selected

    def _at(self, group: str) -> _Led:
        self._of(group)
        return _Led(self._members, lambda: self._of(group))

    def _of(self, group: str) -> Sequence[str]:
        present = self._members.present()
        if group == "all":
            return present
        if group not in self._groups:
            raise rtkit.PropertyError("unknown", f"no such group: {group}")
        return [each for each in self._groups[group] if each in present]


GroupInit = init_of(Group)
