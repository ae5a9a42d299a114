"""Mounts: names of a served object that are those of another owner, wherever that is.

A mount is a relay of its own behind a prefix. Requests about several owners, listings and bulk GETs
above the mounts, are put together here; the object itself answers for what is its own.

See decisions 27 and 65.
"""

from __future__ import annotations

import itertools
import uuid
from collections.abc import Callable, Sequence
from functools import partial
from time import monotonic

from rtkit.errors import Malformed
from rtkit.property.codes import PropertyError
from rtkit.property.lanes import first_only, wait_of
from rtkit.property.messages import Answer
from rtkit.property.mounting import MountPoint
from rtkit.property.naming import RequestTarget, canonical, parse_target, write_parameters
from rtkit.property.reading import read
from rtkit.property.registry import as_value
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.service import Service
from rtkit.property.user_code import UserCode
from rtkit.property.values import Element, Value
from rtkit.property.writing import write
from rtkit.proxy.addresses import source_of
from rtkit.proxy.narrowing import GUI, ROUND, describes_widgets, joined
from rtkit.proxy.prefix import Allowed, PrefixedNames
from rtkit.proxy.relay import ITSELF, MOST_HOPS, ROUTE, Relay, route_answer, route_target
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.provider_connection import Answering, ProviderConnection
from rtkit.wires.wire import WireSettings

_LISTED = "properties"
_OWN = frozenset({"meta", "parameters", "history"})
"""Extensions of the mount point itself, which its owner has no name for."""
_OF_TREE = frozenset({"rtc", "mgr"})
"""Endings of names in the tree, behind which no place begins."""
_LISTING_S = 1.0
"""How long the owners of a listing are waited for [s]."""
_SHARE = 0.8
"""How much of that those have who wait for further owners."""
_HOP_S = 0.1
"""How long a mount waits for the routes behind it, for each hop that is left [s]."""


class Mount(MountPoint):
    """Another owner at a name of a served object: ``self.robots = {"r1": Mount("robots/r1")}``.

    All below that name is that owner's: values, actions, listening, errors. While it is away names
    answer ``no-service`` and who listens is told that values are stale. Mounts come and go as the
    attributes do that hold them.

    Args:
        target: A service, or a place in one (``line.7``), a component's path, or the address of a
            service (``rtkit help wires``).
        timeout_s: Bound on each attempt to connect [s].
        has_value: The name itself is not that owner's, only what is below.

    Raises:
        Malformed: There is no target.
    """

    def __init__(self, target: str, *, timeout_s: float = 2.0, has_value: bool = False) -> None:
        if not isinstance(target, str) or not target:
            raise Malformed(f"not a service to mount: {target!r}")
        self.target = target
        self.has_value = has_value
        self.timeout_s = timeout_s
        service, _, place = target.partition(".")
        is_whole = ":" in target or target.startswith("/") or place.partition(".")[0] in _OF_TREE
        self._owner, self.place = (target, "") if is_whole else (service, place)

    def __repr__(self) -> str:
        return f"Mount({self.target!r})"

    def table_for(self, service: Service) -> Mounts:
        """See `MountPoint.table_for`."""
        return Mounts(service)

    def connect(self, host: PropertyEventLoop) -> ProviderConnection:
        """Connect to the owner, which may not have been there before.

        Raises:
            RtkitError: It is not there.
        """
        return source_of(self._owner, "/", WireSettings(host, self.timeout_s)).connect()


def mounts(**targets: str) -> dict[str, Mount]:
    """Return mounts to be served, by name: ``rtserve rtkit:mounts all -a r1=robots/r1``."""
    return {name: Mount(target) for name, target in targets.items()}


class _Mounted:
    """Mount in force: the relay, and the requests that came before it had tried to connect."""

    def __init__(
        self, host: PropertyEventLoop, service: Service, name: str, mount: Mount, id: str
    ) -> None:
        self.name = name
        self.has_value = mount.has_value
        self._waiting: list[PropertyRequest] = []
        self._is_known = False
        self.relay = Relay(
            host,
            partial(mount.connect, host),
            names=PrefixedNames(name, mount.place),
            allowed=Allowed(("*",)),
            on_status=self._known,
            id=id,
        )
        self.relay.name, self.relay.on_refusal = service.name, service.on_refusal
        self.relay.uplink.label = f"{mount.target}: "
        self.relay.uplink.start()

    def handle(self, ask: PropertyRequest) -> None:
        """Pass a request on, once it is known whether the owner is there."""
        if self._is_known:
            self.relay.handle(ask)
        else:
            self._waiting.append(ask)

    def _known(self, _why: str) -> None:
        self._is_known = True
        waiting, self._waiting = self._waiting, []
        for ask in waiting:
            self.relay.handle(ask)


