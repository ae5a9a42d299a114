"""Asks other managers on a thread of its own, and reports when one is found or lost.

A peer of this host is reached through its own socket, and its end is seen at its process: nothing
is asked again and again. Callers see neither: only names, questions and answers.
"""

from __future__ import annotations

import os
import selectors
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue

from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.link import places, zenoh_keys
from rtkit.link.folder_watch import FolderWatch
from rtkit.link.wakeup import Wakeup
from rtkit.link.zenoh import ZenohLink, open_client, unix_endpoint
from rtkit.manager.core import events as ev
from rtkit.manager.core.requests import Answer
from rtkit.manager.peers.far_peers import FarPeers, OwnManager
from rtkit.property.exchange import Reply, failure
from rtkit.rtc.far_ends import host_of

_OPEN_S = 2.0
"""How long a peer that runs may take to let this manager in [s]."""
_AGAIN_S = 0.1
"""Pause before a peer that runs and did not let it in is tried again [s]."""
EXTENSION = "half"
"""Extension of a manager at which it is asked."""


class _Peer:
    """A connection to a manager, and what turns readable at its end."""

    def __init__(self, host: str, name: str) -> None:
        pid = places.owner(name)
        if pid is None:
            raise Unreachable(absent(name))
        try:
            self.process = os.pidfd_open(pid)
        except OSError as error:
            raise Unreachable(absent(name)) from error
        try:
            session = open_client(unix_endpoint(places.manager_socket(name)), _OPEN_S)
        except RtkitError as error:
            os.close(self.process)
            raise Unreachable(f"manager {name} does not answer") from error
        self.link = ZenohLink(session)
        self.key = zenoh_keys.extension_key(zenoh_keys.service(host, name), EXTENSION)

    def close(self) -> None:
        self.link.close()
        os.close(self.process)


class Peers:
    """Connections to other managers; what is learnt of them is posted as events.

    Args:
        own: This manager: its name, and that of its host.
        post: Takes events, from any thread.
        number: Numbers a request of another host's manager, by who is to be answered.
        failed: Takes note of a fault of its own.
    """

    def __init__(
        self,
        own: OwnManager,
        post: Callable[[ev.Event], object],
        number: Callable[[Answer], int],
        failed: Callable[[str, BaseException], object],
    ) -> None:
        self._host = own.host
        self._post = post
        self._failed = failed
        self._orders: SimpleQueue[ev.AskPeer | ev.WatchPeers | None] = SimpleQueue()
        self._selector = selectors.DefaultSelector()
        self._wakeup = Wakeup()
        self._far = FarPeers(own, post, number, self._wakeup.ring)
        self._peers: dict[str, _Peer] = {}
        self._watched: tuple[str, ...] = ()
        self._folder: FolderWatch | None = None
        self._again_at: float | None = None
        self._thread: threading.Thread | None = None  # begun with the first order

    def order(self, what: ev.AskPeer | ev.WatchPeers) -> None:
        """Ask a manager, or watch others from now on."""
        self._orders.put(what)
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="peers", daemon=True)
            self._thread.start()
        self._wakeup.ring()

    def end(self) -> None:
        """End all connections."""
        self._orders.put(None)
        self._wakeup.ring()
        if self._thread is not None:
            self._thread.join()

    def close(self) -> None:
        """End all connections, and let go of all descriptors."""
        self.end()
        self._selector.close()
        self._wakeup.close()

    def _run(self) -> None:
        self._selector.register(self._wakeup.fileno(), selectors.EVENT_READ)
        try:
            while self._turn():
                pass
        except Exception as error:
            self._failed("peers", error)
        finally:
            for peer in self._peers.values():
                peer.close()
            self._far.close()
            if self._folder is not None:
                self._folder.close()

    def _turn(self) -> bool:
        """Wait for something, and do what it calls for; return whether to go on."""
        moments = [each for each in (self._again_at, self._far.due_at) if each is not None]
        wait_s = max(0.0, min(moments) - time.monotonic()) if moments else None
        ready = {key.fd for key, _ in self._selector.select(wait_s)}
        self._wakeup.hush()
        for name, peer in list(self._peers.items()):
            if peer.process in ready:
                self._drop(name)
                self._post(ev.PeerLost(name, absent(name)))
        if self._folder is not None:
            self._folder.take()
        while True:
            try:
                order = self._orders.get_nowait()
            except Empty:
                break
            if order is None:
                return False
            if isinstance(order, ev.WatchPeers):
                self._watch(tuple(name for name in order.peers if not host_of(name)))
                self._far.watch(tuple(filter(host_of, order.peers)))
            elif host_of(order.peer):
                self._far.ask(order)
            else:
                self._ask(order)
        self._seek()
        self._far.run()
        return True

    def _ask(self, asked: ev.AskPeer) -> None:
        def answer(reply: Reply) -> None:
            self._post(ev.PeerAnswered(asked.number, reply.text, reply.error))

        try:
            peer = self._peers.get(asked.peer) or self._find(asked.peer)
            peer.link.ask_later(peer.key, asked.text, asked.timeout_s, answer)
        except RtkitError as error:
            answer(failure(error))

    def _find(self, name: str) -> _Peer:
        peer = self._peers[name] = _Peer(self._host, name)
        self._selector.register(peer.process, selectors.EVENT_READ)
        self._post(ev.PeerFound(name))
        return peer

    def _drop(self, name: str) -> None:
        peer = self._peers.pop(name)
        self._selector.unregister(peer.process)
        peer.close()

    def _watch(self, names: tuple[str, ...]) -> None:
        for name in [each for each in self._peers if each not in names]:
            self._drop(name)
        lost = [each for each in names if each not in self._watched]
        self._watched = names
        for name in lost:
            if name not in self._peers and places.owner(name) is None:
                self._post(ev.PeerLost(name, absent(name)))

    def _seek(self) -> None:
        """Look for the peers that are not there, at once and whenever a manager may have begun."""
        self._again_at = None
        missing = [name for name in self._watched if name not in self._peers]
        self._listen(is_wanted=bool(missing))  # first: none that begins meanwhile is missed
        for name in missing:
            try:
                self._find(name)
            except RtkitError:
                if self._folder is None or places.owner(name) is not None:
                    self._again_at = time.monotonic() + _AGAIN_S

    def _listen(self, *, is_wanted: bool) -> None:
        """Watch the folder of sockets, or leave that."""
        if is_wanted and self._folder is None:
            with suppress(Refused):  # no watch is left: it is looked now and then
                self._folder = FolderWatch(places.runtime_dir())
                self._selector.register(self._folder.fileno(), selectors.EVENT_READ)
        elif not is_wanted and self._folder is not None:
            self._selector.unregister(self._folder.fileno())
            self._folder.close()
            self._folder = None


def absent(name: str) -> str:
    """Return the text that a manager does not run."""
    return f"manager {name} is not running"
