"""Names of a served object that are another owner's, over every endpoint."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections import ChainMap
from collections.abc import Iterator
from contextlib import ExitStack
from queue import SimpleQueue
from time import monotonic
from typing import Any

import pytest
from asking import code, until

import rtkit
from rtkit.errors import Malformed
from rtkit.link import places
from rtkit.proxy.bridge import bridge
from rtkit.serving.workers import LATE
from rtkit.wires.line.client import connect_unix

_BOUND_S = 20.0


class Robot:
    """Robot that a group has."""

    def __init__(self, x: float = 0.0) -> None:
        self.x = x
        self.arm = {"angle": 0.5}

    def jump(self, height: float = 1.0) -> float:
        if height > 2:
            raise ValueError("too high")
        return height

    def get_seen(self, frame: str = "base") -> str:
        return frame


class Group:
    """Group of robots, each mounted under its name."""

    def __init__(self, **targets: str) -> None:
        self.size = 2
        self.robots = {name: rtkit.Mount(target) for name, target in targets.items()}


@pytest.fixture
def client() -> Iterator[rtkit.Client]:
    with rtkit.Client(timeout_s=_BOUND_S) as client:
        yield client


def serve(thing: object, name: str, **more: object) -> object:
    return rtkit.serve(thing, name, **{"is_on_zenoh": False, **more})  # type: ignore[arg-type]


@pytest.mark.parametrize("wire", ["unix", "tcp", "http", "zenoh"])
def test_all_below_a_mount_is_its_owners_over_every_endpoint(
    wire: str, place: str, client: rtkit.Client
) -> None:
    with ExitStack() as ends:
        for index in (1, 2):
            ends.enter_context(rtkit.serve(Robot(float(index)), f"robots/r{index}"))
        group = ends.enter_context(
            rtkit.serve(Group(r1="robots/r1", r2="zenoh:robots/r2"), "group", port=0, http=0)
        )
        at = {
            "unix": "group.",
            "tcp": f"tcp:localhost:{group.port}/group/",
            "http": f"http://localhost:{group.http}/ps/group/",
            "zenoh": "zenoh:group.",
        }[wire]
        assert (client.get(f"{at}robots.r1.x"), client.get(f"{at}robots.r2.x")) == (1.0, 2.0)
        client.set(f"{at}robots.r1.x", 3)
        assert client.get("robots/r1.x") == 3.0
        assert client.get(f"{at}robots.r2.seen", frame="world") == "world"
        assert client.call(f"{at}robots.r2.jump", 2) == 2.0
        assert code(lambda: client.call(f"{at}robots.r2.jump", 3)) == "bad-value"
        assert code(lambda: client.get(f"{at}robots.r1.none")) == "unknown"
        assert code(lambda: client.get(f"{at}robots.r1.x", of=1)) == "bad-parameter"
        assert code(lambda: client.get(f"{at}robots.r3.x")) == "unknown"
        assert client.get(f"{at}robots.r1.x.meta.type") == "number"
        assert "zenoh:robots/r2" in client.get(f"{at}robots.r2.meta.doc")
        changes: SimpleQueue[rtkit.PropertyChange] = SimpleQueue()
        with client.listen(f"{at}robots.r2.x", changes.put):
            assert changes.get(timeout=_BOUND_S).value == 2.0
            client.set("robots/r2.x", 4)
            assert changes.get(timeout=_BOUND_S).value == 4.0


def test_listings_and_bulk_requests_span_the_owners(place: str, client: rtkit.Client) -> None:
    with serve(Robot(1), "r1"), serve(Robot(2), "r2"), serve(Group(a="r1", b="r2"), "g"):
        assert client.get("g.properties") == ("size", "robots")
        assert client.get("g.robots") == client.get("g.robots.properties") == ("a", "b")
        assert client.get("g.robots.a") == ("jump", "x", "arm", "seen")
        deep = client.get("g.properties", all=True)
        assert deep[:4] == ("size", "robots", "robots.a", "robots.b")
        assert {"robots.a.x", "robots.b.arm.angle"} < set(deep)
        assert set(client.get("g.properties", depth=2)) == {*deep[:4]}
        assert client.get("g.properties", all=True, match="*.x") == ("robots.a.x", "robots.b.x")
        values = dict(client.get("g.properties", all=True, values=True, match="*x"))
        assert values == {"robots.a.x": 1.0, "robots.b.x": 2.0}
        rows = client.get("g.robots.properties", all=True, meta=True, match="*.x")
        assert [(row[0], row[2]) for row in rows] == [("a.x", 1.0), ("b.x", 2.0)]
        names = "(robots.b.x size robots.a.x)"
        assert client.get("g.properties", names=names, values=True) == (
            ("robots.b.x", 2.0),
            ("size", 2),
            ("robots.a.x", 1.0),
        )
        for names in ("(robots.b.y)", "(none)", "(size none robots.a.x)"):
            assert code(lambda n=names: client.get("g.properties", names=n)) == "unknown"  # type: ignore[misc]
        client.set("g.robots.properties", "((a.x 5) (a.arm.angle 1))")
        assert (client.get("r1.x"), client.get("r1.arm.angle")) == (5.0, 1)
        assert code(lambda: client.set("g.properties", "((size 1) (robots.a.x 6))")) == "bad-value"
        assert client.get("r1.x") == 5.0
        client.set("g.properties", "((size 3))")
        assert client.get("g.size") == 3


def test_a_place_in_a_service_is_mounted_too(place: str, client: rtkit.Client) -> None:
    with serve({"a": Robot(1), "b": {"c": Robot(2)}}, "r"), serve(Group(x="r.a", y="r.b.c"), "g"):
        assert client.get("g.robots.x") == ("jump", "x", "arm", "seen")
        assert client.get("g.robots.y.properties", all=1) == client.get("r.b.c.properties", all=1)
        client.set("g.robots.y.arm.angle", 0.75)
        assert client.get("r.b.c.arm.angle") == client.get("g.robots.y.arm.angle") == 0.75
        assert code(lambda: client.get("g.robots.x.c")) == "unknown"
        changes: SimpleQueue[object] = SimpleQueue()
        note = lambda change: changes.put(change.value)  # noqa: E731
        with client.listen("g.robots.y.x", note):
            assert changes.get(timeout=_BOUND_S) == 2
            client.set("r.b.c.x", 3)
            assert changes.get(timeout=_BOUND_S) == 3
        with client.listen("g.robots.y.properties", note):
            assert changes.get(timeout=_BOUND_S) == client.get("r.b.c.properties")
        assert client.get("g.robots.x.x.meta.type") == "number"


def test_while_an_owner_is_away_its_names_say_so_and_listening_goes_on_later(
    place: str, client: rtkit.Client
) -> None:
    changes: SimpleQueue[rtkit.PropertyChange] = SimpleQueue()
    with serve(Group(a="r1", b="r2"), "g"), serve(Robot(2), "r2"):
        assert code(lambda: client.get("g.robots.a.x")) == "no-service"
        until(lambda: client.ask_all([rtkit.Ask("g.robots.b.x")], _BOUND_S) == [2.0])
        values = dict(client.get("g.robots.properties", all=True, values=True, match="*[xa]"))
        assert (values["b.x"], values["a"].attributes) == (2.0, {"code": "no-service"})
        robot = serve(Robot(1), "r1")
        until(lambda: client.ask_all([rtkit.Ask("g.robots.a.x")], _BOUND_S) == [1.0])
        listening = client.listen("g.robots.a.x", changes.put)
        assert changes.get(timeout=_BOUND_S).value == 1.0
        robot.close()  # type: ignore[attr-defined]
        assert changes.get(timeout=_BOUND_S).code == "no-service"
        assert client.get("g.robots.b.x") == 2.0
        with serve(Robot(7), "r1"):
            assert changes.get(timeout=_BOUND_S)[1:5:3] == (7.0, "")
            listening.close()


def test_mounts_come_and_go_while_served_and_listeners_hear_of_it(
    place: str, client: rtkit.Client
) -> None:
    names: SimpleQueue[rtkit.PropertyChange] = SimpleQueue()
    changes: SimpleQueue[rtkit.PropertyChange] = SimpleQueue()
    group = Group()
    with serve(group, "g"), serve(Robot(1), "r1"), serve(Robot(2), "r2"):
        group.robots["a"] = rtkit.Mount("r1")
        assert client.get("g.robots.a.x") == 1.0
        with client.listen("g.robots.properties", names.put):
            assert names.get(timeout=_BOUND_S).value == ("a",)
            with client.listen("g.robots.a.x", changes.put):
                assert changes.get(timeout=_BOUND_S).value == 1.0
                group.robots["b"] = rtkit.Mount("r2")
                assert names.get(timeout=_BOUND_S).value == ("a", "b")
                del group.robots["a"]
                assert names.get(timeout=_BOUND_S).value == ("b",)
                assert changes.get(timeout=_BOUND_S).code == "unknown"
        assert code(lambda: client.get("g.robots.a.x")) == "unknown"
        group.robots["b"] = rtkit.Mount("r1")
        until(lambda: client.get("g.robots.b.x") == 1.0)
        del group.robots["b"]
        assert code(lambda: client.get("g.robots.b.x")) == "unknown"


def test_widgets_of_what_is_mounted_are_named_as_they_are_there(
    place: str, client: rtkit.Client
) -> None:
    def widgets(target: str) -> dict[str, dict[str, str]]:
        def of(gui: rtkit.Element) -> dict[str, dict[str, str]]:
            below = (of(each) for each in gui.children if "argument" not in each.attributes)
            return dict(ChainMap({gui.attributes["name"]: dict(gui.attributes)}, *below))

        return of(client.get(target))

    rules = "deny unix * SET robots.c.x"
    with serve(Group(a="r1", b="r2.arm", c="r2"), "g", rules=rules), serve(Robot(2), "r2"):
        until(lambda: {"robots.b.angle", "robots.c.x"} <= widgets("g.gui").keys())
        found = widgets("g.gui")
        assert found["robots.a"]["away"] == "true"
        assert found["robots.b.angle"]["kind"] == "number"
        assert found["robots.c"]["kind"] == "group"
        assert found["robots.c.x"]["access"] == "r"
        assert widgets("g.robots.c.gui").keys() <= found.keys()
        assert widgets("g.robots.c.arm.angle.gui").keys() == {"robots.c.arm.angle"}
        assert code(lambda: client.get("g.robots.a.gui")) == "no-service"
        with serve(Robot(1), "r1"):
            until(lambda: "robots.a.x" in widgets("g.gui"))
            assert "away" not in widgets("g.gui")["robots.a"]


def test_a_listing_above_shows_of_a_place_what_is_there(place: str, client: rtkit.Client) -> None:
    with serve(Robot(2.0), "r"), serve(Group(a="r.arm", b="r", c="gone"), "g"):
        until(lambda: client.ask_all([rtkit.Ask("g.robots.b.x")], 5.0) == [2.0])
        names = client.get("g.properties", all=True)
        assert [each for each in names if each.startswith("robots.a.")] == ["robots.a.angle"]
        assert dict(client.get("g.properties", all=True, values=True))["robots.a.angle"] == 0.5
        deep = ("size", "robots", "robots.a", "robots.b", "robots.c", "robots.a.angle")
        assert client.get("g.properties", depth=3)[:6] == deep
        assert "robots.b.arm.angle" not in client.get("g.properties", depth=3)
        assert client.get("g.properties", values=True) == (("size", 2),)
        (wrong,) = client.ask_all([rtkit.Ask("g.properties", parameters={"depth": "x"})], 5.0)
        assert wrong.code == "bad-parameter"


@pytest.mark.parametrize("scheme", ["", "zenoh:", "tcp:", "http:"])
def test_services_mount_each_other_in_any_order_and_again(
    scheme: str, place: str, client: rtkit.Client
) -> None:
    """Whoever was there first, or is started anew; what goes round ends at once, and says so."""
    ports: dict[str, int] = {}

    def start(name: str, peer: str) -> object:
        kind = {"tcp:": "port", "http:": "http"}.get(scheme, "")
        addresses = {
            "tcp:": f"tcp:localhost:{ports[peer]}/{peer}",
            "http:": f"http://localhost:{ports[peer]}/ps/{peer}",
        }
        address = addresses.get(scheme, scheme + peer)
        thing = {"v": name, "peer": rtkit.Mount(address, timeout_s=1.0)}
        more = {kind: ports[name]} if kind else {}
        return serve(thing, name, is_on_zenoh=scheme == "zenoh:", **more)

    for name in "ab":
        with socket.socket() as end:
            end.bind(("127.0.0.1", 0))
            ports[name] = end.getsockname()[1]
    ends: dict[str, Any] = {"a": start("a", "b"), "b": start("b", "a")}
    for again in ("a", "b", ""):
        for name, peer in ("ab", "ba"):
            far = ("peer.peer.peer", "peer.peer.peer.peer")
            gone_round = [rtkit.Ask(f"{name}.{way}.v") for way in far]
            until(lambda n=name, p=peer: client.ask_all([rtkit.Ask(f"{n}.peer.v")], 5.0) == [p])  # type: ignore[misc]
            until(lambda n=peer, p=name: client.ask_all([rtkit.Ask(f"{n}.peer.v")], 5.0) == [p])  # type: ignore[misc]
            for refused in client.ask_all(gone_round, _BOUND_S):
                assert (refused.code, "proxy of itself" in str(refused)) == ("no-service", True)
            assert client.get(f"{name}.peer.peer.v") == name
            began = monotonic()
            values = dict(client.get(f"{name}.properties", all=True, values=True))
            assert (values["v"], values["peer.v"], len(values)) == (name, peer, 3)
            assert values["peer.peer"].leaf == "that would be a proxy of itself"
            assert monotonic() - began < 0.8, "nobody was waited for"
            assert client.get(f"{name}.peer.properties", all=1, timeout=2) == ("v", "peer")
        if again:
            ends[again].close()
            ends[again] = start(again, "b" if again == "a" else "a")
    for end in ends.values():
        end.close()


def test_no_request_goes_round_a_ring(place: str, client: rtkit.Client) -> None:
    """By way of others, at a place below itself, through a proxy, and by listening."""
    ring = {"a": "b", "b": "c", "c": "a"}
    with ExitStack() as ends:
        for name, target in ring.items():
            ends.enter_context(serve({"v": name, "next": rtkit.Mount(target)}, name))  # type: ignore[arg-type]
        ends.enter_context(serve({"me": rtkit.Mount("self.me")}, "self"))  # type: ignore[arg-type]
        for name, far in zip(ring, "cab", strict=True):
            ask = rtkit.Ask(f"{name}.next.next.v")
            until(lambda a=ask, f=far: client.ask_all([a], 5.0) == [f])  # type: ignore[misc]
        assert [client.get(f"a.{way}v") for way in ("", "next.", "next.next.")] == ["a", "b", "c"]
        assert client.get("a.next.next.next.v") == "a"
        for way in ("a.next.next.next.next.v", "self.me.x"):
            assert code(lambda w=way: client.get(w)) == "no-service"  # type: ignore[misc]
            assert code(lambda w=way: client.listen(w, print)) == "no-service"  # type: ignore[misc]
        assert len(client.get("a.properties", all=True)) == 6
        assert 'round="true"' in client.payload(rtkit.Ask("a.gui"), 5.0)
        ends.enter_context(bridge("a", f"unix:{place}/p.sock", prefix="p"))
        with serve({"v": 0, "back": rtkit.Mount(f"unix:{place}/p.sock")}, "d"):
            assert client.get("d.back.p.next.v") == "b"
            for name in "abc":
                assert client.get(f"d.back.p.{'next.' * 'abc'.index(name)}v") == name
            assert code(lambda: client.get("d.back.p.next.next.next.next.v")) == "no-service"


def test_rules_of_an_endpoint_hold_for_what_is_mounted(place: str, client: rtkit.Client) -> None:
    rules = "deny unix * SET robots.*"
    with serve(Robot(1), "r1"), serve(Group(a="r1"), "g", rules=rules):
        assert client.get("g.robots.a.x") == 1.0
        assert code(lambda: client.set("g.robots.a.x", 2)) == "denied"
        assert client.get("g.robots.a.x.meta.access") == "r"
        assert client.get("r1.x") == 1.0


def test_a_mount_has_a_target_and_one_that_is_no_address_is_not_there(
    place: str, client: rtkit.Client
) -> None:
    for wrong in ("", 3, None):
        with pytest.raises(Malformed, match="not a service to mount"):
            rtkit.Mount(wrong)  # type: ignore[arg-type]
    with serve(rtkit.mounts(a="ftp:x", b="no such/*"), "g"):  # type: ignore[arg-type]
        assert code(lambda: client.get("g.a.x")) == "no-service"
        assert code(lambda: client.get("g.b.x")) == "no-service"


def test_an_owner_that_is_stopped_delays_no_other_and_is_named_in_listings(
    place: str, client: rtkit.Client
) -> None:
    program = """
