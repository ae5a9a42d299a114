"""Asks managers of other hosts, and is asked by them, through the routers that link the hosts.

A peer is there while somebody answers at the key that it has for this manager alone; its routers
tell when that changes. It declares that key when it is told to expect this one, or has half of a
connector that leads here.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from queue import Empty, SimpleQueue
from typing import Protocol

from rtkit.errors import RtkitError, Unreachable
from rtkit.link import host_links, places, zenoh_keys
from rtkit.link.zenoh import ZenohLink, open_client, unix_endpoint
from rtkit.manager.core import events as ev
from rtkit.manager.core.requests import Answer
from rtkit.property.exchange import Reply, Request, failure
from rtkit.rtc.far_ends import host_of, on_host

_OPEN_S = 2.0
"""How long the router of a manager here may take to let this one in [s]."""
_PATIENCE_S = 2.0
"""How long a peer is looked for, that nobody asks, before it is told to be away [s]."""
_PART = 0.8
"""Part of the time of a request for which its peer is looked for; the rest is for saying so."""
_LINGER_S = 2.0
"""How long the last answer to a peer may take: until then it finds this manager [s]."""


class OwnManager(Protocol):
    """Names of this manager and its host."""

    host: str
    name: str


class _FarPeer:
    """A manager of another host: what is declared for it, and what waits until it is found."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.key = ""
        self.link: ZenohLink | None = None
        self.declared: list[Callable[[], object]] = []
        self.asked: list[ev.AskPeer] = []
        self.is_found = False
        self.lost_at: float | None = None  # when it is to be told that it is away
        self.leave_at: float | None = None  # when nothing is to be declared for it any more


