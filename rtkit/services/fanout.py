"""Fan-out to the members of a group: one request for each at once, and what they answer as one."""

from __future__ import annotations

import math
import operator
import re
import threading
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from secrets import token_hex
from time import monotonic
from typing import Any, NamedTuple

import rtkit
from rtkit.services.asking import pose_in_world
from rtkit.services.frames import Frames, Pose, is_number, plain, pose_of

_OWN = {"robots", "groups", "join", "leave", "failures", "deadline", "name", "type", "version",
        "status", "properties"}  # fmt: skip
"""First parts of the names of a group itself."""
_NAMES = ("location", "velocity", "behaviors.moveto", "behaviors.stop")
"""Names that a group has also while no member has told its own."""
_AGAIN_S = 5.0
"""How long until members are asked again for their names [s]."""
_WAITED_S = 0.2
"""How long names of members are waited for [s]."""
_SHARE = 0.8
"""How much of its time a group leaves to a group in it."""
_TOLD = {"type", "access", "unit", "min", "max", "step", "choices", "doc", "functional"}
_ESCAPED = str.maketrans({'"': '\\"', "\\": "\\\\", "\n": "\\n", "\r": "\\r", "\t": "\\t"})
_LATE = frozenset({"no-service", "timeout"})
_STATES = ("running", "failed", "stopped", "done", "idle")


def is_own(name: str) -> bool:
    """Return whether a name is one that a group does not take from its members."""
    return name.partition(".")[0] in _OWN


class MemberFailure(NamedTuple):
    """Failure of a member to do what all were to do."""

    name: str
    code: str
    text: str


