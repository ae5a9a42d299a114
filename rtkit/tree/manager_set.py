"""Manager set: several managers as one tree; each request goes to its manager.

One of another host is called as in plans: ``manager@robot1``.
"""

from __future__ import annotations

import select
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import partial
from itertools import groupby
from typing import Any

from rtkit.closing import Closing
from rtkit.deployment.actions import Action, Connect, Disconnect, Result
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.multi_manager import (
    NOWHERE,
    between_managers,
    down,
    expected_at,
    homes_in,
    in_plan,
    joined,
    manager_for,
    sent,
)
from rtkit.errors import RtkitError, Unreachable
from rtkit.link.places import host_name
from rtkit.link.transport import DeadLink
from rtkit.rtc.far_ends import peer_of
from rtkit.rtc.names import split_manager
from rtkit.rtc.profiles import ConnectorProfile
from rtkit.tree import managers
from rtkit.tree.client import DEFAULT_TIMEOUT_S, Tree
from rtkit.tree.expecting import expected
from rtkit.tree.subscription import ManagerEvent, ManagerSubscription

Answer = Callable[[], tuple[Result, ...]]
Start = Callable[[str], Tree]
"""Starts a manager of that name, and connects to it."""
End = Callable[[str, float], object]
"""Ends a manager of that name, within a time [s]."""


