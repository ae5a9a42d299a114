"""Which systems a core has followed: kept, refused, told, remembered."""

from __future__ import annotations

import json

import statekit
from fake_shell import FakeShell

from rtkit.deployment.delta import TREE, Delta, FullSnapshot
from rtkit.deployment.facts import Followed
from rtkit.deployment.states.states_text import spec_to_text
from rtkit.deployment.user_events import user_events
from rtkit.manager.core import events as ev
from rtkit.manager.core.follows import as_json
from rtkit.property.exchange import Reply
from rtkit.rtc.serde import decode, decode_text

NAME = statekit.SYSTEM
TEXT = spec_to_text(statekit.robot(), ["robot.xml", "1"])
LED = Followed(NAME, "explore", "standby", "start", 1, 5.0)


def asked(shell: FakeShell, text: str | None) -> Reply:
    replies: list[Reply] = []
    shell.feed(ev.FollowAsked(NAME, text, shell.requests.add(replies.append)))
    (reply,) = replies
    return reply


def said(shell: FakeShell, followed: Followed) -> Reply:
    replies: list[Reply] = []
    shell.feed(ev.FollowSaid(followed, shell.requests.add(replies.append)))
    (reply,) = replies
    return reply


def test_what_is_followed_is_kept_and_told(shell: FakeShell) -> None:
    assert asked(shell, TEXT) == Reply(f"{NAME} is followed")
    assert shell.state.snapshot().systems == (Followed(NAME),)
    assert said(shell, LED) == Reply("")
    (plain,) = json.loads(as_json(shell.state.kept))
    assert plain["system"] == NAME
    assert (plain["state"], plain["before"], plain["event"]) == ("explore", "standby", "start")
    assert plain["table"]["standby"] == {"start": "explore"}
    assert list(plain["conditions"]) == ["motor_lost"]
    heir = FakeShell()
    heir.feed(ev.StoreRead([(*key, text) for key, text in shell.rows.items()]))
    assert heir.state.kept.followed == {NAME: TEXT}
    assert heir.state.snapshot().systems == (LED,)
    assert asked(heir, None) == Reply(f"{NAME} is followed no more")
    assert {kind for kind, _ in heir.rows} <= {"boot"}
    assert asked(heir, None).error == "not-found"
    assert heir.state.snapshot().systems == ()


def test_another_profile_of_that_name_is_refused_until_it_has_ended(shell: FakeShell) -> None:
    asked(shell, TEXT)
    said(shell, LED)
    assert asked(shell, TEXT) == Reply(f"{NAME} is followed already")
    assert shell.state.snapshot().systems == (LED,)
    other = spec_to_text(statekit.robot(), ["other.xml", "2"])
    reply = asked(shell, other)
    assert reply.error == "refused"
    assert "as another profile tells it (robot.xml)" in reply.text
    said(shell, Followed(NAME, "degraded", is_over=True, why="no luck"))
    assert asked(shell, other) == Reply(f"{NAME} is followed")
    assert shell.state.snapshot().systems == (Followed(NAME),)


def test_nothing_is_begun_that_cannot_be_kept(shell: FakeShell) -> None:
    asked(shell, TEXT)
    shell.disk = "disk full"
    assert said(shell, LED).error == "refused"
    shell.state.kept.followed.clear()
    reply = asked(shell, TEXT)
    assert (reply.error, "disk full" in reply.text) == ("refused", True)
    assert shell.state.kept.followed == {}


def test_who_stops_follows_nothing_new_and_forgets_unless_it_comes_back() -> None:
    for is_kept in (True, False):
        shell = FakeShell()
        asked(shell, TEXT)
        shell.make("A", "s")
        shell.feed(ev.StopRequested(is_kept=is_kept))
        assert asked(shell, TEXT).error == "refused"
        assert (("followed", NAME) in shell.rows) is is_kept


def test_what_a_follower_says_of_what_is_followed_no_more_is_dropped(shell: FakeShell) -> None:
    assert said(shell, LED) == Reply("")
    assert shell.state.snapshot().systems == ()


def test_listeners_of_all_kinds_count(shell: FakeShell) -> None:
    published: list[ev.Publish] = []

    def feed(event: ev.Event) -> None:
        found = shell.core.handle(event, shell.now)
        published.extend(each for each in found if isinstance(each, ev.Publish))

    feed(ev.ListenersChanged(TREE, True, "follower"))
    feed(ev.ListenersChanged(TREE, True))
    feed(ev.ListenersChanged(TREE, False))
    published.clear()
    shell.state.names = ("localhost/other.mgr",)
    feed(ev.TimerExpired())
    assert len(published) == 1
    feed(ev.ListenersChanged(TREE, False, "follower"))
    shell.state.names = ()
    feed(ev.TimerExpired())
    assert len(published) == 1


def test_each_transition_is_an_event_for_those_who_listen(shell: FakeShell) -> None:
    published: list[Delta] = []
    replies: list[Reply] = []
    shell.feed(ev.SnapshotRequested(shell.requests.add(replies.append)))
    facts = decode_text(FullSnapshot, replies[0].value()).facts
    told: list[tuple[str, str]] = []
    for event in (
        ev.FollowAsked(NAME, TEXT, shell.requests.add(replies.append)),
        ev.FollowSaid(LED, shell.requests.add(replies.append)),
        ev.FollowSaid(
            Followed(NAME, "explore", waits="rtapply", count=1), shell.requests.add(replies.append)
        ),
        ev.FollowSaid(
            Followed(NAME, "x", count=1, why="no", is_over=True), shell.requests.add(replies.append)
        ),
        ev.FollowAsked(NAME, None, shell.requests.add(replies.append)),
    ):
        found = shell.feed(event)
        published += [decode(Delta, each.message) for each in found if isinstance(each, ev.Publish)]
        for delta in published:
            told += [(each.event, each.detail) for each in user_events(facts, delta)]
            facts = type(facts)(**{**_fields(facts), "systems": delta.systems or ()})
        published.clear()
    assert told == [
        ("FOLLOWED", ""),
        ("explore", "standby -start-> explore"),
        ("WAITS", "rtapply"),
        ("TRANSITION_FAILED", "no"),
        ("NOT_FOLLOWED", "that transition failed"),
        ("NOT_FOLLOWED", ""),
    ]


def _fields(facts: object) -> dict[str, object]:
    return {name: getattr(facts, name) for name in type(facts).__slots__}