class Members:
    """Members of a group, each a service.

    Args:
        deadline: How long they may take for an answer [s].

    Attributes:
        failures: Of what was set last.
    """

    def __init__(self, deadline: float) -> None:
        if not 0 < deadline < math.inf:
            raise rtkit.PropertyError("bad-value", f"the deadline is above 0 s: {deadline}")
        self.deadline = deadline
        self.failures: Sequence[MemberFailure] = ()
        self._targets: dict[str, str] = {}
        self._known: dict[str, tuple[str, ...]] = {}
        self._asked_at: dict[str, float] = {}
        self._is_group: dict[str, bool] = {}
        self._names: tuple[str, ...] = _NAMES
        self._lock = threading.Lock()
        self._client: rtkit.Client | None = None
        self._id = token_hex(6)

    def begin(self) -> None:
        """Connect to members when they are asked."""
        self._client = rtkit.Client()

    def end(self) -> None:
        """End the connections."""
        if self._client is not None:
            self._client.close()

    def present(self) -> list[str]:
        """Return the names of the members."""
        with self._lock:
            return list(self._targets)

    def add(self, robot: str) -> tuple[str, str]:
        """Add ``SERVICE`` or ``NAME=SERVICE``; return name and service.

        Before the group is served, a service may be named that is there later.

        Raises:
            PropertyError: ``bad-value``: it is neither; ``conflict``: another one has that name;
                ``no-service``: there is no such service.
        """
        name, mark, target = robot.rpartition("=")
        name = name if mark else target.rpartition("/")[2].rpartition(".")[2]
        if not target or not name.replace("_", "a").replace("-", "a").isalnum():
            raise rtkit.PropertyError("bad-value", f"expected SERVICE or NAME=SERVICE: {robot}")
        if self._client is not None and name not in self._targets:
            (answer,) = self._client.ask_all([rtkit.Ask(f"{target}.type")], self.deadline)
            if isinstance(answer, rtkit.PropertyError) and answer.code == "no-service":
                raise rtkit.PropertyError(answer.code, str(answer).partition(": no-service: ")[2])
        with self._lock:
            if self._targets.setdefault(name, target) != target:
                raise rtkit.PropertyError("conflict", f"{name} is {self._targets[name]} already")
        return name, target

    def remove(self, name: str) -> None:
        """Remove a member.

        Raises:
            PropertyError: ``unknown``: there is none.
        """
        with self._lock:
            if self._targets.pop(name, None) is None:
                raise rtkit.PropertyError("unknown", f"no member: {name}")
            self._known.pop(name, None)
            self._asked_at.pop(name, None)
            self._is_group.pop(name, None)
            self._rename()

    def names(self) -> Collection[str]:
        """Return the names that members have, as far as they are known.

        Members are asked from time to time; who is slow to tell delays nobody.
        """
        if self._client is not None and (due := self._due(monotonic())):
            learning = threading.Thread(target=self._learn, args=(due,), daemon=True)
            learning.start()
            learning.join(_WAITED_S)
        return self._names

    def _due(self, now: float) -> list[str]:
        """Return the members to be asked for their names: new ones, and one that was before."""
        with self._lock:
            past = now - _AGAIN_S
            old = [each for each in self._targets if self._asked_at.get(each, -_AGAIN_S) <= past]
            new = [each for each in old if each not in self._known]
            due = new or old[:1]
            self._asked_at |= dict.fromkeys(due, now)
        return due

    def _learn(self, due: Sequence[str]) -> None:
        with suppress(rtkit.PropertyError):  # the group has ended
            given: Mapping[str, tuple[Any, ...]] = dict.fromkeys(due, ())
            values, failures = self._ask(given, "properties", {"all": 1}, _AGAIN_S)
            small = {each.name: () for each in failures if each.code == "bad-parameter"}
            values |= self._ask(small, "properties", {}, _AGAIN_S)[0]
            with self._lock:
                for each in self._targets.keys() & values.keys():
                    names = map(str, values[each])
                    self._known[each] = tuple(name for name in names if not is_own(name))
                self._rename()

    def _rename(self) -> None:
        names = tuple(dict.fromkeys((*_NAMES, *(n for own in self._known.values() for n in own))))
        self._names = self._names if names == self._names else names

    def about(self, name: str) -> dict[str, Any]:
        """Return what a member tells of a property: type, access, unit and more; none if none."""
        until = monotonic() + self.deadline
        for each in list(self._known):
            meta = self.get([each], f"{name}.meta", {}, (until - monotonic()) / 2)[0].get(each)
            if isinstance(meta, rtkit.Element):
                return {each.name: each.leaf for each in meta.children if each.name in _TOLD}
        return {}

    def pose_of(self, service: str) -> Sequence[float]:
        """Return the pose in the world of any service, whose name is the name of a frame."""
        return pose_in_world(self._get_one, service)

    def _get_one(self, target: str, **parameters: Any) -> Any:
        assert self._client is not None
        asks = [rtkit.Ask(target, parameters=parameters)]
        (found,) = self._client.ask_all(asks, self.deadline / 2)
        if isinstance(found, rtkit.PropertyError):
            raise found
        return found

    def get(
        self,
        selected: Sequence[str],
        name: str,
        parameters: Mapping[str, Any],
        bound_s: float = math.inf,
    ) -> tuple[dict[str, Any], list[MemberFailure]]:
        """Get a property of some members at once, by the deadline or sooner [s]."""
        nothing: dict[str, tuple[Any, ...]] = dict.fromkeys(selected, ())
        return self._ask(nothing, name, parameters, min(bound_s, self.deadline))

    def set(
        self,
        values: Mapping[str, Any],
        name: str,
        parameters: Mapping[str, Any],
        bound_s: float,
    ) -> tuple[Collection[str], list[MemberFailure]]:
        """Set a property of some members at once, each to its value, in so long [s].

        Returns:
            Those that did it, and those that failed.
        """
        sent = {each: (_sent(value),) for each, value in values.items()}
        return self._ask(sent, name, parameters, round(max(0.0, bound_s), 3))

    def _ask(
        self,
        values: Mapping[str, tuple[Any, ...]],
        name: str,
        parameters: Mapping[str, Any],
        bound_s: float,
    ) -> tuple[dict[str, Any], list[MemberFailure]]:
        """Make a request of each member, with the value to set, if there is one.

        A group that waits for this answer, as one that holds this one does, is left out.
        """
        if self._client is None:
            raise rtkit.PropertyError("no-service", "the group is not served yet")
        until = monotonic() + bound_s
        if new := values.keys() - self._is_group.keys():
            self._find_groups(new, min(_WAITED_S, bound_s / 2))
            bound_s = max(0.0, round(until - monotonic(), 3))
        ask, error, targets, kinds = rtkit.Ask, rtkit.PropertyError, self._targets, self._is_group
        of_group = {**parameters, "timeout": round(bound_s * _SHARE, 3)}
        asks = [
            ask(  # type: ignore[misc]  # there is one value, or none
                f"{targets.get(each, each)}.{name}",
                *value,
                parameters=of_group if kinds.get(each) else parameters,
                in_turn=self._id if kinds.get(each) else "",
            )
            for each, value in values.items()
        ]
        answers = dict(zip(values, self._client.ask_all(asks, bound_s), strict=True))
        failures = [
            MemberFailure(each, answer.code, _why(answer))
            for each, answer in answers.items()
            if isinstance(answer, error)
        ]
        left_out = (error, type(None))
        found = {name: each for name, each in answers.items() if not isinstance(each, left_out)}
        return found, failures

    def _find_groups(self, new: Collection[str], bound_s: float) -> None:
        """Find out which members are groups; of one that does not tell by then, another time."""
        assert self._client is not None
        asks = [rtkit.Ask(f"{self._targets.get(each, each)}.type") for each in new]
        for each, type in zip(new, self._client.ask_all(asks, bound_s), strict=True):
            is_error = isinstance(type, rtkit.PropertyError)
            if not is_error or type.code not in _LATE:
                self._is_group[each] = isinstance(type, tuple) and "group" in type


