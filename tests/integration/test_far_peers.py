"""Managers of other hosts, asked through a real router: awaited as long as who asks has time."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import ExitStack
from typing import NamedTuple

import pytest

from rtkit.link import places, zenoh_keys
from rtkit.link.zenoh import ZenohLink, open_client, open_listener, unix_endpoint
from rtkit.manager.core import events as ev
from rtkit.manager.peers import far_peers
from rtkit.manager.peers.far_peers import FarPeers
from rtkit.property.exchange import Reply

PEER = "robot2/manager"


class Own(NamedTuple):
    """This manager."""

    host: str = "robot1"
    name: str = "manager"


class Asking(ExitStack):
    """The one that asks, its router, and what it has posted."""

    def __init__(self) -> None:
        super().__init__()
        self.rung = threading.Event()
        self.posted: list[ev.Event] = []
        self._endpoint = unix_endpoint(places.manager_socket("manager"))
        self.callback(open_listener(self._endpoint).close)
        self.peers = FarPeers(Own(), self._take, lambda _: 1, self.rung.set)
        self.callback(self.peers.close)

    def _take(self, event: ev.Event) -> None:
        self.posted.append(event)
        self.rung.set()

    def ask(self, timeout_s: float) -> None:
        self.peers.ask(ev.AskPeer(7, PEER, "question", timeout_s))
        self.peers.run()

    def answer(self) -> None:
        """Have the peer there, which answers."""
        link = ZenohLink(open_client(self._endpoint, 2.0))
        self.callback(link.close)
        link.answer(zenoh_keys.question(PEER, "robot1/manager"), lambda r: r.answer(Reply("yes")))

    def await_answer(self) -> ev.PeerAnswered:
        while True:
            for each in self.posted:
                if isinstance(each, ev.PeerAnswered):
                    return each
            assert self.rung.wait(10.0)
            self.rung.clear()
            self.peers.run()


@pytest.fixture
def asking(place: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[Asking]:
    monkeypatch.setattr(far_peers, "_PATIENCE_S", 0.0)
    with Asking() as made:
        made.rung.clear()
        yield made


@pytest.mark.parametrize("is_watched", [False, True])
def test_a_peer_is_awaited_as_long_as_who_asks_has_time(asking: Asking, is_watched: bool) -> None:
    if is_watched:
        asking.peers.watch((PEER,))
    asking.ask(10.0)
    assert not [each for each in asking.posted if isinstance(each, ev.PeerAnswered)]
    asking.answer()
    assert asking.await_answer() == ev.PeerAnswered(7, "yes", "")


def test_a_peer_that_is_let_go_is_kept_for_who_asks_it_again(
    asking: Asking, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(far_peers, "_LINGER_S", 0.0)
    asking.peers.watch((PEER,))
    asking.peers.watch(())
    asking.ask(10.0)
    asking.answer()
    assert asking.await_answer() == ev.PeerAnswered(7, "yes", "")


def test_who_has_no_time_left_is_told_that_a_peer_is_away(asking: Asking) -> None:
    asking.ask(0.0)
    told = asking.await_answer()
    assert (told.number, told.error) == (7, "unreachable")
    assert told.text.startswith("host robot2 cannot be reached: ")