class FarPeers:
    """Managers of other hosts; all but `ring` is called by one thread.

    Args:
        own: This manager: its name, and that of its host.
        post: Takes events, from any thread.
        number: Numbers a request, by who is to be answered; from any thread.
        ring: Has that one thread call `run`.
    """

    def __init__(
        self,
        own: OwnManager,
        post: Callable[[ev.Event], object],
        number: Callable[[Answer], int],
        ring: Callable[[], object],
    ) -> None:
        self._name = own.name
        self._own = on_host(own.name, own.host)
        self._post = post
        self._number = number
        self._ring = ring
        self._peers: dict[str, _FarPeer] = {}
        self._links: dict[str, ZenohLink] = {}
        self._news: SimpleQueue[tuple[_FarPeer, bool]] = SimpleQueue()

    @property
    def due_at(self) -> float | None:
        """The moment at which `run` is to be called next, monotonic [s]; None if nothing is due."""
        moments = (at for each in self._peers.values() for at in (each.lost_at, each.leave_at))
        return min((at for at in moments if at is not None), default=None)

    def watch(self, names: tuple[str, ...]) -> None:
        """Be there for these managers, and report whenever one is found or lost; others no more."""
        now = time.monotonic()
        for name, peer in self._peers.items():
            if name not in names and peer.leave_at is None:
                peer.leave_at = now + _LINGER_S
        for name in names:
            known = self._peers.get(name)
            if known is None:
                self._peers[name] = self._begun(_FarPeer(name))
            elif known.leave_at is not None:
                known.leave_at = None
                if known.is_found:
                    self._post(ev.PeerFound(name))

    def ask(self, asked: ev.AskPeer) -> None:
        """Ask a manager, as soon as it is found."""
        peer = self._peers.get(asked.peer)
        if peer is None:
            peer = self._peers[asked.peer] = self._begun(_FarPeer(asked.peer))
        if not peer.is_found and _is_cut_off(host_of(peer.name)):
            self._answer(asked, failure(Unreachable(why_away(peer.name))))
            return
        peer.asked.append(asked)
        if peer.leave_at is not None:  # it may be due just now, and that it is watched told next
            peer.leave_at = max(peer.leave_at, time.monotonic() + asked.timeout_s)
        if not peer.is_found:  # it may just have been told to expect this
            until = time.monotonic() + _PART * asked.timeout_s
            peer.lost_at = max(peer.lost_at or 0.0, until)

    def run(self) -> None:
        """Take note of who was found or lost, and ask what is to be asked."""
        while True:
            try:
                peer, is_found = self._news.get_nowait()
            except Empty:
                break
            if self._peers.get(peer.name) is peer and is_found is not peer.is_found:
                self._change(peer, is_found=is_found)
        now = time.monotonic()
        for peer in list(self._peers.values()):
            if peer.leave_at is not None and peer.leave_at <= now:
                self._leave(self._peers.pop(peer.name))
            elif peer.is_found:
                self._send(peer)
            elif peer.lost_at is not None and peer.lost_at <= now:
                self._lose(peer)

    def close(self) -> None:
        """Be there for nobody any more."""
        for peer in self._peers.values():
            self._leave(peer)
        self._peers.clear()
        for link in self._links.values():
            link.close()
        self._links.clear()

    def _begun(self, peer: _FarPeer) -> _FarPeer:
        peer.lost_at = time.monotonic() + _PATIENCE_S
        peer.key = zenoh_keys.question(peer.name, self._own)
        self._declare(peer)
        return peer

    def _declare(self, peer: _FarPeer) -> None:
        def note(is_found: bool) -> None:
            self._news.put((peer, is_found))
            self._ring()

        def take(request: Request) -> None:
            number, text = self._number(request.answer), request.payload or ""
            self._post(ev.PeerAsked(text, number, request.until, peer.name))

        with suppress(RtkitError):  # it is told to be away then
            peer.link = link = self._link(host_of(peer.name))
            peer.declared.append(link.answer(zenoh_keys.question(self._own, peer.name), take))
            peer.declared.append(link.notice(peer.key, note))

    def _link(self, host: str) -> ZenohLink:
        """Return a connection to the router that leads to a host."""
        name = host_links.router(host, self._name)
        if name not in self._links:
            session = open_client(unix_endpoint(places.manager_socket(name)), _OPEN_S)
            self._links[name] = ZenohLink(session)
        return self._links[name]

    def _leave(self, peer: _FarPeer) -> None:
        while peer.declared:
            peer.declared.pop()()
        for asked in peer.asked:
            self._answer(asked, failure(Unreachable(why_away(peer.name))))

    def _change(self, peer: _FarPeer, *, is_found: bool) -> None:
        peer.is_found = is_found
        if is_found:
            peer.lost_at = None
            if peer.leave_at is None:
                self._post(ev.PeerFound(peer.name))
        else:
            self._lose(peer)

    def _lose(self, peer: _FarPeer) -> None:
        peer.lost_at, asked = None, peer.asked
        peer.asked = []
        why = why_away(peer.name)
        for each in asked:
            self._answer(each, failure(Unreachable(why)))
        if peer.leave_at is None:
            self._post(ev.PeerLost(peer.name, why))

    def _send(self, peer: _FarPeer) -> None:
        asked, peer.asked = peer.asked, []
        for each in asked:
            try:
                assert peer.link is not None
                peer.link.ask_later(
                    peer.key, each.text, each.timeout_s, partial(self._answer, each)
                )
            except RtkitError as error:
                self._answer(each, failure(error))

    def _answer(self, asked: ev.AskPeer, reply: Reply) -> None:
        self._post(ev.PeerAnswered(asked.number, reply.text, reply.error))


def _is_cut_off(host: str) -> bool:
    """Return whether there is a link to a host, which is not up."""
    try:
        return bool(host_links.read(host).why)
    except Unreachable:
        return False


def why_away(peer: str) -> str:
    """Return why a manager of another host cannot be reached, as far as it is known here."""
    host, _, name = peer.partition("/")
    if not host_links.is_linked(host):
        return f"host {host} cannot be reached: it, or the host that links both, is away"
    try:
        why = host_links.read(host).why
    except Unreachable as error:
        why = str(error)
    return f"host {host} cannot be reached: {why or f'manager {name} there does not answer'}"