class Mounts:
    """Mount points of one service."""

    def __init__(self, service: Service) -> None:
        assert isinstance(service.host, PropertyEventLoop)
        self._service = service
        self._host = service.host
        self._id = f"m{uuid.uuid4().hex[:12]}"
        self._count = itertools.count(1)
        self._mounted: dict[str, tuple[_Mounted, Callable[[], bool]]] = {}
        self._host.at_end(self._close)

    def add(self, name: str, mount: MountPoint, is_there: Callable[[], bool]) -> None:
        """See `MountTable.add`."""
        assert isinstance(mount, Mount)
        id = f"{self._id}x{next(self._count)}"
        mounted = _Mounted(self._host, self._service, name, mount, id)
        self._mounted[name] = mounted, is_there

    def remove(self, name: str) -> None:
        """See `MountTable.remove`."""
        self._mounted.pop(name)[0].relay.end()

    def tick(self) -> None:
        """See `MountTable.tick`."""
        for mounted, _ in self._mounted.values():
            mounted.relay.tick()

    def forget(self, caller: Requester) -> None:
        """See `MountTable.forget`."""
        for mounted, _ in self._mounted.values():
            mounted.relay.forget(caller)

    def takes(self, ask: PropertyRequest, *, is_again: bool = False) -> bool:
        """See `MountTable.takes`."""
        if not self._mounted:
            return False
        name = ask.target.partition("?")[0].rpartition("/")[2]
        try:
            name = canonical(name) if "%" in name else name
            mounted = self._of(name)
            if mounted is not None:
                if self._is_own(name, mounted):
                    return False
                mounted.handle(ask)
                return True
            if is_again:
                return False
            target = parse_target(ask.target)
            if target.name == ROUTE and ask.payload is None:
                self._answer_route(target, ask.answer)
                return True
            if describes_widgets(target.name) and ask.payload is None:
                return self._takes_widgets(target.name, ask)
            return self._takes_listing(target, ask)
        except PropertyError as error:
            ask.answer(Answer(str(error), error.code))
            return True

    def _of(self, name: str) -> _Mounted | None:
        """Return what is mounted at a name, or above it."""
        at = name
        while at:
            if at in self._mounted:
                return self._mounted[at][0]
            at = at.rpartition(".")[0]
        return None

    def _is_own(self, name: str, mounted: _Mounted) -> bool:
        """Return whether the object answers: for the mount point, or because it is gone."""
        rest = name[len(mounted.name) + 1 :]
        first = rest.partition(".")[0]
        is_itself = first in _OWN or (mounted.has_value and first in ("", GUI))
        return is_itself or not self._mounted[mounted.name][1]()

    # Several owners at once

    def _is_among(self, ids: Sequence[str]) -> bool:
        """Return whether a mount of this service is among those that passed something on."""
        return any(each.startswith(self._id) for each in ids)

    def _check_once(self, ask: PropertyRequest) -> None:
        """Refuse to put together again what is being put together here."""
        if self._is_among(ask.via):
            raise PropertyError("no-service", ITSELF)

    def _takes_widgets(self, name: str, ask: PropertyRequest) -> bool:
        """Ask for the widgets of the object and of all owners below, but where a value stands."""
        self._check_once(ask)
        place = name.removesuffix(GUI)
        below = [each for at, (each, _) in self._mounted.items()
                 if at.startswith(place) and not each.has_value]  # fmt: skip
        gathered: dict[str, Answer] = {}

        def take(owner: str, reply: Answer) -> None:
            gathered[owner] = reply
            if len(gathered) > len(below):
                own = gathered.pop("")
                texts = {at: _widgets_in(each) for at, each in gathered.items()}
                ask.answer(own if own.error else Answer(joined(str(own.payload), texts)))

        until = min(wait_of(ask, monotonic()) or _LISTING_S, _LISTING_S)
        for each in below:
            answer = _bounded(self._host.user_code, until, partial(take, each.name))
            each.handle(ask._replace(target=f"{each.name}.{GUI}", answer=answer))
        if below:
            self._service.handle_own(ask._replace(answer=partial(take, "")))
        return bool(below)

    def _takes_listing(self, target: RequestTarget, ask: PropertyRequest) -> bool:
        name = target.name
        if name != _LISTED and not name.endswith(f".{_LISTED}"):
            return False
        place = name[: -len(_LISTED)]
        below = [each for at, (each, _) in self._mounted.items() if at.startswith(place)]
        if not below or not (target.parameters or ask.payload is not None):
            return False
        if ask.payload is not None:
            return self._takes_bulk(place, ask)
        self._check_once(ask)
        wanted: list[str] | None = None
        groups: dict[_Mounted | None, list[str]] = {each: [] for each in (None, *below)}
        if "names" in target.parameters:
            wanted = [canonical(str(each)) for each in _group(target.parameters["names"] or "")]
            groups = {}
            for each in wanted:
                groups.setdefault(self._of(place + each), []).append(each)
        gathered: dict[_Mounted | None, Answer] = {}

        def take(owner: _Mounted | None, reply: Answer) -> None:
            gathered[owner] = reply
            if len(gathered) == len(groups):
                ordered = {each: gathered[each] for each in groups}
                ask.answer(_joined(place, ordered, wanted, target))

        until = min(wait_of(ask, monotonic()) or _LISTING_S, _LISTING_S)
        for owner, names in groups.items():
            given = dict(target.parameters)
            if wanted is not None:
                given["names"] = write(tuple(map(as_value, names)))
            if owner is not None:  # who answers for others, too, does so before this gives up
                given["timeout"] = f"{until * _SHARE:.3f}"
            asked = ask._replace(target=f"{name}?{write_parameters(given)}")
            if owner is None:
                self._service.handle_own(asked._replace(answer=partial(take, None)))
            else:
                answer = _bounded(self._host.user_code, until, partial(take, owner))
                owner.handle(asked._replace(answer=answer))
        return True

    def _takes_bulk(self, place: str, ask: PropertyRequest) -> bool:
        """Pass a SET of several properties on, if all are those of one owner."""
        pairs = [each for each in _group(str(ask.payload)) if isinstance(each, tuple) and each]
        owners = {self._of(place + canonical(str(each[0]))) for each in pairs}
        if owners <= {None}:
            return False
        owner = owners.pop()
        if owners or owner is None:
            raise PropertyError("bad-value", "several owners cannot be set all or none")
        cut = len(owner.name) + 1 - len(place)
        inner = tuple((as_value(canonical(str(each[0]))[cut:]), *each[1:]) for each in pairs)
        owner.handle(ask._replace(target=f"{owner.name}.{_LISTED}", payload=write(inner)))
        return True

    def _answer_route(self, target: RequestTarget, answer: Answering) -> None:
        """Tell which services lie behind, so that no proxy of them leads back to itself."""
        hops, seen = route_target(target)
        if self._is_among(seen):
            answer(Answer(f"({self._id})"))
            return
        found: list[Answer] = []

        def take(reply: Answer) -> None:
            found.append(reply)
            if len(found) == len(self._mounted):
                answer(route_answer(self._id, found))

        bound_s = _HOP_S * (MOST_HOPS + 1 - hops)
        for mounted, _ in self._mounted.values():
            mounted.relay.ask_route(hops, seen, _bounded(self._host.user_code, bound_s, take))

    def _close(self) -> None:
        with self._host.lock:
            for mounted, _ in self._mounted.values():
                mounted.relay.uplink.close()


