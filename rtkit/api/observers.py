"""Shares subscriptions to managers among the observing commands; they survive restarts."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from time import monotonic, time
from typing import TYPE_CHECKING, NamedTuple

from rtkit.closing import Closing
from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, MANAGER_SUFFIX, manager_on, split_manager
from rtkit.tree.view import shown_path

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.deployment.facts import ComponentFacts, Snapshot
    from rtkit.deployment.user_events import UserEvent
    from rtkit.link.folder_watch import FolderWatch
    from rtkit.tree.client import Tree
    from rtkit.tree.scope import Scope
    from rtkit.tree.subscription import ManagerEvent, ManagerSubscription

_AGAIN_S = 0.05
_LATER_S = 1.0
_KEEN_S = 5.0
"""Time for which an endpoint is retried after its folder has changed [s]."""


class ManagerSeen(NamedTuple):
    """Event: a manager answers that did not answer, or did not run, before."""

    manager: str
    is_back: bool

    def __str__(self) -> str:
        return f"manager {self.manager!r} {'is back' if self.is_back else 'has begun'}"


class ObservedEvent(NamedTuple):
    """An event, and the manager that it is from."""

    manager: str
    event: ManagerEvent | ManagerSeen


class Observers(Closing):
    """Subscriptions to one manager, or to several of this host; leave it as a context manager.

    Attributes:
        subscriptions: By the name of the manager, as `connect` takes it; "" for the one that paths
            lead to.
        names: The name of each manager, by the same.
        places: What paths to each begin with, by the same.
        why: The error of the last manager that did not answer.
    """

    def __init__(
        self,
        session: Session,
        lines: Sequence[str],
        *,
        is_wide: bool = False,
        has_hosts: bool = False,
        is_patient: bool = False,
    ) -> None:
        """Subscribe.

        Args:
            session: The run of the command.
            lines: The topics to subscribe to.
            is_wide: Subscribe to all managers of this user on this host, also to those that begin
                later.
            has_hosts: Subscribe to the managers of linked hosts, too; one that cannot be reached is
                told, and waited for.
            is_patient: Wait for a manager that does not answer, in `listen`.

        Raises:
            Unreachable: It does not answer, and that is not waited for.
        """
        self._session = session
        self._lines = tuple(lines)
        self._trees: dict[str, Tree] = {}
        self._facts: dict[str, Snapshot] = {}
        self._away: list[str] = []
        self._far: set[str] = set()
        self._folder: FolderWatch | None = None
        self._keen_until = 0.0
        self._is_wide = is_wide and session.finds_managers
        self._has_hosts = has_hosts and self._is_wide
        self.names: dict[str, str] = {}
        self.places: dict[str, str] = {}
        self.why: RtkitError | None = None
        self.subscriptions: dict[str, ManagerSubscription] = {}
        try:
            self._open("")
        except Unreachable as error:
            if not is_patient:
                raise
            self.why = error
            self._await("")
        if self._is_wide:
            self._watch_folder()
        for name in self._unknown():
            self.names[name] = name
            if self._enter(name):
                continue
            if name in self._far:
                session.miss(f"not listened to: {self.why}")
                self._await(name)
            else:
                session.fail(f"manager {name!r} does not answer")
        if self._is_wide:
            session.report_silent_servers("not listened to")

    def close(self) -> None:
        """End all subscriptions."""
        for name in list(self.subscriptions):
            self._leave(name)
        if self._folder is not None:
            self._folder.close()

    def listen(
        self,
        until: float | None,
        also: Sequence[int] = (),
        wake_at: Callable[[], float | None] = lambda: None,
    ) -> Iterator[list[ObservedEvent]]:
        """Yield the events received, and an empty list when one of the descriptors is readable.

        It ends when the time is up, monotonic [s]. A manager that ends is waited for.

        Args:
            until: When to end; None for never.
            also: Further descriptors to wait for.
            wake_at: Returns the latest moment of the next yield, monotonic [s].

        Raises:
            BrokenPipeError: Nobody reads stdout any more.
        """
        while until is None or monotonic() < until:
            moment = wake_at()
            ready = self._wait(until, also, moment)
            events = [
                ObservedEvent(name, event)
                for name, subscription in list(self.subscriptions.items())
                for event in subscription.take()
            ]
            events += self._follow(events)
            if events or ready or moment is not None:
                yield events

    def _wait(self, until: float | None, also: Sequence[int], wake_at: float | None) -> bool:
        """Wait for an event; return whether one of the descriptors `also` is readable."""
        sources = [
            each for subscription in self.subscriptions.values() for each in subscription.sources
        ]
        if self._folder is not None:
            sources.append(self._folder.fileno())
        bounds = [each for each in (until, wake_at) if each is not None]
        if any(map(self._is_there, self._away)):
            # The folder shows that an endpoint appears, not that it begins to answer: it is polled.
            is_keen = monotonic() < self._keen_until
            bounds.append(monotonic() + (_AGAIN_S if is_keen else _LATER_S))
        ready = self._session.wait_for([*sources, *also], min(bounds, default=None))
        return not ready.isdisjoint(also)

    def _follow(self, events: Sequence[ObservedEvent]) -> list[ObservedEvent]:
        """Drop managers that ended; return the events of those that are back, or new."""
        from rtkit.tree.subscription import SubscriptionEnded

        for manager, event in events:
            if isinstance(event, SubscriptionEnded):
                self._leave(manager)
                self._await(manager)
        if self._folder is not None and self._folder.take():
            self._keen_until = monotonic() + _KEEN_S
            for name in self._unknown():
                self.names[name] = name
                self._away.append(name)
        back = [name for name in self._away if self._is_there(name) and self._enter(name)]
        self._away = [name for name in self._away if name not in back]
        if not self._away and self._folder is not None and not self._is_wide:
            self._folder.close()
            self._folder = None
        return [each for name in back for each in self._return_of(name)]

    def _return_of(self, name: str) -> list[ObservedEvent]:
        """Return the events of a manager's return: itself, and the changes missed meanwhile."""
        from rtkit.deployment.delta import delta_between
        from rtkit.deployment.user_events import user_events
        from rtkit.tree.subscription import TreeChange

        after = self.subscriptions[name].facts
        before = self._facts.pop(name, None)
        seen = [ObservedEvent(name, ManagerSeen(self.names[name], before is not None))]
        if before is None:  # the manager is new: all that it holds has appeared
            before = replace(after, processes=(), components=(), connectors=(), modules=())
        missed = tuple(user_events(before, delta_between(before, after, "", 0)))
        return [*seen, ObservedEvent(name, TreeChange(time(), missed))]

    def _unknown(self) -> list[str]:
        """Return the running managers, and linked hosts, that are not known yet, if wanted."""
        from rtkit.link.host_links import hosts
        from rtkit.link.running import managers

        known = {*self.names, *self.names.values()}
        far = [f"{host}/" for host in hosts()] if self._has_hosts else []
        self._far.update(far)
        return [name for name in (*managers(), *far) if name not in known] if self._is_wide else []

    def _is_there(self, name: str) -> bool:
        from rtkit.link.places import manager_socket

        known = self.names.get(name, "")
        is_far = name in self._far or ":" in name
        return not known or is_far or os.path.exists(manager_socket(known))

    def _await(self, name: str) -> None:
        self._away.append(name)
        self._keen_until = monotonic() + _KEEN_S
        self._watch_folder()

    def _watch_folder(self) -> None:
        from rtkit.link.folder_watch import FolderWatch
        from rtkit.link.places import make_private, runtime_path

        if self._folder is None:
            self._folder = FolderWatch(make_private(runtime_path()))

    def _enter(self, name: str) -> bool:
        """Subscribe to a manager; return whether it answers."""
        try:
            self._open(name)
        except (Unreachable, Refused) as error:
            self.why = error
            self._leave(name)
            return False
        return True

    def _open(self, name: str) -> None:
        from rtkit.link.places import host_name
        from rtkit.tree.connect import connect
        from rtkit.tree.subscription import ManagerSubscription

        if name:
            tree = self._trees[name] = connect(name, self._session.timeout_s)
        else:
            tree = self._session.tree
        if tree.host != host_name():  # no socket here shows whether it is back
            self._far.add(name)
        self.subscriptions[name] = ManagerSubscription(tree, self._lines)
        is_beside = bool(name) and tree.host != host_name()
        self.names[name] = manager_on(tree.manager, tree.host) if is_beside else tree.manager
        self.places[name] = tree.place

    def _leave(self, name: str) -> None:
        subscription, tree = self.subscriptions.pop(name, None), self._trees.pop(name, None)
        if subscription is not None:
            self._facts[name] = subscription.facts
            _quietly(subscription.close)
        if tree is not None:
            _quietly(tree.close)
        elif not name:
            _quietly(self._session.close)


