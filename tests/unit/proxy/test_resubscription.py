"""Listening at an owner that has just come or is about to go: nothing is given up in passing."""

from __future__ import annotations

from collections.abc import Callable

from rtkit.property.codes import PropertyError
from rtkit.property.messages import DONE, Answer, Payload, PropertyEvent
from rtkit.property.requests import Requester
from rtkit.property.subscription import Listener
from rtkit.proxy.subscriptions import RelayedSubscriptions
from rtkit.wires.provider_connection import Answering, EventHandler, Gone, over

Placed = Callable[["Asked | PropertyError"], None]


class Asked:
    """A connection that answers when it is told to."""

    def __init__(self) -> None:
        self.answer: Answering | None = None
        self.hear: EventHandler | None = None

    def start(self, gone: Gone) -> None: ...

    def ask(self, target: str, payload: Payload | None, id: str, answer: Answering) -> None: ...

    def has_room(self, name: str) -> bool:
        return True

    def listen(self, name: str, wish: str, hear: EventHandler, answer: Answering) -> None:
        assert self.answer is None, "asked again before it has answered"
        self.answer, self.hear = answer, hear

    def leave(self, name: str) -> None: ...

    def check(self, now: float) -> None: ...

    def close(self) -> None: ...

    def say(self, reply: Answer) -> None:
        answer, self.answer = self.answer, None
        assert answer is not None
        answer(reply)


class Way:
    """An uplink with one connection."""

    def __init__(self) -> None:
        self.is_up = True
        self.connection = Asked()

    def place(self, name: str, placed: Placed) -> None:
        placed(self.connection if self.is_up else PropertyError("no-service", "it is away"))


class Here(Requester):
    def listen(self, listener: Listener) -> None:
        self.listener = listener

    def unlisten(self, listener: Listener) -> None: ...


class Scene:
    """Somebody who listens through a proxy, at a time of their own."""

    def __init__(self) -> None:
        self.now = 0.0
        self.way = Way()
        self.listenings = RelayedSubscriptions(self.way, str, lambda: self.now)  # type: ignore[arg-type]
        self.caller = Here()
        self.replies: list[Answer] = []

    def begin(self, caller: Requester) -> None:
        self.listenings.begin("count", {}, caller, self.replies.append)

    def listening(self) -> Scene:
        self.begin(self.caller)
        self.way.connection.say(DONE)
        self.heard("7")
        return self

    def heard(self, payload: str) -> PropertyEvent | None:
        assert self.way.connection.hear is not None
        self.way.connection.hear(PropertyEvent("count", payload, 1.0, 1))
        return self.taken()

    def taken(self) -> PropertyEvent | None:
        return self.caller.listener.take(self.now)

    def is_asking(self) -> bool:
        return self.way.connection.answer is not None


def test_an_owner_that_goes_while_it_is_asked_is_asked_anew() -> None:
    scene = Scene().listening()
    for code in ("no-service", "timeout", "busy"):
        scene.listenings.went()
        scene.listenings.came()
        scene.way.connection.say(Answer("in passing", code))
        scene.listenings.tick()
        assert not scene.is_asking(), "it is not pestered"
        scene.now += 1.0
        scene.listenings.tick()
        scene.listenings.tick()
        assert scene.is_asking()
        scene.way.connection.say(DONE)
        event = scene.heard("8")
        assert event is not None
        assert event.payload == "8"


def test_an_owner_that_is_away_is_not_asked() -> None:
    scene = Scene().listening()
    scene.way.is_up = False
    scene.listenings.went()
    stale = scene.taken()
    assert stale is not None
    assert stale.quality == "stale"
    scene.now += 100.0
    scene.listenings.tick()
    assert not scene.is_asking()
    scene.begin(Here())
    assert [each.error for each in scene.replies] == ["", "no-service"], "told at once, not later"


def test_an_owner_that_goes_before_its_first_value_has_come_is_told_as_away() -> None:
    scene = Scene()
    scene.begin(scene.caller)
    scene.way.connection.say(DONE)
    scene.listenings.went()
    stale = scene.taken()
    assert stale is not None
    assert (stale.name, stale.payload, stale.quality, stale.code) == ("count", "", "stale", "")
    scene.listenings.went()
    assert scene.taken() is None, "it is told once"
    scene.listenings.came()
    scene.way.connection.say(DONE)
    event = scene.heard("7")
    assert event is not None
    assert (event.payload, event.quality) == ("7", "good")


def test_an_owner_that_goes_again_before_it_has_answered_is_told_as_away() -> None:
    scene = Scene().listening()
    scene.listenings.went()
    scene.taken()
    scene.listenings.came()
    assert scene.heard("8") is not None, "its value may overtake its answer"
    scene.way.connection.say(Answer("the connection has ended", "no-service"))
    scene.listenings.went()
    stale = scene.taken()
    assert stale is not None
    assert (stale.payload, stale.quality) == ("8", "stale")


def test_an_owner_that_no_longer_has_it_ends_it() -> None:
    scene = Scene().listening()
    scene.listenings.went()
    scene.taken()
    scene.listenings.came()
    scene.way.connection.say(Answer("no such property", "unknown"))
    last = scene.taken()
    assert last is not None
    assert last.code == "unknown"
    scene.now += 100.0
    scene.listenings.tick()
    assert not scene.is_asking()


def test_what_ends_a_listening_that_is_renewed() -> None:
    for reply in (DONE, Answer("", "no-service"), Answer("", "timeout"), Answer("", "busy")):
        assert over("count", reply) is None
    gone = over("count", Answer("no such property", "unknown"))
    assert gone is not None
    assert (gone.name, gone.quality, gone.code) == ("count", "bad", "unknown")