def _why(error: rtkit.PropertyError) -> str:
    """Return the text of an error without what it begins with, and without what else there is."""
    return re.sub(r" \(there (is|are) .*", "", str(error).partition(f": {error.code}: ")[2])


def _sent(value: Any) -> Any:
    """Return a value as requests take it: a text that is no word in quotes."""
    is_text = isinstance(value, str) and not isinstance(value, rtkit.Word)
    return f'"{value.translate(_ESCAPED)}"' if is_text else value


def error_of(failures: Sequence[MemberFailure], count: int) -> rtkit.PropertyError:
    """Return the error that names all who failed, of so many; if none did, none was asked.

    Its code is that of all who answered; of who did not only where nobody did.
    """
    if not failures:
        waiting = f"{rtkit.PropertyError.CAME_BACK} all members, which wait for the answer"
        return rtkit.PropertyError("conflict", waiting if count else "there are no members")
    codes = {each.code for each in failures}
    code, *others = (codes - _LATE) or codes
    alike: dict[str, list[str]] = {}
    for each in failures:
        alike.setdefault(f"{each.code}: {each.text}", []).append(each.name)
    whys = "; ".join(f"{' '.join(names)}: {why}" for why, names in alike.items())
    text = f"{len(failures)} of {count} failed: {whys}"
    return rtkit.PropertyError("conflict" if others else code, text)


# Answers


def middle_of(poses: Iterable[Sequence[float]]) -> Pose:
    """Return the middle of poses: the mean place, and the mean direction of each angle [m, rad]."""
    columns = list(zip(*map(pose_of, poses), strict=True))
    place = [math.fsum(column) / len(column) for column in columns[:3]]
    turn = [
        math.atan2(math.fsum(map(math.sin, column)), math.fsum(map(math.cos, column)))
        for column in columns[3:]
    ]
    return (*place, *turn)


def combined(values: Mapping[str, Any], failures: Sequence[MemberFailure], name: str = "") -> Any:
    """Return what stands for all answers: the mean of numbers, what is the same, or a list.

    Of locations see `middle_of`, of behaviours `state_of`.
    """
    answers = list(values.values())
    first = answers[0]
    if isinstance(first, rtkit.Element) and "state" in first.attributes:
        return state_of(values, failures)
    if all(each == first for each in answers):
        return first
    rows = [each if isinstance(each, tuple) else (each,) for each in answers]
    if not all(len(row) == len(rows[0]) and all(map(is_number, row)) for row in rows):
        return tuple((rtkit.Word(name), each) for name, each in values.items())
    if name == "location":
        return middle_of(rows)
    mean = tuple(math.fsum(column) / len(rows) for column in zip(*rows, strict=True))
    return mean if isinstance(first, tuple) else mean[0]


