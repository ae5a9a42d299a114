"""Resource service: which services there are, where they can be reached, and which of them fit.

Each registered service is a property, ``robots.r1`` for the service ``robots/r1``. Those of this
host, and of hosts that are linked from here (``robot1.robots.r1``), are found by their presence, so
none needs to know of the registry; others register themselves by a SET. All are asked for a sign of
life once a period.
"""

from __future__ import annotations

import fnmatch
import math
import re
import shlex
import threading
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from time import monotonic
from typing import Annotated, Any, Final, Literal, NamedTuple, Self

import rtkit
from rtkit import Ask, Element, Names, PropertyError, Range, Unit, Word, init_of
from rtkit.services.conditions import conditions, near_to
from rtkit.services.frames import is_number
from rtkit.services.left import LeftProcess, left_at
from rtkit.services.paths import RESERVED
from rtkit.services.started import StartedProcess

_OWN = frozenset(["search", "start", "started", "frames", "unanswered", "name", "type", "status"])
_ADDRESS = {
    "tcp": "tcp:{0}/{1}/", "tcps": "tcps:{0}/{1}/", "http": "http://{0}/ps/{1}/",
    "https": "https://{0}/ps/{1}/", "unix": "{0}.", "zenoh": "zenoh:{0}.",
}  # fmt: skip
_HOST_AND_PORT = re.compile(r"(?:\[[^\s\]]+\]|[^\s:/?#\[\]]+):([0-9]{1,5})")
_SERVICE = re.compile(r"/?[\w~%+-]+(?:/[\w~%+-]+)*", re.ASCII)
_ALIVE = frozenset({"unknown", "denied", "write-only", "internal", "busy", "bad-value"})
"""Errors that only who lives can answer."""
_LONGEST_LEASE_S = 3600.0
_LONGEST_SEARCH_S = 10.0
_STARTING_S = 10.0
_LOOK_S = 0.1
_GONE = Element("service")
_Unanswered = list[tuple[str, str]]
_Search = tuple[list[str], _Unanswered]
"""Names of services that fit, and of those that failed, with the codes of their errors."""


class Entry(NamedTuple):
    """Service that is registered.

    Attributes:
        service: Its name.
        types: Words for its kind.
        contacts: Protocol and address of each of its endpoints that is known.
        ends_at: When its lease is over [s, monotonic].
        misses: How many times in a row it has not answered; twice as many if nobody was there.
    """

    service: str
    types: tuple[str, ...]
    contacts: tuple[tuple[str, str], ...]
    ends_at: float = math.inf
    misses: int = 0

    def at(self, name: str) -> str:
        """Return the target of one of its properties."""
        protocol, address = self.contacts[0]
        return _ADDRESS[protocol].format(address, self.service) + name

    @property
    def element(self) -> Element:
        """Element that describes it."""
        contacts = (Element("contact", {"protocol": key}, (), text) for key, text in self.contacts)
        return Element("service", {"type": " ".join(self.types)}, tuple(contacts))


class NamedFrames(Names):
    """Named frames: poses in the world, ``frames.kitchen`` [m, rad]."""

    def __init__(self, poses: dict[str, tuple[float, ...]]) -> None:
        self._poses = poses

    def names(self) -> Collection[str]:
        """Return their names."""
        return self._poses

    def get(self, name: str) -> tuple[float, ...]:
        """Return a pose."""
        return self._poses[name]

    def set(self, name: str, value: tuple[float, ...]) -> None:
        """Put a frame somewhere, or make one: 6 numbers."""
        if not isinstance(value, tuple) or len(value) != 6 or not all(map(_is_finite, value)):
            raise PropertyError("bad-value", "expected x y z a b c [m, rad]")
        self._poses = {**self._poses, name: tuple(map(float, value))}