def _bounded(user_code: UserCode, wait_s: float, answer: Answering) -> Answering:
    """Return what passes on the first reply; ``timeout`` if none has come by then."""
    first = first_only(answer)
    in_time = user_code.refuse_after(wait_s, first)

    def answered(reply: Answer) -> None:
        in_time()
        first(reply)

    return answered


def _joined(
    place: str,
    gathered: dict[_Mounted | None, Answer],  # the object first
    wanted: list[str] | None,
    target: RequestTarget,
) -> Answer:
    """Return one listing of what several owners have; one that fails is named with its error."""
    entries: dict[str, Value] = {}
    for owner, reply in gathered.items():
        name = "" if owner is None else owner.name[len(place) :]
        if name and "values" in target.parameters:
            entries.pop(name, None)  # the mount point itself has no value
        if reply.error:
            if owner is None or wanted is not None:
                return reply
            if "values" in target.parameters:
                error = Element("error", {"code": reply.error}, (), str(reply.payload))
                entries[name] = (as_value(name), error)
            continue
        for item in _group(str(reply.payload)):
            head = item[0] if isinstance(item, tuple) and item else item
            entries.setdefault(str(head), item)
    chosen = entries.values() if wanted is None else [entries[each] for each in wanted]
    return Answer(write(tuple(chosen)))


def _widgets_in(reply: Answer) -> str:
    """Return the widgets of an owner; ``ROUND`` where it is one that has asked for them."""
    if reply.error:
        return ROUND if reply.payload == ITSELF else ""
    return str(reply.payload)


def _group(text: str) -> tuple[Value, ...]:
    value = read(text)
    if not isinstance(value, tuple):
        raise PropertyError("bad-value", "expected a list")
    return value