class ManagerSet(Tree):
    """Connections to several managers; each batch is split into one for each of them.

    Attributes:
        names: All managers that are meant, the first one first, also those that do not run.
        homes: Where components belong; the others are where they live.
    """

    def __init__(
        self,
        names: Sequence[str],
        trees: Mapping[str, Tree],
        homes: Mapping[str, str],
        start: Start | None = None,
        end: End | None = None,
        unreachable: Mapping[str, str] = NOWHERE,
    ) -> None:
        """Join connections.

        Args:
            names: All managers that are meant.
            trees: The connections to those that run.
            homes: Where components belong.
            start: Starts a manager and connects to it; None where that is for others to do.
            end: Ends one that was started; by default one of this host.
            unreachable: Why some cannot be asked though they may live, by their names.
        """
        first = next(iter(trees.values()), None)
        near = (tree.host for name, tree in trees.items() if not split_manager(name)[1])
        super().__init__(
            first.link if first is not None else DeadLink(),
            next(near, None) or host_name(),
            names[0],
            first.timeout_s if first is not None else DEFAULT_TIMEOUT_S,
        )
        self._start, self._end = start, end
        self._started: dict[str, bool] = {}
        self.names = tuple(names)
        self._trees = dict(trees)
        self.homes = dict(homes)
        self._unreachable = unreachable
        self._known: dict[str, str] = {}
        self._connectors: tuple[ConnectorProfile, ...] = ()
        self._lost_halves: dict[tuple[str, str], ConnectorProfile] = {}

    def __repr__(self) -> str:
        return f"<Fleet: managers {', '.join(self.names)} on {self.host}>"

    @property
    def trees(self) -> dict[str, Tree]:
        """The connections to those that run, by their names."""
        return self._trees

    def close(self) -> None:
        """End all connections."""
        for tree in self.trees.values():
            tree.close()

    def at(self, manager: str) -> Tree:
        """See `Tree.at`; `Unreachable` if it does not run."""
        name = manager or self.manager
        if name not in self.trees:
            raise Unreachable(f"manager {name!r} is not running")
        return self.trees[name]

    def start_manager(self, manager: str) -> None:
        """See `Tree.start_manager`; `Unreachable` if it was not ready in time."""
        if self._start is None:
            super().start_manager(manager)
            return
        if split_manager(manager)[1] and self.manager not in self.trees:
            self.start_manager(self.manager)  # which has the links to other hosts
        tree = self._start(manager)
        if not self.trees:
            self.link = tree.link
        self.trees[manager] = tree
        self.on_start(tree)
        found = tree.snapshot()
        self._started[manager] = not (found.components or found.modules)

    def end_started(self) -> list[str]:
        """See `Tree.end_started`: those that held something when they were started run on."""
        left = []
        for name, was_empty in reversed(self._started.items()):
            tree = self.trees.get(name)
            if tree is None or tree.has_ended():
                continue
            if not was_empty or tree.snapshot().components:
                left.append(name)
                continue
            del self.trees[name]
            tree.close()
            (self._end or managers.stop)(name, tree.timeout_s)
        self._started.clear()
        return left

    def snapshot(self) -> Snapshot:
        """See `Tree.snapshot`: the facts of all of them."""
        return self._joined([self._look(name) for name in self.names])

    def remains(self) -> Snapshot:
        """See `Tree.remains`: a manager that ended holds nothing."""
        return self._joined([self._look(name, may_be_gone=True) for name in self.names])

    def _look(self, name: str, *, may_be_gone: bool = False) -> Snapshot:
        tree = self.trees.get(name)
        if tree is None:
            return down(self.host, name)
        try:
            return tree.snapshot()
        except Unreachable:
            if may_be_gone and tree.has_ended():
                return down(self.host, name)
            raise

    def _joined(self, snapshots: Sequence[Snapshot]) -> Snapshot:
        whole = self.joined(snapshots)
        self._known.update(homes_in(whole))
        self._connectors = whole.connectors
        self._lost_halves = {
            (manager, each.connector_id): each
            for manager, known in zip(self.names, snapshots, strict=True)
            for each in known.connectors
            if each.trouble and peer_of(each)
        }
        return whole

    def joined(self, snapshots: Sequence[Snapshot]) -> Snapshot:
        """Return what several managers know as one."""
        named = zip(self.names, snapshots, strict=True)
        facts = [in_plan(each, name, self.host) for name, each in named]
        return joined(facts, self.homes, self._unreachable)

    def begin(
        self, actions: Sequence[Action], *, is_ordered: bool = True, timeout_s: float | None = None
    ) -> Answer:
        """See `Tree.begin`; a manager gets its part when the one before has done its own."""
        asked = [(self._manager_for(action), action) for action in actions]
        if is_ordered:
            parts = [(name, [a for _, a in part]) for name, part in groupby(asked, lambda x: x[0])]
            return lambda: self._one_after_another(parts, timeout_s)
        places: dict[str, list[int]] = {}
        for place, (name, _) in enumerate(asked):
            places.setdefault(name, []).append(place)
        answers = {
            name: self._begun(name, [actions[place] for place in each], False, timeout_s)
            for name, each in places.items()
        }
        return lambda: _gathered(answers, places, len(actions))

    def _manager_for(self, action: Action) -> str:
        homes = {**self._known, **self.homes}
        return manager_for(action, homes, self._connectors, self.manager)

    def _begun(
        self, name: str, actions: Sequence[Action], is_ordered: bool, timeout_s: float | None
    ) -> Answer:
        try:
            homes = {**self._known, **self.homes}
            words = [sent(action, name, homes, self.host) for action in actions]
            self._remove_halves(actions, homes)
            expecting = list(self._expecting(actions, homes))
            tree = self.at(name)
            if not expecting:
                return tree.begin(words, is_ordered=is_ordered, timeout_s=timeout_s)
            with ExitStack() as stack:
                failed = stack.enter_context(expected(expecting))
                answer = tree.begin(words, is_ordered=is_ordered, timeout_s=timeout_s)
                ids = [connector.connector_id for _, connector in expecting]
                return partial(_awaited, answer, stack.pop_all(), failed, ids)
        except RtkitError as error:
            failure = error  # raised at this manager's turn: the requests to others go first

            def fail() -> tuple[Result, ...]:
                raise failure

            return fail

    def _remove_halves(self, actions: Sequence[Action], homes: Mapping[str, str]) -> None:
        """Remove lost halves of connectors that are to be made with another end.

        They led to a manager that has ended, or to one that is away and is not asked.
        """
        for connector in (each.connector for each in actions if isinstance(each, Connect)):
            id = connector.connector_id
            for name in {homes.get(end.instance, self.manager) for end in connector.ports}:
                half = self._lost_halves.get((name, id))
                wanted = between_managers(connector, name, homes, self.host)
                if half is not None and {*half.ports} != {*wanted.ports}:
                    del self._lost_halves[name, id]
                    self.at(name).apply([Disconnect(id)])[0].raise_for_error()

    def _expecting(
        self, actions: Sequence[Action], homes: Mapping[str, str]
    ) -> Iterator[tuple[Tree, ConnectorProfile]]:
        """Yield who is to expect which connectors that a batch makes between hosts."""
        for action in actions:
            found = isinstance(action, Connect) and expected_at(action.connector, homes, self.host)
            if found:
                yield self.at(found[0]), found[1]

    def _one_after_another(
        self, parts: Iterable[tuple[str, list[Action]]], timeout_s: float | None
    ) -> tuple[Result, ...]:
        results: list[Result] = []
        for name, actions in parts:
            found = self._begun(name, actions, True, timeout_s)()
            results += found
            if len(found) < len(actions) or not all(each.ok for each in found):
                break
        return tuple(results)


