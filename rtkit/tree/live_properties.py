"""Live properties of components, managers and this host, over the connections to managers.

It folds the facts, deltas and metrics of a manager into a service of its own, which answers as any
property service does; a SET becomes the action of the manager that it stands for.
"""

from __future__ import annotations

import math
import os
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from rtkit.deployment.delta import TREE
from rtkit.deployment.extension import FOLLOW
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.metrics import METRICS, ComponentMetrics, Metrics
from rtkit.deployment.properties import Change, Shown, of_component, of_manager
from rtkit.deployment.shown_ports import OwnEnds
from rtkit.errors import NotFound, Unreachable
from rtkit.link.places import host_name
from rtkit.property.functional import FunctionalProperty
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.property.property_spec import PropertySpec, RequestParameter
from rtkit.property.requests import ListeningRequester, PropertyRequest
from rtkit.property.service import Service
from rtkit.property.types import Content, parse_type
from rtkit.property.values import Value, Word
from rtkit.tree.client import Tree

if TYPE_CHECKING:
    from rtkit.tree.subscription import ManagerSubscription

READ = (
    "get_loaded_modules", "get_factory_profiles", "get_loadable_modules", "get_components",
    "get_component_profiles", "get_profile", "get_configuration", "is_master",
    "get_master_managers", "get_slave_managers", "get_hosts", "get_fences",
)  # fmt: skip
"""Operations of a manager that only tell."""
DO = (
    "load_module", "unload_module", "create_component", "delete_component",
    "get_components_by_name", "set_configuration", "fork", "add_master_manager",
    "remove_master_manager", "add_slave_manager", "remove_slave_manager", "get_service",
    "link_host", "unlink_host", "fence", "own", "shutdown", "restart",
)  # fmt: skip
"""Operations of a manager that are actions."""

_LEAST_S = 1e-3
_FIGURES_S = 3.0
"""How long the first metrics are waited for; they come once a second [s]."""
_ARGUMENT = (
    RequestParameter("argument", parse_type("string"), "", (), "as the operation takes it"),
)


class _LiveService(ABC):
    """Service of this process, asked and listened to as one behind a connection is."""

    def __init__(self) -> None:
        self._service = Service()
        self._me = ListeningRequester("owner")

    def ask(self, target: str, payload: Payload | None = None, until: float = math.inf) -> Answer:
        """See `BoundedClient.ask`."""
        answers: list[Answer] = []
        self._service.handle(PropertyRequest(target, payload, answers.append, self._me))
        return answers[0]

    def listen(self, target: str) -> None:
        """See `PropertyClient.listen`."""
        name, mark, tail = target.partition("?")
        _LiveService.ask(self, f"{name}.listen{mark}{tail}", "self").value()

    def event(self, timeout_s: float | None = None) -> PropertyEvent | None:
        """See `PropertyClient.event`."""
        end = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            now = time.monotonic()
            taken = (listener.take(now) for listener in list(self._me.listeners))
            event = next((each for each in taken if each is not None), None)
            if event is not None or (end is not None and now >= end):
                return event
            dues = [listener.due() for listener in self._me.listeners]
            times = [each for each in (*dues, end) if each is not None]
            self._receive(min(times) - now if times else None)

    @abstractmethod
    def _receive(self, wait_s: float | None) -> None:
        """Have the values be what they are now; wait for that, not longer [s]."""


def _subscription(tree: Tree) -> ManagerSubscription:
    """Listen to all that properties are made of; a single request does without."""
    from rtkit.tree.subscription import ManagerSubscription

    return ManagerSubscription(tree, (TREE, METRICS))


def _is_count(target: str) -> bool:
    """Return whether a property is a counter, which the manager reports once a second only."""
    return target.partition("?")[0].endswith(".count")