import rtkit, sys
class Robot:
    x = 1
with rtkit.serve(Robot(), 'r1', is_on_zenoh=False):
    print('up', flush=True)
    sys.stdin.read()
"""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    owner = subprocess.Popen([sys.executable, "-c", program], **pipes)  # type: ignore[call-overload]
    assert owner.stdout.readline() == b"up\n"
    with serve(Robot(2.0), "r2"), serve(Group(a="r1", b="r2"), "g"):
        assert client.get("g.robots.a.x") == 1
        owner.send_signal(signal.SIGSTOP)
        os.waitpid(owner.pid, os.WUNTRACED)
        asks = [rtkit.Ask("g.robots.a.x"), rtkit.Ask("g.robots.b.x")]
        slow, quick = client.ask_all(asks, 0.3)
        assert (slow.code, quick) == ("timeout", 2.0)
        values = dict(client.get("g.robots.properties", all=True, values=True))
        assert (values["b.x"], values["a"].attributes) == (2.0, {"code": "timeout"})
        with socket.socket(socket.AF_UNIX) as end, end.makefile() as replies:
            end.connect(places.service_socket("g"))
            end.sendall(b"GET robots.a.x?timeout=0.2\n")
            assert replies.readline() == f"! timeout r1: {LATE.payload}\n"
        with connect_unix(places.service_socket("g"), 0.4) as lines:
            began = monotonic()
            with pytest.raises(rtkit.errors.Unreachable, match=r"no answer within 0\.4 s"):
                lines.ask("robots.a.x")
            assert monotonic() - began < 0.4 + 0.3, "it waits once"
        owner.send_signal(signal.SIGCONT)
        assert client.get("g.robots.a.x") == 1
    owner.communicate(b"")
