"""The router between hosts: what one that was taken over sends, and poses as, goes nowhere."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
import zenoh
from waiting import until

from rtkit.hosts.link_process import rules
from rtkit.link.zenoh import ask_router_id, open_between, open_listener

NEAR, FAR, OTHER = (f"rt/default/{each}/manager/@/x" for each in ("near", "robot1", "robot2"))
WIDE = ("**", "rt/**", "rt/default/*/manager/@/**", "rt/default/*/manager/@/x")


@pytest.fixture
def routers(tmp_path: Path) -> Iterator[tuple[Any, Any]]:
    with _joined(tmp_path) as ends:
        yield ends


class _joined(ExitStack):  # noqa: N801  read as a verb
    """Routers here and there, and the one between them; the far one may pose as the near one."""

    def __init__(self, folder: Path, *, poses: bool = False) -> None:
        super().__init__()
        ends = [f"unixsock-stream/{folder}/{each}" for each in ("near", "far")]
        self.near = self._kept(open_listener(ends[0]))
        id = ask_router_id(ends[0])
        more = {"id": json.dumps(id)} if poses else {}
        self.far = self._kept(open_listener(ends[1], more=more))
        self._kept(open_between(ends, rules(id, "robot1"), 60_000))

    def _kept(self, session: Any) -> Any:
        self.callback(session.close)
        return session

    def __enter__(self) -> Any:
        return self.near, self.far


def _heard(session: Any) -> list[str]:
    heard: list[str] = []
    for key in (NEAR, FAR, OTHER):
        session.declare_subscriber(key, lambda each: heard.append(each.payload.to_string()))
    return heard


def _replies(session: Any, key: str) -> list[str]:
    found = session.get(key, timeout=0.5, consolidation=zenoh.ConsolidationMode.NONE)
    return [each.ok.payload.to_string() for each in found if each.ok]


def test_a_far_host_publishes_below_its_own_name_only(routers: tuple[Any, Any]) -> None:
    near, far = routers
    heard = _heard(near)
    own = far.declare_publisher(FAR)
    until(lambda: own.matching_status.matching, "the far side knows who listens to it")
    for key in (NEAR, OTHER, *WIDE):
        far.put(key, f"posed as {key}")
        far.declare_publisher(key).put(f"posed as {key}")
        far.delete(key)
    own.put("own")
    until(lambda: "own" in heard, "what is its own arrives")
    assert heard == ["own"]


def test_a_far_host_asks_and_answers_for_nobody_else(routers: tuple[Any, Any]) -> None:
    near, far = routers
    asked: list[str] = []

    def serve(session: Any, key: str, text: str) -> None:
        def answer(query: zenoh.Query) -> None:
            asked.append(text)
            query.reply(query.key_expr, text)

        session.declare_queryable(key, answer)

    serve(near, NEAR, "near")
    for key in (NEAR, OTHER, *WIDE):
        serve(far, key, "posed")
    for key in (NEAR, OTHER):
        far.liveliness().declare_token(key)
    serve(far, FAR, "own")
    far.liveliness().declare_token(FAR)
    until(lambda: "own" in _replies(near, FAR), "it answers for itself")
    assert _replies(near, NEAR) == ["near"]
    assert not _replies(near, OTHER)
    asked.clear()
    assert not [text for key in (NEAR, OTHER) for text in _replies(far, key) if text == "near"]
    assert "near" not in asked
    alive = [str(each.ok.key_expr) for each in near.liveliness().get("rt/default/*/**", timeout=1)]
    assert NEAR not in alive
    assert OTHER not in alive


def test_a_far_host_hears_nothing_of_others(routers: tuple[Any, Any]) -> None:
    near, far = routers
    heard = _heard(far)
    for key in WIDE:
        far.declare_subscriber(key, lambda each: heard.append(each.payload.to_string()))
    far.declare_queryable(FAR, lambda query: query.reply(FAR, "own"))
    until(lambda: _replies(near, FAR), "what was declared before is known here")
    for key in (NEAR, OTHER):
        near.put(key, "news")
    assert _replies(near, FAR) == ["own"]  # which went the same way, later
    assert not heard


def test_who_poses_as_the_router_here_is_not_joined(tmp_path: Path) -> None:
    with _joined(tmp_path, poses=True) as (near, far):
        asked: list[str] = []
        near.declare_queryable(NEAR, lambda query: asked.append("asked"))
        assert not _replies(far, NEAR)
        assert not asked


def test_data_pass_only_where_the_host_is_an_end(routers: tuple[Any, Any]) -> None:
    near, far = routers
    own = ("rtd/default/near/robot1/w", "rtd/default/robot1/near/w")
    others = ("rtd/default/near/robot2/w", "rtd/default/robot2/near/w", "rtd/default/near/w")
    heard: list[tuple[str, str, str]] = []

    def listen(session: Any, where: str, key: str) -> None:
        def take(sample: zenoh.Sample) -> None:
            heard.append((sample.payload.to_string(), where, str(sample.key_expr)))

        session.declare_subscriber(key, take)

    for key in (own[0], *others):
        listen(near, "near", key)
    for key in (own[1], *others, "rtd/**"):
        listen(far, "far", key)
    ways = {"far": (near, "near", own[1]), "near": (far, "far", own[0])}
    for session, _, key in ways.values():
        publisher = session.declare_publisher(key)
        until(lambda p=publisher: p.matching_status.matching, f"who listens to {key} is known")
    for session, name in ((near, "near"), (far, "far")):
        for key in others:
            session.put(key, name)
    far.put("rtd/**", "far")
    for session, name, key in ways.values():
        session.put(key, name)
    own_data = {(name, where, key) for where, (_, name, key) in ways.items()}
    until(lambda: own_data <= {*heard}, "own data arrive")
    assert {each for each in heard if each[0] != each[1]} == own_data


def test_a_far_manager_asks_by_its_own_name_only(routers: tuple[Any, Any]) -> None:
    near, far = routers
    keys = {by: f"rt/default/near/manager/@p/{by}/manager" for by in ("robot1", "robot2")}
    for by, key in keys.items():
        near.declare_queryable(key, lambda query, by=by: query.reply(query.key_expr, by))
    until(lambda: _replies(far, keys["robot1"]), "its question is answered")
    assert _replies(far, keys["robot2"]) == []
    assert _replies(far, "rt/default/near/manager/@p/*/manager") == []


def test_services_of_a_far_host_ask_those_that_let_it(routers: tuple[Any, Any]) -> None:
    near, far = routers
    own, posed = (f"rt/default/near/@ps/@p/{by}/home/lamp" for by in ("robot1", "robot2"))
    plain, heard = "rt/default/near/@ps/home/lamp", list[str]()
    tokens = []
    for key in (own, posed, plain):
        tokens.append(near.liveliness().declare_token(f"{key}/@"))
        near.declare_queryable(f"{key}/@/**", lambda query: query.reply(query.key_expr, "lit"))
        far.declare_subscriber(f"{key}/@e/x", lambda each: heard.append(each.payload.to_string()))
    until(lambda: _replies(far, f"{own}/@/level"), "it may ask by its own name")
    assert [_replies(far, f"{key}/@/level") for key in (posed, plain)] == [[], []]
    seen = [
        str(each.ok.key_expr)
        for wide in ("@ps/**/@", "@ps/@p/*/**/@")
        for each in far.liveliness().get(f"rt/default/near/{wide}", timeout=1)
    ]
    assert seen == [f"{own}/@"]
    event = near.declare_publisher(f"{own}/@e/x")
    until(lambda: event.matching_status.matching, "who listens is known")
    for key in (posed, plain):
        near.put(f"{key}/@e/x", "of others")
    event.put("own")
    until(lambda: heard, "its own events arrive")
    assert heard == ["own"]


def test_a_giant_message_is_dropped_and_the_link_stays(routers: tuple[Any, Any]) -> None:
    near, far = routers
    sizes: list[int] = []
    near.declare_subscriber(FAR, lambda each: sizes.append(len(each.payload)))
    own = far.declare_publisher(FAR, congestion_control=zenoh.CongestionControl.BLOCK)
    until(lambda: own.matching_status.matching, "the far side knows who listens to it")
    own.put(bytes(130 << 20))
    own.put(b"small")
    until(lambda: sizes, "the small one arrives")
    assert sizes == [5]