def state_of(values: Mapping[str, Any], failures: Sequence[MemberFailure]) -> rtkit.Element:
    """Return how a behaviour of all stands.

    It runs while one runs; then what is worst holds. Its target is that of the middle, see
    `formation`. The child ``others`` names who stands otherwise, and who did not answer, with the
    code.
    """
    states = {
        name: each.attributes.get("state", "idle") if isinstance(each, rtkit.Element) else "idle"
        for name, each in values.items()
    }
    state = min(states.values(), key=lambda each: (*_STATES, each).index(each))
    one = next(values[name] for name, each in states.items() if each == state)
    others = [pair for pair in states.items() if pair[1] != state]
    others += [(each.name, each.code) for each in failures]
    pairs = tuple((rtkit.Word(name), rtkit.Word(each)) for name, each in others)
    more = (rtkit.Element("others", {}, (), pairs),) if pairs else ()
    middle = _middle_target(list(values.values()))
    children = (middle if middle and each.name == "target" else each for each in one.children)
    return rtkit.Element(one.name, {"state": state}, (*children, *more))


def _middle_target(behaviors: Sequence[Any]) -> rtkit.Element | None:
    """Return the target in the middle of those of all, None unless each has a place in the world.

    The middle of a formation goes to the target that was set.
    """
    targets = [each.find("target") for each in behaviors if isinstance(each, rtkit.Element)]
    found = [each for each in targets if each and str(_field(each, "frame")) == "world"]
    places = [each for each in map(_location, found) if each]
    if len(places) < len(behaviors) or len({len(each) for each in places}) != 1:
        return None
    place = plain(middle_of(places)[: len(places[0])])
    first = found[0]
    children = (
        rtkit.Element("location", each.attributes, (), place) if each.name == "location" else each
        for each in first.children
    )
    return rtkit.Element("target", first.attributes, tuple(children), first.leaf)


def _field(target: rtkit.Element, name: str) -> Any:
    child = target.find(name)
    return None if child is None else child.leaf


def _location(target: rtkit.Element) -> tuple[float, ...]:
    place = _field(target, "location")
    if not (isinstance(place, tuple) and len(place) in (2, 3, 6) and all(map(is_number, place))):
        return ()
    return place if all(map(math.isfinite, place)) else ()


# Formations


def markers_in(value: Any) -> list[rtkit.Marker]:
    """Return the markers with a location that a value is, one or a list; else none."""
    found = []
    for each in value if isinstance(value, list | tuple) else (value,):
        if isinstance(each, rtkit.Element) and each.name == "marker":
            each = rtkit.Marker.from_element(each)
        if not isinstance(each, rtkit.Marker) or not each.location:
            return []
        found.append(each)
    return found


def formation(
    markers: Sequence[rtkit.Marker], poses: Mapping[str, Pose], frames: Frames
) -> dict[str, list[rtkit.Marker]]:
    """Return the way of each member: that of the middle, with its present offset from there.

    Args:
        markers: The way; without a frame they are seen from the middle, as from a robot's base.
        poses: Where the members are in the world [m, rad].
        frames: Tells other frames.
    """
    middle = middle_of(poses.values())
    frames.add("middle of the group", middle)
    ways: dict[str, list[rtkit.Marker]] = {name: [] for name in poses}
    for marker in markers:
        base = marker.frame in ("", "base")
        frame = "middle of the group" if base else marker.frame
        place = frames.convert(marker.location or (), frame, "world")
        for name, pose in poses.items():
            offset = (own - mean for own, mean in zip(pose[:3], middle, strict=False))
            moved = (*map(operator.add, place, offset), *place[3:])
            ways[name].append(marker.with_(location=moved, frame="world"))
    return ways