class Resource(Names):
    """Knows which services there are, finds those that fit, and starts some.

    Args:
        watch: Pattern of the names of services that are registered by themselves.
        hosts: Pattern of the names of hosts that are linked from here whose services are, too.
        period: How often each service is asked for a sign of life [s].
        misses: After so many periods without one a service is gone; one in which its connection
            was refused counts twice.
        route: Requests about ``NAME.PROPERTY`` are passed on to that service.
        starts: Services to start: ``KIND COMMAND ARGUMENT...``; a kind is a word of a type.
        left: Fate of services that a resource service of this name had started, and left when it
            was killed: ``adopt`` takes them for started here, ``end`` ends them.
        frames: Named frames, ``NAME x y z a b c`` [m, rad].
    """

    type: Final = ("resource",)
    version: Final = "1.0"
    frames: Final[NamedFrames]

    def __init__(
        self,
        *,
        watch: str = "*",
        hosts: str = "*",
        period: Annotated[float, Range(0.05, 60), Unit("s")] = 1.0,
        misses: Annotated[int, Range(1, 100)] = 3,
        route: bool = False,
        starts: tuple[str, ...] = (),
        left: Literal["adopt", "end"] = "adopt",
        frames: tuple[str, ...] = (),
    ) -> None:
        self.frames = NamedFrames(dict(map(_frame, frames)))
        self._unanswered: list[tuple[str, str]] = []
        self._watch, self._period, self._misses, self._route = watch, period, misses, route
        self._hosts, self._linked = hosts, list[str]()
        self._commands = {words[0]: words[1:] for words in map(shlex.split, starts) if words[1:]}
        self._left, self._socket = left, ""
        self._processes: list[StartedProcess | LeftProcess] = []
        self._entries: dict[str, Entry] = {}
        self._names: tuple[str, ...] = ()
        self._lock, self._starting = threading.RLock(), threading.Lock()
        self._is_over, self._has_looked = threading.Event(), threading.Event()
        self._client = rtkit.Client()
        self._trouble = ""

    def __served__(self, publish: Any) -> None:
        self._socket = publish.socket

    def __enter__(self) -> Self:
        self._is_over.clear()
        if self._socket:  # at which no other lives
            self._processes = [*left_at(self._socket)]
        if self._left == "end":
            self._end_all()
        self._client = rtkit.Client()
        self._probing = threading.Thread(target=self._watching, name="probing", daemon=True)
        self._probing.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._is_over.set()
        self._end_all()
        self._client.close()
        self._probing.join(self._period)

    @property
    def status(self) -> str:
        """``ready``, or ``failed`` with the reason."""
        return f"failed: {self._trouble}" if self._trouble else "ready"

    @property
    def unanswered(self) -> list[tuple[str, str]]:
        """Hosts and services that did not answer the last search, with the codes of the errors."""
        return self._unanswered

    # Registry

    def names(self) -> Collection[str]:
        """Return the names of the registered services."""
        return self._names

    def get(self, name: str) -> Element:
        """Return a service: its type, and how it is reached."""
        entry = self._entries.get(name)
        if entry is None:
            raise PropertyError("unknown", f"no such property: {name}")
        return entry.element

    def set(self, name: str, value: Element, lease: float = 30.0, remove: bool = False) -> None:
        """Register a service until its lease is over [s], or again; 0 is for no lease."""
        if remove:
            self._put({each: entry for each, entry in self._entries.items() if each != name})
            return
        if not 0 <= lease <= _LONGEST_LEASE_S:
            raise PropertyError("bad-parameter", f"lease: 0 to {_LONGEST_LEASE_S:g} s")
        entry = _entry(name.replace(".", "/"), value)
        ends_at = monotonic() + lease if lease else math.inf
        with self._lock:
            self._put({**self._entries, name: entry._replace(ends_at=ends_at)})

    def mount(self, name: str) -> rtkit.Mount | None:
        """Return what stands below the name of a service, where requests are passed on."""
        entry = self._entries.get(name)  # which may have gone since its name was listed
        return rtkit.Mount(entry.at("")[:-1], has_value=True) if entry and self._route else None

    def _put(self, entries: dict[str, Entry]) -> None:
        with self._lock:
            self._entries = dict(sorted(entries.items()))  # whoever was found first
            if entries.keys() != dict.fromkeys(self._names).keys():
                self._names = tuple(self._entries)

    # Signs of life

    def _watching(self) -> None:
        due = monotonic()
        while not self._is_over.wait(max(0.0, due - monotonic())):
            due = max(due + self._period, monotonic())
            try:
                self._probe()
            except PropertyError as error:  # the host cannot be asked now; it is once more, soon
                self._trouble = str(error)
            else:
                self._trouble = ""

    def _probe(self) -> None:
        """Ask all that are registered, and all that are here, for a sign of life."""
        registered = self._entries
        known = dict(registered)
        for entry in (*self._here(), *self._there()):
            known.setdefault(_property_of(entry.service), entry)
        asks = [Ask(each.at("type")) for each in known.values()]
        answers = self._client.ask_all(asks, 0.8 * self._period)
        seen = {
            name: _seen(entry, answer)
            for (name, entry), answer in zip(known.items(), answers, strict=True)
        }
        with self._lock:
            now = monotonic()
            entries = {n: each for n, each in self._entries.items() if n not in seen}
            for name, entry in seen.items():
                present = self._entries.get(name)
                if present is not registered.get(name):  # registered or removed meanwhile
                    entries |= {name: present} if present is not None else {}
                elif entry.misses < (self._misses if present else 1) and entry.ends_at > now:
                    entries[name] = entry
            self._put(entries)
        self._has_looked.set()

    def _here(self) -> list[Entry]:
        names = fnmatch.filter(self._client.get("localhost.services"), self._watch)
        return [Entry(each, (), (("unix", Word(each)),)) for each in names]

    def _there(self) -> list[Entry]:
        """Return what is at present on the hosts that are linked from here."""
        linked = fnmatch.filter(self._client.get("localhost.hosts"), self._hosts)
        asks = [Ask(f"/{host}.services") for host in linked]
        answers = self._client.ask_all(asks, 0.2 * self._period) if asks else []
        self._linked = linked
        names = [
            f"/{host}/{each}"
            for host, answer in zip(linked, answers, strict=True)
            if not isinstance(answer, PropertyError)
            for each in fnmatch.filter(answer, self._watch)
        ]
        return [Entry(each, (), (("zenoh", Word(each)),)) for each in names]

    # Search

    def get_search(
        self,
        type: str = "",
        near: tuple[float, ...] = (),
        where: str = "",
        within: float = 0.8,
        start: bool = False,
        failed: bool = False,
    ) -> Annotated[list[Word | Element], rtkit.Concurrent()]:
        """Return the names of the services that fit now.

        ``type`` is a word of their types; ``near`` is ``(x y r)`` or ``(x y z r)`` in the world
        [m]; ``where`` is ``PROPERTY OP VALUE``, several joined by ``and``. All are asked at once,
        and waited for at most ``within`` seconds: those that fail are in ``unanswered``, and with
        ``failed=1`` behind the names. With ``start=1`` one of the type is started if none fits;
        ``unknown``: that did not fit either, and was stopped again.
        """
        if not 0 <= within <= _LONGEST_SEARCH_S:
            raise PropertyError("bad-parameter", f"within: 0 to {_LONGEST_SEARCH_S:g} s")
        until = monotonic() + within
        self._has_looked.wait(min(self._period, within / 2))
        found, unanswered = self._found(type, near, where, until - monotonic())
        if start and not found:
            look = lambda: self._found(type, near, where, within)  # noqa: E731
            found, unanswered = self._found_by_start(type, look, within)
        self._unanswered = unanswered
        errors = [Element("failed", {"code": code}, (), Word(name)) for name, code in unanswered]
        return [*map(Word, found), *(errors if failed else ())]

    def _found(self, type_word: str, near: Sequence[float], where: str, within: float) -> _Search:
        wanted = conditions(where) + ([near_to(near)] if near else [])
        entries = [
            each for each in self._entries.values() if not type_word or type_word in each.types
        ]
        asks = [Ask(f"/{host}.services") for host in self._linked]
        asks += [Ask(entry.at(each.name)) for entry in entries for each in wanted]
        answers = iter(self._client.ask_all(asks, within, is_shared=True) if asks else ())
        silent = _codes(zip(self._linked, answers, strict=False))
        found, unanswered = [], []
        for entry in entries:
            values = [next(answers) for _ in wanted]
            errors = [each.code for each in values if isinstance(each, PropertyError)]
            if errors:
                if set(errors) != {"unknown"}:  # what has no such property does not fit
                    unanswered.append((entry.service, errors[0]))
            elif all(each.holds(value) for each, value in zip(wanted, values, strict=True)):
                found.append(entry.service)
        return found, [*_silent_hosts(silent, entries, unanswered), *unanswered]

    # Starting

    def start(self, kind: Annotated[str, rtkit.Choices("_commands", code="denied")]) -> str:
        """Start a service of a kind that may be started; return its name once it has registered."""
        with self._starting:
            return self._start(kind)[1]

    def _start(self, kind: str) -> tuple[StartedProcess, str]:
        if kind not in self._commands:
            known = " ".join(self._commands) or "nothing"
            raise PropertyError("denied", f"not to be started here: {kind} ({known} is)")
        before = self._of_type(kind)
        try:
            process = StartedProcess(kind, self._commands[kind], self._socket)
        except OSError as error:
            raise PropertyError("internal", f"{kind} cannot be started: {error}") from error
        self._processes = [*(each for each in self._processes if each.is_running), process]
        try:
            return process, self._registered(process, before)
        except BaseException:
            self._end(process)
            raise

    def _registered(self, process: StartedProcess, before: frozenset[str]) -> str:
        end = monotonic() + _STARTING_S
        while not (new := self._of_type(process.kind) - before):
            if not process.is_running:
                raise PropertyError("internal", f"{process.kind} ended with {process.outcome}")
            if monotonic() > end:
                raise PropertyError("timeout", f"{process.kind} does not register")
            self._is_over.wait(_LOOK_S)
            self._probe()
        return min(new)

    def _found_by_start(self, kind: str, look: Callable[[], _Search], within: float) -> _Search:
        """Start one of a kind, and search again until it fits; stop it if it does not in time."""
        with self._starting:
            if (outcome := look())[0]:
                return outcome  # which somebody else has started meanwhile
            if kind in self.started:
                raise PropertyError("unknown", f"none fits: {kind} was started, and runs")
            process, name = self._start(kind)
            until = monotonic() + within
            while not (outcome := look())[0]:
                if monotonic() > until:
                    self._end(process)
                    self.set(_property_of(name), _GONE, remove=True)
                    text = f"none fits: {name} was started, does not, and was stopped again"
                    raise PropertyError("unknown", text)
                self._is_over.wait(_LOOK_S)
        return outcome

    def _end_all(self) -> None:
        for process in self._processes:
            process.stop()
        for process in self._processes:
            self._end(process)

    def _end(self, process: StartedProcess | LeftProcess) -> None:
        process.end()
        self._processes = [each for each in self._processes if each is not process]

    @property
    def started(self) -> list[str]:
        """Kinds that were started here and still run."""
        return [each.kind for each in self._processes if each.is_running]

    def _of_type(self, kind: str) -> frozenset[str]:
        return frozenset(each.service for each in self._entries.values() if kind in each.types)


