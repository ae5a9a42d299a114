"""Serves queries of clients: properties of the manager, and prepared views of its state.

Loadable modules are listed too: all in load paths and installed packages, read and not run.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from time import monotonic, time
from typing import Any, NamedTuple

from rtkit.deployment.actions import Create
from rtkit.deployment.batch import MAX_ID, Batch, batch_from_text, results_from_text
from rtkit.deployment.extension import FOLLOW
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.listing import listing_of, listing_to_text
from rtkit.deployment.part import part_of
from rtkit.deployment.plan_lock import PlanLock
from rtkit.deployment.port_samples import SAMPLES
from rtkit.deployment.terminal import TERMINAL
from rtkit.errors import Malformed, NotFound, Refused, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.link import zenoh_keys
from rtkit.link.processes import ProcessWatch
from rtkit.link.running import managers
from rtkit.manager.core import events as ev
from rtkit.manager.core import manager_properties, operations
from rtkit.manager.core.history import TimedItem, history, to_text
from rtkit.manager.core.operations import record
from rtkit.manager.core.requests import PendingRequests
from rtkit.manager.core.state import ManagerState
from rtkit.manager.log_server import LogServer
from rtkit.manager.report import open_report
from rtkit.manager.view_texts import ViewTexts
from rtkit.modules.creatable import lacking
from rtkit.modules.describing import OfferedType, describe
from rtkit.modules.search import Search
from rtkit.property.exchange import NOT_BEGUN, Reply, Request, failure
from rtkit.rtc.serde import encode


class RestartRequest(NamedTuple):
    """Request to restart the manager, perhaps with a descriptor for the report."""

    report: int | None


class ManagerQueryServer:
    """Answers queries that need no work and turns the rest into events.

    Views are made once and kept until the facts change.

    Attributes:
        restart: Set when the manager is to start again after its end.
        plan_lock: Lock of those who carry plans out.
        follow: Receives requests to follow a system, or not to.
        dump: Captures the last events, and returns what makes the text of them, on any thread.
        events: Captures the last events that may be about one component.
        logs: Reads the logs for other hosts.
        sample: Receives questions what ports carry.
        ask_terminal: Receives questions to terminals of components.
    """

    def __init__(self, state: ManagerState, requests: PendingRequests) -> None:
        self.restart: RestartRequest | None = None
        self.plan_lock = PlanLock(ProcessWatch)
        self.follow: Callable[[Request], object] = lambda _request: None
        self.dump: Callable[[], Callable[[], str]] = lambda: lambda: ""
        self.events: Callable[[str], Callable[[], Iterable[TimedItem]]] = lambda _name: tuple
        self.logs = LogServer(state.name)
        self.sample: Callable[[Request], object] = lambda _request: None
        self.ask_terminal: Callable[[Request], object] = lambda _request: None
        self._state = state
        self._requests = requests
        self._views: dict[str, str] = {}
        self._texts = ViewTexts(state)

    def forget_views(self) -> None:
        """Make views anew when they are asked for next: facts have changed."""
        self._views.clear()

    def take(self, request: Request) -> ev.Event | None:
        """Answer a request, or return the event that leads to its answer.

        Raises:
            RtkitError: The request cannot be served.
        """
        if monotonic() > request.until:
            raise Unreachable(NOT_BEGUN)
        if request.is_extension and request.name == "picture":
            return ev.SnapshotRequested(self._requests.add(request.answer))
        if request.is_extension and request.name == "half" and request.payload is not None:
            number = self._requests.add(request.answer)
            return ev.PeerAsked(request.payload, number, request.until)
        if request.is_extension or request.payload is None:
            self._read(request)
            return None
        if request.name == "batch":
            batch = batch_from_text(request.payload)
            return ev.BatchRequested(batch, self._requests.add(request.answer), request.until)
        if request.name in ("stop", "shutdown"):
            request.answer(Reply(str(self._state.pid)))
            return ev.StopRequested(is_kept=request.payload == "keep")
        if request.name == "restart":
            pipe = request.payload.removesuffix("forget")
            self.restart = RestartRequest(open_report(pipe.rstrip()))
            request.answer(Reply(str(self._state.pid)))
            return ev.StopRequested(is_kept=pipe == request.payload)
        if zenoh_keys.unescape(request.name) == FOLLOW:
            self.follow(request)
            return None
        return self._operation(zenoh_keys.unescape(request.name), request)

    def _read(self, request: Request) -> None:
        """Answer a request that leads to no event."""
        name = request.name
        if not request.is_extension and name == "get_loadable_modules":
            folders = manager_properties.load_paths(self._state)
            _aside(request, lambda: loadable(folders))
        elif not request.is_extension:
            request.answer(Reply(self._property(zenoh_keys.unescape(name))))
        elif name == "lease":
            request.answer(Reply(self.plan_lock.asked(request.payload)))
        elif name == "lacking" and request.payload is not None:
            self._find(request)
        elif name == "host" and request.payload is not None:
            self._look_at_host(request, request.payload)
        elif name == "logs" and request.payload is not None:
            _aside(request, partial(self.logs.answer, request.payload))
        elif name == SAMPLES and request.payload is not None:
            self.sample(request)
        elif name == TERMINAL and request.payload is not None:
            self.ask_terminal(request)
        elif name == "clock":
            request.answer(Reply(repr(time())))
        elif name == "dump":
            _aside(request, self.dump())
        elif name.startswith("events/"):
            self._read_events(request, zenoh_keys.unescape(name.removeprefix("events/")))
        else:
            request.answer(Reply(self._view(name)))

    def _read_events(self, request: Request, instance: str) -> None:
        """Answer the last events about a component."""
        items, now, time_s = self.events(instance), monotonic(), time()
        _aside(request, lambda: to_text(history(items(), instance), now, time_s))

    def _find(self, request: Request) -> None:
        """Answer what keeps components from being made."""
        settings = self._state.settings
        search = Search(
            manager_properties.load_paths(self._state),
            is_absolute_allowed=settings.flag("manager.modules.abs_path_allowed"),
        )
        loaded = tuple(self._state.modules.values())
        may_search = settings.flag("manager.modules.search_auto")
        question = request.payload or ""
        _aside(request, lambda: lacking(question, loaded, search, is_search_allowed=may_search))

    def _look_at_host(self, request: Request, question: str) -> None:
        """Answer what this host has."""
        tags = self._state.settings.text("rtkit.tags")

        def work() -> str:
            from rtkit.manager.host_facts import host_facts

            return host_facts(question, tags)

        _aside(request, work)

    def _view(self, name: str) -> str:
        kind, _, which = name.partition("/")
        if kind == "part":
            instances = zenoh_keys.unescape(which).split(",")
            return _compact(encode(part_of(self._snapshot(), instances)))
        if kind == "listing" and which:
            return self._listing_at(zenoh_keys.unescape(which).split("\n"))
        if name not in self._views:
            if name == "listing":
                text = self._texts.listing(self._state.snapshot())
            elif name == "snapshot":
                text = self._texts.snapshot(self._snapshot())
            else:
                raise NotFound(f"no such view: {name}")
            self._views[name] = text
        return self._views[name]

    def _listing_at(self, paths: Sequence[str]) -> str:
        """Return a listing with the components at these paths, or a whole one in doubt."""
        state = self._state
        at_paths = [state.at_path(path) for path in paths]
        instances = dict.fromkeys(each for found in at_paths for each in found)
        facts = tuple(state.components[each] for each in instances)
        is_plain = not any(each.members for each in facts)  # others know what a composite shows
        if not is_plain or any(len(found) > 1 for found in at_paths):
            return self._view("listing")
        wires = {
            each.connector_id: each
            for instance in instances
            for each in state.connectors_of(instance)
        }
        part = replace(state.snapshot(), components=facts, connectors=tuple(wires.values()))
        return listing_to_text(listing_of(part))

    def _snapshot(self) -> Snapshot:
        return replace(self._state.snapshot(), properties=manager_properties.table(self._state))

    def _property(self, name: str) -> str:
        read = operations.READ.get(name)
        value = read(self._state) if read else manager_properties.lookup(self._state, name)
        if name in operations.DO:
            raise Refused(f"{name} is an operation: set it to its argument")
        if value is None:
            raise NotFound(f"no such property: {name}")
        if name == "get_slave_managers" and self._state.slaves:
            gone = {each for each in self._state.slaves if ":" not in each} - set(managers())
            value = "\n".join(each for each in value.splitlines() if each not in gone)
        return value

    def _operation(self, name: str, request: Request) -> ev.Event:
        argument = request.payload or ""
        if name in operations.READ:
            raise Refused(f"read-only property: {name}")
        if name == "create_component" and request.id:
            return self._create_once(request)
        if name in operations.DO:
            return ev.OperationRequested(name, argument, self._requests.add(request.answer))
        change = f"{name}:{argument}"
        return ev.OperationRequested(
            "set_configuration", change, self._requests.add(request.answer)
        )

    def _create_once(self, request: Request) -> ev.BatchRequested:
        """Return a creation as a batch, so that it is known by its id when it comes again."""

        def answer(reply: Reply) -> None:
            if not reply.error:
                (result,) = results_from_text(reply.text)
                reply = Reply(result.value) if result.ok else Reply(result.why, result.kind)
            request.answer(reply)

        made = (Create(request.payload or ""),)
        batch = Batch(made, True, operations.TIMEOUT_S, request.id[:MAX_ID])
        return ev.BatchRequested(batch, self._requests.add(answer), request.until)


def _aside(request: Request, work: Callable[[], str]) -> None:
    """Answer on a thread of its own: many files may have to be read."""
    from threading import Thread

    def run() -> None:
        try:
            reply = Reply(work())
        except Exception as error:
            reply = failure(error)
        request.answer(reply)

    Thread(target=run, name="scan", daemon=True).start()


def _compact(data: Any) -> str:
    return json.dumps(data, separators=(",", ":"))


MOST = 2000
"""How many files are looked at."""


def loadable(folders: Sequence[str]) -> str:
    """Return a line for each type, ``RTC:…?description=…&module=FILE``, or ``FILE?problem=WHY``."""
    return "\n".join(_lines(Search(folders)))


def _lines(search: Search) -> Iterator[str]:
    for name in itertools.islice(search.modules(), MOST):
        try:
            source = search.read(name)
            offers = describe(source.text, source.file, source.init, source.package)
        except (Refused, NotFound, Malformed) as error:
            yield record(name, {"problem": str(error)})
            continue
        for offer in offers or ():
            yield _record(offer, source.file)


def _record(offer: OfferedType, file: str) -> str:
    known = offer.type
    fields = {
        "implementation_id": known.type_name,
        "type_name": known.type_name,
        "description": known.description,
        "version": known.version,
        "vendor": known.vendor,
        "category": known.category,
        "activity_type": "PERIODIC",
        "max_instance": "0",
        "language": known.language,
        "lang_type": "SCRIPT",
        "module": file,
    }
    values = {f"conf.default.{name}": text for name, text in offer.parameters.items()}
    return record(known.full_id, {**fields, **values})