class LiveProperties(_LiveService):
    """A component, or the manager itself when no instance is named, as properties.

    Args:
        tree: The connection to the manager; it is closed with this.
    """

    def __init__(self, tree: Tree, instance: str) -> None:
        super().__init__()
        self._tree = tree
        self._timeout_s = tree.timeout_s
        self._instance = instance
        self._changes: dict[str, Change | None] = {}
        self._metrics: ComponentMetrics | None = None
        self._subscription: ManagerSubscription | None = None
        self._is_closed = False
        if not instance:
            self._add_operations()

    def ask(self, target: str, payload: Payload | None = None, until: float = math.inf) -> Answer:
        """See `BoundedClient.ask`."""
        self._tree.timeout_s = max(min(self._timeout_s, until - time.monotonic()), _LEAST_S)
        if _is_count(target) and self._metrics is None:
            with _subscription(self._tree) as subscription:
                self._await_metrics(subscription)
        self._refresh()
        answer = super().ask(target, payload)
        node = self._service.registry.nodes.get(target.partition("?")[0])
        if payload is not None and node is not None and node.function is not None:
            failed = node.function.describe().find("error")
            if failed is not None and not answer.error:
                return Answer(str(failed.leaf or ""), failed.attributes["code"])
        return answer

    def listen(self, target: str) -> None:
        """See `PropertyClient.listen`."""
        if self._subscription is None:
            self._subscription = _subscription(self._tree)
        if _is_count(target) and self._metrics is None:
            self._await_metrics(self._subscription)
        self._take(self._subscription.facts)
        super().listen(target)

    def _receive(self, wait_s: float | None) -> None:
        """Wait for word of the manager, and fold it in."""
        assert self._subscription is not None
        try:
            self._take_events(self._subscription, wait_s)
        except (OSError, ValueError):
            if not self._is_closed:
                raise
            raise Unreachable("the connection has ended") from None
        self._take(self._subscription.facts)

    def _take_events(self, subscription: ManagerSubscription, wait_s: float | None) -> None:
        """Take what comes from the manager in time [s].

        Raises:
            Unreachable: It has ended.
        """
        from rtkit.tree.subscription import SubscriptionEnded

        for event in subscription.wait(None if wait_s is None else max(0.0, wait_s)):
            if isinstance(event, SubscriptionEnded):
                raise Unreachable(event.why)
            if isinstance(event, Metrics):
                self._take_metrics(event)

    def _await_metrics(self, subscription: ManagerSubscription) -> None:
        """Take the next metrics, so that counters are known.

        Raises:
            Unreachable: The manager has ended.
        """
        until = time.monotonic() + _FIGURES_S
        while self._metrics is None and (left := until - time.monotonic()) > 0:
            self._take_events(subscription, left)

    def _take_metrics(self, metrics: Metrics) -> None:
        for process in metrics.processes:
            for component in process.components:
                if component.instance == self._instance:
                    self._metrics = component

    def _refresh(self) -> None:
        if self._instance:
            self._take(self._tree.part([self._instance]))
        else:
            self._take(self._tree.snapshot())

    def _take(self, snapshot: Snapshot) -> None:
        """Have the properties be what the facts are."""
        if not self._instance:
            self._fold(of_manager(snapshot, snapshot.properties))
            return
        facts = snapshot.component(self._instance)
        if facts is None:
            raise NotFound(f"no such component any more: {self._instance}")
        ends = OwnEnds.of(snapshot).ends(facts) if facts.members else {}
        self._fold(of_component(facts, snapshot.connectors, self._metrics, ends))

    def _fold(self, shown: Sequence[Shown]) -> None:
        nodes = self._service.registry.nodes
        names = {each.name for each in shown}
        for name in [name for name in self._changes if name not in names]:
            del self._changes[name]
            if name in nodes:
                self._service.remove(name)
        for each in shown:
            self._changes[each.name] = each.change
            if each.name not in nodes:
                self._add(each)
            elif not each.spec.is_functional:
                self._service.update(each.name, each.value)

    def _add(self, shown: Shown) -> None:
        def write(value: Content, _given: object = None) -> None:
            change = self._changes[shown.name]
            if change is not None:
                for result in self._tree.apply(change(value)):
                    result.raise_for_error()
            else:
                key = shown.name.removeprefix("settings.")
                self._tree.set(key, str(value))

        if shown.spec.is_functional:
            (only,) = shown.spec.parameters
            default: Content = 1 if only.default is None else only.default
            function = FunctionalProperty(
                lambda **given: write(given.get(only.key, default)), shown.spec.parameters
            )
            self._service.add(shown.name, spec=shown.spec, function=function)
            return
        is_set = "w" in shown.spec.access
        self._service.add(shown.name, shown.value, shown.spec, write=write if is_set else None)

    def _add_operations(self) -> None:
        """Register the operations of the manager."""
        spec = PropertySpec(parse_type("element"), is_functional=True)
        for name in DO:
            function = FunctionalProperty(
                lambda argument="", name=name: self._tree.set(name, argument), _ARGUMENT
            )
            self._service.add(name, spec=spec, function=function)
        for name in READ:
            self._service.add(
                name,
                spec=PropertySpec(parse_type("text"), "r"),
                read=lambda _given, name=name: self._tree.get(name),  # type: ignore[misc]
            )

        self._service.add(
            FOLLOW,
            spec=PropertySpec(
                parse_type("text"), "rw", doc="Systems whose events the manager follows"
            ),
            read=lambda _given: self._tree.get(FOLLOW),
            write=lambda value, _given: self._tree.set(FOLLOW, str(value)),
        )

    def close(self) -> None:
        """End the connection."""
        self._is_closed = True
        if self._subscription is not None:
            self._subscription.close()
        self._tree.close()


def _words(look: Callable[[], Sequence[str]], _given: object) -> Value:
    return tuple(map(Word, look()))


class _PolledService(_LiveService):
    """Service whose values are looked up when they are asked for."""

    def _receive(self, wait_s: float | None) -> None:
        """Read the properties anew, once a second."""
        time.sleep(max(0.0, min(1.0, 1.0 if wait_s is None else wait_s)))
        self._service.poll()

    def _add_words(self, **looks: Callable[[], Sequence[str]]) -> None:
        for name, look in looks.items():
            read = partial(_words, look)
            self._service.add(name, spec=PropertySpec(access="r"), read=read)

    def close(self) -> None:
        """End nothing: nobody is connected."""


class FarHost(_PolledService):
    """Another host: which of its services may be asked from here."""

    NAMES = ("services",)

    def __init__(self, services: Callable[[], Sequence[str]]) -> None:
        super().__init__()
        self._add_words(services=services)


class ThisHost(_PolledService):
    """This host: which managers and services of this user are on it, and how busy it is.

    Attributes:
        names: Of its properties.
    """

    def __init__(
        self,
        services: Callable[[], Sequence[str]],
        managers: Callable[[], Sequence[str]],
        hosts: Callable[[], Sequence[str]] = tuple,
    ) -> None:
        super().__init__()
        uname = os.uname()
        values: Mapping[str, Value] = {
            "name": host_name(),
            "system": f"{uname.sysname} {uname.release} {uname.machine}",
            "processors": os.cpu_count() or 0,
        }
        for name, value in values.items():
            self._service.add(name, value, PropertySpec(access="r"))
        self._add_words(managers=managers, services=services, hosts=hosts)
        load = PropertySpec(
            parse_type("vector[3]"), "r", doc="Load average over 1, 5 and 15 minutes"
        )
        self._service.add("load", spec=load, read=lambda _given: os.getloadavg())
        self.names = self._service.registry.children("")