def _seen(entry: Entry, answer: Any) -> Entry:
    """Return an entry after it was asked for its type."""
    if isinstance(answer, tuple):
        return entry._replace(misses=0, types=tuple(map(str, answer)))
    if not isinstance(answer, PropertyError) or answer.code in _ALIVE:
        return entry._replace(misses=0)
    # Nobody is there, which is more than that nobody has answered yet.
    return entry._replace(misses=entry.misses + (2 if answer.code == "no-service" else 1))


def _codes(answers: Iterable[tuple[str, Any]]) -> dict[str, str]:
    return {name: each.code for name, each in answers if isinstance(each, PropertyError)}


def _silent_hosts(
    cut_off: Mapping[str, str], entries: Sequence[Entry], unanswered: _Unanswered
) -> _Unanswered:
    """Return the hosts that cannot be reached, or none of whose services has answered."""
    codes: dict[str, list[str]] = {}
    known = dict(unanswered)
    for entry in entries:
        if entry.service.startswith("/"):
            code = known.get(entry.service, "")
            codes.setdefault(entry.service.split("/")[1], []).append(code)
    silent = {host: each[0] for host, each in codes.items() if {*each} <= {"no-service", "timeout"}}
    return [(f"/{host}", code) for host, code in {**silent, **cut_off}.items()]


