"""Process of an owner: makes movable components elsewhere when their host is lost, and reconciles.

It is a child of the manager that owns the systems, and ends with it: where the owner itself is
lost, nothing moves. It sleeps until the state of a link or a record changes, or a time is over.
"""

from __future__ import annotations

import logging
import os
import select
import signal
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from time import monotonic, time
from typing import TYPE_CHECKING

from rtkit.api import owning
from rtkit.api.owner_places import AGAIN_S, Found, OtherPlaces
from rtkit.deployment.owned import MovableRule, OwnedSystem
from rtkit.errors import RtkitError, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.link import host_links, owned_files, places
from rtkit.link.folder_watch import FolderWatch
from rtkit.link.processes import ProcessWatch
from rtkit.link.threads import start_thread
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.names import LOCAL, manager_on, split_manager

if TYPE_CHECKING:
    from rtkit.api.session import ScriptSession
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.tree.client import Tree

_log = logging.getLogger(__name__)
ACTIVE, INACTIVE = LifeCycleState.ACTIVE.value, LifeCycleState.INACTIVE.value
_WAIT_S = 30.0
"""How long a plan of somebody else is waited for [s]."""
_TIMEOUT_S = 10.0
_EVER_S = 1e6


class _RecordChanged(Exception):
    """A command has written or removed the record since it was read: it is to be read anew."""