def _quietly(end: Callable[[], object]) -> None:
    """End a connection whose other end may be gone."""
    try:
        end()
    except RtkitError:
        return


def place_of(
    manager: str,
    what: UserEvent | ComponentFacts,
    hostname: str,
    *,
    is_usual: bool,
    local: str = LOCAL,
) -> str:
    """Return where a component, or a process, of a manager is in the tree.

    Names of components are paths only at the manager that is usually asked, and at those of other
    hosts, which are called as in plans. Paths to its host begin with `local`.
    """
    manager, host = split_manager(manager)
    if what.names and (is_usual or host):
        return shown_path(what.names[0], hostname, local)
    place = f"/{local}/{manager}{MANAGER_SUFFIX}"
    if what.instance:
        return f"{place}/{what.instance}{COMPONENT_SUFFIX}"
    is_slave = what.process not in ("", manager)
    return f"{place}/{what.process}{MANAGER_SUFFIX}" if is_slave else place


def scopes_of(session: Session, paths: Sequence[str]) -> list[Scope]:
    """Return the scopes that paths name.

    Raises:
        NotFound: One of them leads nowhere.
    """
    from rtkit.tree.scope import scope_of

    scopes = []
    for path in [session.path(typed) for typed in paths]:
        root, hostname = session.root(path, is_deep=False)
        scopes.append(scope_of(root, path, hostname))
    return scopes


def is_covered(
    scopes: Iterable[Scope], manager: str, what: UserEvent | ComponentFacts, hostname: str
) -> bool:
    """Return whether a scope covers an object of a manager; "" for the manager asked."""
    return any(
        scope.covers(what, hostname)
        and not (manager and scope.is_one_manager)
        and not (manager.endswith("/") and scope.is_one_host)
        for scope in scopes
    )