def _property_of(service: str) -> str:
    """Return the property that a service is; ``~`` stands before a part that would be another."""
    first, *rest = service.strip("/").split("/")
    head = f"~{first}" if first in _OWN else first
    return ".".join(f"~{each}" if each in RESERVED else each for each in (head, *rest))


def _entry(service: str, value: object) -> Entry:
    if not isinstance(value, Element) or value.name != "service":
        raise PropertyError("bad-value", 'expected <service type="…"><contact …/></service>')
    contacts = []
    for each in value.children:
        protocol = each.attributes.get("protocol", "")
        if each.name != "contact" or protocol not in _ADDRESS or each.leaf is None:
            known = " ".join(_ADDRESS)
            raise PropertyError("bad-value", f'expected <contact protocol="…">: {known}')
        address = each.leaf if isinstance(each.leaf, str) else str(each.leaf)
        _check_address(protocol, address)
        contacts.append((protocol, address))
    if not contacts:
        raise PropertyError("bad-value", "expected a contact")
    return Entry(service, tuple(value.attributes.get("type", "").split()), tuple(contacts))


def _check_address(protocol: str, address: str) -> None:
    """Refuse what could never be the address of a contact."""
    if protocol in ("unix", "zenoh"):
        if _SERVICE.fullmatch(address) is None:
            raise PropertyError("bad-value", f"{protocol}: not a name of a service: {address}")
    elif not (place := _HOST_AND_PORT.fullmatch(address)) or not 0 < int(place[1]) < 1 << 16:
        raise PropertyError("bad-value", f"{protocol}: not HOST:PORT: {address}")


def _frame(text: str) -> tuple[str, tuple[float, ...]]:
    name, *numbers = text.replace("(", " ").replace(")", " ").split()
    if len(numbers) != 6:
        raise ValueError(f"not NAME x y z a b c: {text}")
    return name, tuple(map(float, numbers))


def _is_finite(value: object) -> bool:
    return is_number(value) and math.isfinite(value)  # type: ignore[arg-type]


ResourceInit = init_of(Resource)