def main() -> None:
    """Be the process: ``MANAGER``."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # meant for the manager, which says when to end
    manager = sys.argv[1]
    watch = ProcessWatch(os.getppid())

    def await_manager() -> None:
        watch.await_end(_EVER_S)
        os._exit(0)

    start_thread(await_manager, "manager")
    SystemOwner(manager).run()


class SystemOwner:
    """Keeps the systems of a manager whole.

    Args:
        manager: Its name.
    """

    def __init__(self, manager: str) -> None:
        self._manager = manager
        self._lost_since: dict[str, float] = {}
        self._again_at = 0.0
        self._places = OtherPlaces()
        self._left_out: dict[str, frozenset[str]] = {}
        self._folders = (
            FolderWatch(places.runtime_dir()),
            FolderWatch(places.make_private(owned_files.folder())),
        )
        self._bell, ring = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
        os.set_blocking(ring, False)
        signal.signal(signal.SIGCONT, lambda *_: None)
        signal.set_wakeup_fd(ring, warn_on_full_buffer=False)

    def run(self) -> None:
        """Act on each change, as long as the process lives."""
        while True:
            due_at = self._look()
            wait_s = None if due_at is None else max(0.0, due_at - monotonic())
            select.select([*map(FolderWatch.fileno, self._folders), self._bell], [], [], wait_s)
            for folder in self._folders:
                folder.take()
            if select.select([self._bell], [], [], 0)[0]:
                os.read(self._bell, 4096)

    def _look(self) -> float | None:
        """Do what is due; return when to look again, None for not before something changes."""
        now = monotonic()
        due: list[float] = []
        for owned in owning.records(self._manager):
            if self._again_at > now:
                due.append(self._again_at)
                continue
            try:
                due += self._keep(owned)
            except _RecordChanged:
                due.append(now)
            except RtkitError as error:
                self._note(owned.system, str(error))
                self._again_at = monotonic() + AGAIN_S
                due.append(self._again_at)
        return min(due, default=None)

    def _keep(self, owned: OwnedSystem) -> Iterator[float]:
        """Reconcile a system, and move what is due; yield the moments at which more is."""
        from rtkit.deployment.owned import rules_of

        for host in (each for each in list(self._lost_since) if not _why_lost(each)):
            del self._lost_since[host]
        owned = self._ended_elsewhere(owned)
        rules: dict[str, MovableRule] = {}
        due: dict[str, tuple[str, ...]] = {}
        for name, each in owned.components.items():
            host = split_manager(each.home)[1]
            if not _why_lost(host):
                continue
            if not rules:
                rules = rules_of(_profile(owned))
            due_at = self._lost_since.setdefault(host, monotonic()) + rules[name].wait_s
            if due_at > monotonic():
                yield due_at
            else:
                due[name] = (*rules[name].hosts, LOCAL)
        lost = frozenset(filter(_why_lost, host_links.hosts()))
        found = self._places.find(owned.system, due, lost, lambda: self._asked(owned, due))
        owned = self._rehomed(owned, found)
        if found.whys:
            yield found.again_at
        if owned.is_pending and self._left_out.get(owned.system) != lost:
            unreachable = self._carry_out(owned)
            silent = [
                why for each, why in unreachable.items() if split_manager(each)[1] not in lost
            ]
            if silent:
                raise Unreachable("; ".join(silent))  # no link will tell when it answers again
            self._left_out[owned.system] = lost

    def _replace(self, owned: OwnedSystem, made: OwnedSystem) -> OwnedSystem:
        """Keep a record in place of the one that was read, and return it.

        Raises:
            _RecordChanged: It is another one by now.
        """
        if not owning.exchange(self._manager, owned, made):
            raise _RecordChanged
        return made

    def _check(self, owned: OwnedSystem) -> None:
        """Check that a record is still what was read.

        Raises:
            _RecordChanged: It is another one by now.
        """
        if owning.read(self._manager, owned.system) != owned:
            raise _RecordChanged

    @contextmanager
    def _locked(self, owned: OwnedSystem) -> Iterator[None]:
        """Keep plans of others off while something is done by a record.

        Raises:
            _RecordChanged: Such a plan has changed it.
        """
        from rtkit.tree.plan_locks import PlanLocks

        with self._session(owned) as session, PlanLocks(session.name, _WAIT_S, _log.info) as lock:
            lock.take(session.tree)
            self._check(owned)
            yield

    def _note(self, system: str, why: str) -> None:
        """Note why a plan failed, which is tried again."""
        owned = owning.read(self._manager, system)
        if owned is not None and owned.why != why:
            _log.error("%s: %s", owned.system, why)
            owning.exchange(self._manager, owned, replace(owned, why=why))

    def _asked(
        self, owned: OwnedSystem, due: Mapping[str, Sequence[str]]
    ) -> tuple[Mapping[str, str], Mapping[str, str]]:
        """Return where components go whose hosts are lost, and why there is no place for some."""
        from rtkit.api.placing import other_places, settled
        from rtkit.api.system_profiles import made
        from rtkit.deployment.owned import opened

        with self._session(owned) as session:
            as_is = settled(session, made(_profile(owned), owned.source)).profile  # others stay
            document = made(opened(as_is, owned, due), owned.source)
            return other_places(session, document, due)

    def _rehomed(self, owned: OwnedSystem, found: Found) -> OwnedSystem:
        """Keep the new places of components in the record, and why there is none for others."""
        made = owned
        for name, each in owned.components.items():
            why = found.whys.get(name, "")
            if name in found.places:
                target = self._manager_at(found.places[name])
                lost = split_manager(each.home)[1]
                _log.warning("%s: host %s is lost: %s is made in %s",
                             owned.system, lost, name, target)  # fmt: skip
                made = made.moved(name, target, time(), is_stale=True)
                self._left_out.pop(owned.system, None)
            elif why != each.why:
                if why and not each.why:
                    _log.warning("%s: %s", owned.system, why)
                made = made.with_component(name, replace(each, why=why))
        # First: who is killed here goes on from there.
        return self._replace(owned, made) if made != owned else owned

    def _manager_at(self, place: str) -> str:
        """Return the manager of a host, as plans call it."""
        if place == LOCAL:
            return self._manager
        return manager_on(host_links.read(place).far_manager, place)

    def _ended_elsewhere(self, owned: OwnedSystem) -> OwnedSystem:
        """End older ones of components where their host is back."""
        from rtkit.api.gathering import connected

        for name, each in list(owned.components.items()):
            for manager in each.stale:
                host = split_manager(manager)[1]
                if not host_links.is_linked(host) or _why_lost(host):
                    continue
                if owned.is_pending and not self._lives(name, each.home):
                    # It could not be made there: it is to be where it was, with its connections.
                    back = owned.moved(name, manager, time(), is_stale=False)
                    owned = self._replace(owned, replace(back, is_pending=True))
                    self._left_out.pop(owned.system, None)
                    break
                with self._locked(owned), connected(manager, _TIMEOUT_S) as tree:
                    owning.send_epoch({manager: tree}, self._manager, name, owned, _log.info)
                    if owning.end(tree, name):
                        _log.warning("%s in %s was of a past epoch, and is ended", name, manager)
                left = tuple(other for other in each.stale if other != manager)
                each = replace(each, stale=left)
                owned = self._replace(owned, owned.with_component(name, each, is_pending=True))
                self._left_out.pop(owned.system, None)
        return owned

    @staticmethod
    def _lives(name: str, manager: str) -> bool:
        """Return whether a component is in a manager, as far as that can be asked."""
        from rtkit.api.gathering import connected

        with connected(manager, _TIMEOUT_S) as tree:
            facts = tree.snapshot().component(name)
        return facts is not None and not facts.zombie

    @contextmanager
    def _session(self, owned: OwnedSystem) -> Iterator[ScriptSession]:
        """Have a connection to the manager for what is done about a system."""
        from rtkit.api.session import ScriptSession
        from rtkit.tree.connect import connect

        with (
            connect(self._manager, _TIMEOUT_S) as tree,
            ScriptSession(tree, _log.info, f"owner of {owned.system}") as session,
        ):
            yield session

    def _carry_out(self, owned: OwnedSystem) -> Mapping[str, str]:
        """Lead the system to where its components are to be; return why managers are left out."""
        from rtkit.api import planning
        from rtkit.api.plan import carry_out
        from rtkit.api.system_profiles import made
        from rtkit.deployment.owned import placed
        from rtkit.tree.plan_locks import PlanLocks

        document = made(placed(_profile(owned), owned), owned.source)
        with self._session(owned) as session, PlanLocks(session.name, _WAIT_S, _log.info) as lock:
            aim = planning.GoalOptions(state=_state(session.tree, document))
            prepared = planning.prepare(
                session, document, aim, is_dry=False, lock=lock, leaves_out=True
            )
            self._check(owned)  # the locks are taken by now
            for name in owned.components:
                owning.send_epoch(session.tree.trees, self._manager, name, owned, _log.info)
            carry_out(session, prepared, owns=False)
        unreachable = prepared.snapshot.unreachable
        self._replace(owned, replace(owned, is_pending=bool(unreachable), why=""))
        return unreachable


def _state(tree: Tree, document: SystemProfile) -> str:
    """Return the state in which a system is: Inactive if none of its components here is Active."""
    names = set(document.components)
    found = [each.state for each in tree.snapshot().components if each.instance in names]
    return INACTIVE if found and ACTIVE not in found else ACTIVE


def _profile(owned: OwnedSystem) -> RtsProfile:
    from rtkit.profile.read import read_rts

    return read_rts(owned.profile.encode(), owned.source).profile


def _why_lost(host: str) -> str:
    """Return why a linked host cannot be reached; empty for one that can, and for none.

    One whose link is just being made, as the manager here has begun, is not lost yet.
    """
    why = host_links.why_lost(host)
    return "" if why == host_links.NOT_YET else why


if __name__ == "__main__":
    main()
