"""A group of robots is driven as one: by the client of one robot, with members that come, go, die
or take their time."""

from __future__ import annotations

import os
import signal
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path

import pytest
from bots import Bot, fleet, in_processes
from waiting import until

import rtkit
from rtkit.link import places
from rtkit.services.group import Group
from rtkit.services.legged import LeggedRobot
from rtkit.services.mobilerobot import DifferentialRobot
from rtkit.services.world import HomeWorld

pytestmark = pytest.mark.usefixtures("place")


@pytest.fixture
def client() -> Iterator[rtkit.Client]:
    with rtkit.Client(timeout_s=10.0) as client:
        yield client


@pytest.fixture
def swarm() -> Iterator[Group]:
    """Four robots in a row, all but the last of them members of a group."""
    with ExitStack() as stack:
        for at in range(4):
            stack.enter_context(rtkit.serve(Bot(2.0 * at), f"robots/r{at}", is_on_zenoh=False))
        group = Group(robots="robots/r0 robots/r1 two=robots/r2")
        stack.enter_context(rtkit.serve(group, "swarm", is_on_zenoh=False))
        yield group


def error_of(work: Callable[[], object]) -> tuple[str, str]:
    with pytest.raises(rtkit.PropertyError) as caught:
        work()
    return caught.value.code, str(caught.value)


def drive(client: rtkit.Client, robot: str) -> tuple[float, ...]:
    """Be the program that drives one robot: a metre ahead, until it is there."""
    assert "mobilerobot" in client.get(f"{robot}.type")
    x, y, *_ = client.get(f"{robot}.location")
    client.set(f"{robot}.behaviors.moveto", rtkit.Marker((1.0, 0.0)))
    until(
        lambda: client.get(f"{robot}.behaviors.moveto").attributes["state"] == "done",
        "it arrives",
    )
    there = client.get(f"{robot}.location")
    return there[0] - x, there[1] - y


