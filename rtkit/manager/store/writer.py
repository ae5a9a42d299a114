"""Writes desired state to the store on a thread of its own: a slow disk delays nobody else.

It never tries again: what was not stored it reports, and `rtkit.manager.core.durable_replies` keeps
the rows, retries, and holds back the replies that wait for them.
"""

from __future__ import annotations

import logging
import os
import queue
import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit import fault
from rtkit.link import places

if TYPE_CHECKING:
    from rtkit.manager.store.store import Row, Store

Stored = Callable[[int, str, bool], object]
"""Called with the number of what was to be kept, why it is not (empty when it is), and whether
nothing is that was kept before: then all is to be kept again."""

Failed = Callable[[str, BaseException], object]

_log = logging.getLogger(__name__)


class _Order(NamedTuple):
    number: int
    rows: Sequence[Row]


class StoreWriter:
    """Writes the store at a path on one thread; rows that come meanwhile join the next commit.

    Attributes:
        stored: Receives what was stored, on that thread.
        failed: Receives faults of its own, with the name of the work.
    """

    def __init__(self, path: str) -> None:
        self._path = path
        self._inbox: queue.SimpleQueue[_Order | None] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._store: Store | None = None
        self._is_forgotten = False
        self.stored: Stored = lambda _number, _why, _is_lost: None
        self.failed: Failed = lambda _work, _error: None

    def find(self) -> tuple[list[Row], str]:
        """Return the rows of an earlier manager, and a finding about its store.

        Raises:
            Refused: Another process uses the file, a newer rtkit has written it, or it is a link.
        """
        # Mostly there is neither: then nothing is imported yet.
        if not (self._is_there() or os.path.lexists(f"{self._path}-commits")):
            return [], ""
        found = self._opened().find()
        return found.rows, found.finding

    def set_aside(self) -> str:
        """Begin without what is there; return a finding about it."""
        return self._opened().set_aside("unrestored") if self._is_there() else ""

    def _is_there(self) -> bool:
        return any(map(os.path.lexists, (self._path, places.former_store_file(self._path))))

    def begin(self) -> None:
        """Be ready to write soon."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="keeper", daemon=True)
            self._thread.start()

    def keep(self, number: int, rows: Sequence[Row]) -> None:
        """Have rows written; `stored` is called when they are."""
        self.begin()
        self._inbox.put(_Order(number, rows))

    def forget(self) -> None:
        """Have the store removed at the end: nothing is desired any more."""
        self._is_forgotten = True

    def close(self) -> None:
        """Write what is still to be written, and end."""
        if self._thread is not None:
            self._inbox.put(None)
            self._thread.join()
        if self._is_forgotten:
            self._opened().forget()
        elif self._store is not None:
            self._store.close()

    def _opened(self) -> Store:
        if self._store is None:
            from rtkit.manager.store.store import Store

            self._store = Store(self._path)
        return self._store

    def _run(self) -> None:
        from rtkit.manager.store.store import StoreFailed, StoreLost

        store, is_over, lost, why = self._opened(), False, "", ""
        try:
            store.prepare()
        except StoreLost as error:
            lost = str(error)
        except StoreFailed as error:
            _log.warning("the desired state cannot be recorded: %s", error)
        while not is_over:
            orders = [self._inbox.get()]
            while not self._inbox.empty():
                orders.append(self._inbox.get())
            is_over = None in orders
            whole = [order for order in orders if order is not None]
            if not whole:
                continue
            failed_before, why, lost = why, lost, ""
            is_lost = bool(why)
            try:
                fault.point("duty.store")
                if not is_lost:
                    store.write([row for order in whole for row in order.rows])
            except StoreLost as error:
                why, is_lost = str(error), True
            except StoreFailed as error:
                why = str(error)
                if why != failed_before:  # it is tried again each second
                    _log.error("the desired state cannot be recorded: %s", why)
            except Exception as error:  # whoever waits for it is answered all the same
                self.failed("store", error)
                why = f"a fault of rtkit: {error}"
            for order in whole:
                self.stored(order.number, why, is_lost)