def _awaited(
    answer: Answer, stack: ExitStack, failed: list[str], ids: Sequence[str]
) -> tuple[Result, ...]:
    """Await an answer; unless all was done, the connectors of these ids are expected no more."""
    with stack:
        results = answer()
        if not all(each.ok for each in results):
            failed += ids
    return results


def _gathered(
    answers: Mapping[str, Answer], places: Mapping[str, list[int]], count: int
) -> tuple[Result, ...]:
    """Await all answers, also when one does not come; then raise why.

    Raises:
        Unreachable: A manager did not answer.
    """
    results = [Result()] * count
    failure: RtkitError | None = None
    for name, answer in answers.items():
        try:
            for place, result in zip(places[name], answer(), strict=True):
                results[place] = result
        except RtkitError as error:
            failure = failure or error
    if failure is not None:
        raise failure
    return tuple(results)


class ManagerSetSubscription(Closing):
    """Subscribes to each manager of a set, as `ManagerSubscription` does to one."""

    def __init__(self, fleet: ManagerSet, *lines: Any) -> None:
        self.tree = fleet
        self._subscriptions: dict[str, ManagerSubscription] = {}
        try:
            for name, tree in fleet.trees.items():
                self._subscriptions[name] = ManagerSubscription(tree, *lines)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Listen no more."""
        for subscription in self._subscriptions.values():
            subscription.close()

    @property
    def facts(self) -> Snapshot:
        """Return the facts of all managers, as of the last change taken."""
        fleet = self.tree
        known = {name: subscription.facts for name, subscription in self._subscriptions.items()}
        return fleet.joined([known.get(name) or down(fleet.host, name) for name in fleet.names])

    @property
    def sources(self) -> list[int]:
        """Descriptors of which one is readable when there is something to `take`."""
        return [
            source
            for subscription in self._subscriptions.values()
            for source in subscription.sources
        ]

    def take(self) -> list[ManagerEvent]:
        """Return what has come from all of them."""
        return [
            event for subscription in self._subscriptions.values() for event in subscription.take()
        ]

    def wait(self) -> list[ManagerEvent]:
        """Wait until something has come, and take it."""
        while True:
            with suppress(InterruptedError):
                select.select(self.sources, [], [])
            taken = self.take()
            if taken:
                return taken


def subscription_at(tree: Tree, *lines: Any) -> ManagerSubscription | ManagerSetSubscription:
    """Return a subscription to one manager, or to each of several."""
    return (
        ManagerSetSubscription(tree, *lines)
        if isinstance(tree, ManagerSet)
        else ManagerSubscription(tree, *lines)
    )