def test_the_client_of_one_robot_drives_a_swarm(swarm: Group, client: rtkit.Client) -> None:
    assert drive(client, "swarm") == (1.0, 0.0)
    assert client.get("swarm.location", form="list") == (
        ("r0", (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
        ("r1", (3.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
        ("two", (5.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
    )
    client.set("swarm.behaviors.moveto", [rtkit.Marker((9, 9), frame="world"),
                                          rtkit.Marker((0, 1), frame="robots/r3")])  # fmt: skip
    assert client.get("swarm.location") == (6.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    assert client.get("swarm.location.x") == 6.0
    assert client.get("robots/r0.location")[:2] == (4.0, 1.0)
    client.set("swarm.velocity", (0.5, 0, 0, 0, 0, 0.25))
    client.set("swarm.velocity.x", 0.75)
    assert client.get("robots/r2.velocity") == (0.75, 0.0, 0.0, 0.0, 0.0, 0.25)
    client.set("swarm.behaviors.stop", True)
    assert client.get("swarm.behaviors.moveto").attributes == {"state": "stopped"}
    client.set("swarm.note", '"two words"')
    assert client.get("robots/r1.note") == client.get("swarm.note") == "two words"
    assert client.get("swarm.status") == "ready"
    for name, access in (("location", "r"), ("velocity", "rw")):
        for field, value in (("access", access), ("type", "vector[6]")):
            assert client.get(f"swarm.{name}.meta.{field}") == value
    assert client.get("swarm.location.meta.unit") == "m"


def test_a_group_of_nobody_is_empty_and_holds_up_none_around_it(client: rtkit.Client) -> None:
    with ExitStack() as stack:
        stack.enter_context(rtkit.serve(Group(), "nobody", is_on_zenoh=False))
        stack.enter_context(rtkit.serve(Bot(), "r0", is_on_zenoh=False))
        stack.enter_context(rtkit.serve(Group(robots="r0 nobody"), "swarm", is_on_zenoh=False))
        assert client.get("nobody.status") == "empty"
        assert client.get("swarm.status") == "ready"


def test_a_swarm_of_unlike_robots_is_driven_as_each_of_them(client: rtkit.Client) -> None:
    home = HomeWorld(pace=8.0)
    with ExitStack() as stack:
        stack.enter_context(rtkit.serve(home, "home", is_on_zenoh=False))
        for name, kind, y in (("wheels", DifferentialRobot, 0.5), ("legs", LeggedRobot, -0.5)):
            robot = kind(world="home", body=name, start=(0.0, y, 0.0))
            stack.enter_context(rtkit.serve(robot, name, is_on_zenoh=False))
        group = Group(robots="wheels legs", deadline=5.0)
        stack.enter_context(rtkit.serve(group, "swarm", is_on_zenoh=False))
        for robot in ("wheels", "legs", "swarm"):
            assert drive(client, robot) == pytest.approx((1.0, 0.0), abs=0.03)
        target = client.get("swarm.behaviors.moveto").find("target").find("location").leaf
        middle = client.get("swarm.location")
        assert target[:2] == pytest.approx(middle[:2], abs=0.03), "not that of one robot"
        ends = dict(client.get("swarm.location", form="list"))
        offset = [a - b for a, b in zip(ends["wheels"], ends["legs"], strict=True)]
        assert offset[:2] == pytest.approx((0.0, 1.0), abs=0.05)
        length = [client.get(f"{each}.dimensions")[0] for each in ("wheels", "legs")]
        assert client.get("swarm.dimensions")[0] == pytest.approx(sum(length) / 2)
        assert client.get("swarm.robots.legs.actuators") == client.get("legs.actuators")


def test_each_member_has_all_that_it_has_alone(swarm: Group, client: rtkit.Client) -> None:
    assert client.get("swarm.robots") == ("r0", "r1", "two")
    client.set("swarm.robots.r1.behaviors.moveto", rtkit.Marker((1, 1)))
    assert client.get("swarm.robots.r1.location")[:2] == (1.0, 1.0)
    assert client.get("swarm.robots.two.location.x") == 4.0
    assert error_of(lambda: client.get("swarm.robots.two.nothing"))[0] == "unknown"


def test_members_join_and_leave_during_use(swarm: Group, client: rtkit.Client) -> None:
    client.call("swarm.join", "robots/r3")
    client.set("swarm.velocity", (1, 0, 0, 0, 0, 0))
    assert client.get("robots/r3.velocity")[0] == 1.0
    assert client.get("swarm.robots.r3.velocity")[0] == 1.0
    client.call("swarm.leave", "r0")
    client.set("swarm.velocity", (2, 0, 0, 0, 0, 0))
    assert client.get("robots/r0.velocity")[0] == 1.0
    assert client.get("swarm.robots") == ("r1", "two", "r3")
    assert error_of(lambda: client.call("swarm.leave", "r0"))[0] == "unknown"
    assert error_of(lambda: client.call("swarm.join", "other/r1"))[0] == "conflict"
    assert error_of(lambda: client.call("swarm.join", "="))[0] == "bad-value"
    code, text = error_of(lambda: client.call("swarm.join", "robots/r99"))
    assert (code, "no service named robots/r99 (there is " in text) == ("no-service", True), text
    assert client.get("swarm.robots") == ("r1", "two", "r3")
    for name in ("r1", "two", "r3"):
        client.call("swarm.leave", name)
    code, text = error_of(lambda: client.set("swarm.velocity", (0, 0, 0, 0, 0, 0)))
    assert (code, "there are no members" in text) == ("conflict", True)


def test_what_a_member_gets_later_is_known_later(
    swarm: Group, client: rtkit.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rtkit.services.fanout._AGAIN_S", 0.05)
    assert "lamp" not in client.get("swarm.properties")
    client.set("robots/r1.plug", True)
    until(lambda: "lamp" in client.get("swarm.properties"), "one of them has it")
    client.set("swarm.robots.r1.lamp", 0.5)
    assert client.get("swarm.lamp") == 0.5
    assert error_of(lambda: client.set("swarm.lamp", 1.0)) == (
        "unknown",
        "swarm.lamp: unknown: 2 of 3 failed: r0 two: unknown: no such property: lamp",
    )
    assert client.get("robots/r1.lamp") == 1.0


def test_who_is_slow_to_tell_its_names_delays_nobody(
    client: rtkit.Client,
) -> None:
    with socket.socket(socket.AF_UNIX) as deaf:
        deaf.bind(places.service_socket("deaf"))
        deaf.listen()
        group = Group(robots="deaf", deadline=0.1)
        with rtkit.serve(group, "swarm", is_on_zenoh=False):
            for _ in range(2):
                began = time.monotonic()
                assert error_of(lambda: client.set("swarm.velocity", (1,) * 6))[0] == "timeout"
                assert time.monotonic() - began < 1.5
        Path(places.service_socket("deaf")).unlink()


@pytest.mark.parametrize("groups", [
    {"g0": "r0 g0"},
    {"g0": "r0 g1", "g1": "g0 r1"},
    {"g0": "g1 r0", "g1": "r1 g2", "g2": "g0"},
    {"g0": "r0 g1", "g1": "r1 g2", "g2": "r2 g0"},
])  # fmt: skip
def test_groups_that_hold_each_other_leave_out_who_waits(
    groups: dict[str, str], client: rtkit.Client
) -> None:
    bots = {name: Bot() for name in ("r0", "r1", "r2") if name in str(groups)}
    with ExitStack() as stack:
        for name, bot in bots.items():
            stack.enter_context(rtkit.serve(bot, name, is_on_zenoh=False))
        stack.enter_context(in_processes(**groups))
        for times, name in enumerate(groups, start=1):
            client.set(f"{name}.velocity", (times,) * 6)
            assert {each.times for each in bots.values()} == {times}, "each is moved once"
            assert client.get(f"{name}.velocity") == (times,) * 6
            assert client.get(f"{name}.status") == "ready"
            client.set(f"{name}.behaviors.moveto", rtkit.Marker((1, 0)))
            assert client.get(f"{name}.location")[0] == times
        assert client.get("g0.velocity.meta.type") == "vector[6]"
        # Requests that begin anywhere do not wait for each other round the ring.
        for value in (8.0, 9.0):
            both = ("status", "version")
            gets = [rtkit.Ask(f"{name}.{each}") for name in groups for each in both]
            sets = [rtkit.Ask(f"{name}.velocity", (value,) * 6) for name in groups]
            listings = [rtkit.Ask(f"{name}.properties?values") for name in groups]
            told = client.ask_all([*gets, *sets, *listings], 10.0)
            size = len(groups)
            assert told[: 3 * size] == [*("ready", "1.0") * size, *[""] * size]
            assert [dict(each)["status"] for each in told[3 * size :]] == ["ready"] * size
        round_ = "".join(f".robots.{each}" for each in [*groups, "g0"][1:])[1:]
        listing = rtkit.Ask("g0.properties?all&values")

        def is_named() -> bool:
            ((*pairs,),) = client.ask_all([listing], 5.0)
            found = dict(pairs).get(round_)
            return isinstance(found, rtkit.Element) and "proxy of itself" in str(found.leaf)

        until(is_named, "where it goes round is named")


def test_groups_that_hold_nobody_else_say_so(client: rtkit.Client) -> None:
    with in_processes(g0="g1", g1="g2", g2="g0 g1"):
        for name in ("g0", "g1", "g2"):
            for work in (client.get, lambda target: client.set(target, (1,) * 6)):
                assert error_of(lambda n=name, w=work: w(f"{n}.velocity")) == (  # type: ignore[misc]
                    "conflict",
                    f"{name}.velocity: conflict: "
                    "the request has come back to all members, which wait for the answer",
                )
            assert client.get(f"{name}.status") == "ready"


def test_a_group_of_groups_moves_each_once_and_in_time(client: rtkit.Client) -> None:
    names = [f"r{at}" for at in range(4)]
    bots = [Bot(float(at)) for at in range(4)]
    with ExitStack() as stack:
        for name, bot in zip(names, bots, strict=True):
            stack.enter_context(rtkit.serve(bot, name, is_on_zenoh=False))
        inner = {"g1": "r0 r1", "g2": "zone.r2", "g0": "g1 zone.g2 r3"}
        held = {name: rtkit.Mount(name) for name in ("r2", "g2", "g0")}
        stack.enter_context(rtkit.serve(held, "zone", is_on_zenoh=False))  # type: ignore[arg-type]
        processes = stack.enter_context(in_processes(**inner))
        there = rtkit.Ask("zone.g0.robots.g2.robots.r2.times")
        until(lambda: client.ask_all([there], 5) == [0], "all is there")
        for times, group in enumerate(("g0", "zone.g0"), start=1):
            client.set(f"{group}.velocity", (times,) * 6)
            assert [each.times for each in bots] == [times] * 4
            assert client.get(f"{group}.velocity") == (times,) * 6
        assert drive(client, "g0") == pytest.approx((1.0, 0.0))
        assert client.get("g0.status") == "ready"
        client.set("g0.deadline", 0.5)
        processes["g2"].send_signal(signal.SIGSTOP)
        os.waitpid(processes["g2"].pid, os.WUNTRACED)
        began = time.monotonic()
        code, text = error_of(lambda: client.set("g0.velocity", (3,) * 6))
        assert time.monotonic() - began < 0.5 + 0.4
        assert (code, "1 of 3 failed: g2: timeout" in text) == ("timeout", True)
        assert [each.times for each in bots] == [3, 3, 2, 3]


def test_who_asks_a_group_is_answered_in_its_time(client: rtkit.Client) -> None:
    """A deadline sooner than that of the group, or of a group in it, is kept as well."""
    with ExitStack() as stack:
        for name, takes_s in (("quick", 0.0), ("slow", 2.0)):
            stack.enter_context(rtkit.serve(Bot(takes_s=takes_s), name, is_on_zenoh=False))
        for name, robots in (("inner", "slow quick"), ("outer", "quick inner")):
            group = Group(robots=robots, deadline=1.5)
            stack.enter_context(rtkit.serve(group, name, is_on_zenoh=False))
        assert client.get("outer.version") == "1.0"
        began = time.monotonic()
        assert client.get("outer.velocity", timeout=0.9) == (0.0,) * 6
        (failed,) = client.ask_all([rtkit.Ask("outer.velocity", (1,) * 6)], 0.9)
        assert "inner: timeout: 1 of 2 failed: slow: timeout: " in str(failed)
        assert time.monotonic() - began < 2 * 0.9 + 0.2


def test_some_of_them_have_a_name_of_their_own(swarm: Group, client: rtkit.Client) -> None:
    client.set("swarm.groups.left", "(r0 two)")
    assert client.get("swarm.groups") == ("all", "left")
    assert client.get("swarm.groups.left") == ("r0", "two")
    assert client.get("swarm.groups.left.location")[0] == 2.0
    assert client.get("swarm.groups.left.location.meta.unit") == "m"
    client.set("swarm.groups.left.behaviors.moveto", rtkit.Marker((0, 5), frame="world"))
    assert [client.get(f"robots/r{at}.location")[:2] for at in range(3)] == [
        (-2.0, 5.0), (2.0, 0.0), (2.0, 5.0)
    ]  # fmt: skip
    client.call("swarm.leave", "two")
    assert client.get("swarm.groups.left") == ("r0",)
    for name, value, code in (
        ("groups.right", "(r0 nobody)", "bad-value"),
        ("groups.all", "(r0)", "read-only"),
        ("groups.none.velocity", "(0 0 0 0 0 0)", "unknown"),
        ("groups.left.location", "(0 0 0 0 0 0)", "read-only"),
        ("location", "(0 0 0 0 0 0)", "read-only"),
        ("nothing", "1", "unknown"),
    ):
        assert error_of(lambda n=name, v=value: client.set(f"swarm.{n}", v))[0] == code, name  # type: ignore[misc]
    assert error_of(lambda: client.get("swarm.location", form="some"))[0] == "bad-parameter"
    client.set("swarm.groups.left", "()")
    assert client.get("swarm.groups") == ("all",)


def test_who_listens_hears_the_middle(swarm: Group, client: rtkit.Client) -> None:
    heard: list[float] = []
    with client.listen("swarm.location", lambda change: heard.append(change.value[0])):
        until(lambda: heard == [2.0], "the first")
        client.set("swarm.behaviors.moveto", rtkit.Marker((7, 0), frame="world"))
        until(lambda: heard[-1] == 7.0, "the middle moves")


def test_a_hundred_robots_of_which_ten_fail(client: rtkit.Client) -> None:
    bounds, slow = (0, 11, 22, 33, 44, 55, 66, 77, 86, 95, 100), (3, 17, 40, 62, 88)
    over = [range(first, last) for first, last in pairwise(bounds)]
    on_zenoh = {at for index, each in enumerate(over) if index % 2 for at in each}
    places = (f"r{at}=zenoh:robots/r{at}" if at in on_zenoh else f"robots/r{at}"
              for at in range(100))  # fmt: skip
    group = Group(robots=" ".join(places), deadline=3.0)
    with fleet(bounds, slow) as processes, rtkit.serve(group, "swarm", is_on_zenoh=False):
        processes[-1].kill()
        processes[-1].wait()
        began = time.monotonic()
        code, text = error_of(
            lambda: client.set("swarm.behaviors.moveto", rtkit.Marker((0, 50), frame="world"))
        )
        assert time.monotonic() - began < 3.0 + 0.5
        assert code == "conflict"
        assert "10 of 100 failed" in text
        dead = {f"r{at}" for at in range(95, 100)}
        late = {f"r{at}" for at in slow}
        failures = client.get("swarm.failures")
        assert {name for name, code, _ in failures if code == "timeout"} == late
        assert {name for name, code, _ in failures if code == "no-service"} == dead
        now = dict(client.get("swarm.location", form="list"))
        assert {f"r{at}" for at in range(100)} - now.keys() == dead
        assert {name for name, there in now.items() if there[1] != 50.0} == late
        xs = [there[0] for name, there in now.items() if name not in late]
        assert max(xs) - min(xs) == 94.0
        assert client.get("swarm.behaviors.moveto").attributes == {"state": "done"}
