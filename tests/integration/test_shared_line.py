"""One serial line that many devices share, over a real terminal: the devices of the examples, in C,
a process each, and a service of rtkit that is one more of them."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from conformance import check_answers, subject
from oneline import BOUND_S, OneLine
from serialkit import Cable, build_device, noise
from small_profile import small_rows
from waiting import until

import rtkit
from rtkit.errors import Malformed, Unreachable
from rtkit.link import places
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, PropertyEvent
from rtkit.proxy.bridge import bridge
from rtkit.services.group import Group
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serial.client import connect_serial
from rtkit.wires.serial.shared_line import SharedLine
from rtkit.wires.serve import serve

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_device(tmp_path_factory.mktemp("embedded"))


@contextmanager
def devices(built: Path, cable: Cable, *words: str) -> Iterator[dict[str, int]]:
    """Have devices at the far end of a cable; yields their processes by address."""
    end = os.open(cable.far, os.O_RDWR | os.O_NOCTTY)
    line = [built / "device", *words]
    process = subprocess.Popen(line, stdin=end, stdout=end, stderr=subprocess.PIPE, text=True)
    os.close(end)
    assert process.stderr is not None
    try:
        count = int(words[1]) - int(words[0]) + 1 if len(words) == 2 else 0
        told = [process.stderr.readline().split() for _ in range(count)]
        yield {address: int(pid) for address, pid in told}
    finally:
        process.kill()
        process.communicate()


def line(cable: Cable, given: str, timeout_s: float = BOUND_S) -> SharedLine:
    client = connect_serial(f"serial:{cable.near}?{given}", timeout_s)
    assert isinstance(client, SharedLine)
    return client


@pytest.mark.parametrize("check", ["auto", "0"])
def test_a_device_of_a_shared_line_answers_as_one_alone(
    built: Path, cable: Cable, check: str
) -> None:
    # Without a check, what is of several lines is refused here, and not there.
    rows = [row for row in small_rows() if check == "auto" or "\n" not in str(row[1])]
    with devices(built, cable, "7"), line(cable, f"address=7&check={check}") as client:
        check_answers(OneLine(client), rows)
        if check == "0":
            with pytest.raises(PropertyError, match="need a check"):
                client.ask("count", b"a\nb")


def test_it_acts_once_where_lines_are_damaged(built: Path, cable: Cable) -> None:
    cable.noise = noise(5, one_in=6)
    with devices(built, cable, "7"), line(cable, "address=7") as client:
        for count in range(15):
            assert client.ask("button.press", "true").error == ""
            assert client.ask("button.presses").payload == str(count + 1)
            assert client.ask("nothing").error == "unknown"


def test_a_service_is_one_of_the_devices(cable: Cable) -> None:
    opening = {"serial": f"{cable.far}?address=base", "settable": ["arm.*"], "is_on_zenoh": False}
    with (
        serve(subject(), "robot", **opening),  # type: ignore[arg-type]
        line(cable, "address=base,8") as client,
    ):
        assert client.ask("base.count") == Answer("7")
        assert client.ask("base.arm.angle", "4").error == ""
        assert client.ask("base.count", "4").error == "denied"
        assert client.ask("all.arm.angle", "5") == Answer("")
        assert client.ask("base.arm.angle") == Answer("5")
        assert client.ask("8.count").error == "timeout"
    for wrong in ("1-3", "all", "a.b"):
        with (
            pytest.raises(Malformed, match="address"),
            serve(subject(), "robot", serial=f"{cable.far}?address={wrong}", is_on_zenoh=False),
        ):
            pass


def test_twenty_devices_of_which_some_are_silent(built: Path, cable: Cable) -> None:
    with devices(built, cable, "1", "20") as pids, line(cable, "address=1-20,base") as client:
        listed = [*map(str, range(1, 21)), "base", "all", "silent"]
        assert client.ask("properties") == Answer(f"({' '.join(listed)})")
        for name in pids:
            assert client.ask(f"{name}.speed?echo", f"0.{int(name):03}").error == ""
        assert client.ask("13.speed") == Answer("0.013")
        assert client.ask("13.arm") == Answer("(angle joint)")
        assert str(client.ask("13").payload).startswith("(speed location ")
        # One that answered is silent now, another never was there.
        os.kill(pids["3"], signal.SIGSTOP)
        began = time.monotonic()
        said = {name: client.ask(f"{name}.speed") for name in (*pids, "base")}
        assert time.monotonic() - began < 6.0
        failed = {name: str(answer.payload) for name, answer in said.items() if answer.error}
        assert failed == {name: f"no answer within 1 s: device {name}" for name in ("3", "base")}
        assert said["20"] == Answer("0.02")
        began = time.monotonic()
        assert client.ask("3.speed") == Answer("device 3 is silent", "no-service")
        assert client.ask("silent") == Answer("(3 base)")
        assert time.monotonic() - began < 1.0
        # All are meant, and nobody answers; who was away misses it.
        assert client.ask("all.speed", "-0.5") == Answer("")
        os.kill(pids["3"], signal.SIGCONT)
        until(lambda: client.event(0.05) is None and client.ask("silent").payload == "(base)", "")
        assert {client.ask(f"{name}.speed").payload for name in ("1", "2", "20")} == {"-0.5"}
        assert client.ask("3.speed").error == ""


def test_all_act_once_on_what_is_sent_to_all(built: Path, cable: Cable) -> None:
    cable.noise = noise(2, one_in=8)
    with devices(built, cable, "1", "5") as pids, line(cable, "address=1-5") as client:
        assert client.ask("all.button.press", "true") == Answer("")
        cable.noise = bytes
        assert [client.ask(f"{name}.button.presses").payload for name in pids] == ["1"] * 5
        assert client.ask("all.speed").error == "write-only"
        assert client.ask("6.speed").error == "unknown"
        assert client.ask("silent", "()").error == "read-only"
        assert client.ask("properties?all").error == "bad-parameter"


def events_of(client: SharedLine, is_last: Callable[[PropertyEvent], bool]) -> list[PropertyEvent]:
    events = []
    while True:
        event = client.event(BOUND_S)
        assert event is not None, events
        events.append(event)
        if is_last(event):
            return events


def test_who_listens_hears_changes_and_that_a_device_is_silent(built: Path, cable: Cable) -> None:
    with devices(built, cable, "1", "3") as pids, line(cable, "address=1-3") as client:
        client.listen("1.count")
        client.listen("2.uptime?every=0.2")
        client.listen("silent")
        assert client.ask("1.count", "20").error == ""
        heard = events_of(client, lambda event: event[:2] == ("1.count", "20"))
        events_of(client, lambda event: event.name == "2.uptime")
        assert {each.name for each in heard} <= {"1.count", "2.uptime", "silent"}
        os.kill(pids["1"], signal.SIGSTOP)
        heard = events_of(client, lambda event: event[:2] == ("silent", "(1)"))
        heard += events_of(client, lambda event: event.name == "2.uptime")
        assert ("20", "stale") in [(each.payload, each.quality) for each in heard]
        os.kill(pids["1"], signal.SIGCONT)
        events_of(client, lambda event: event[:2] == ("1.count", "20") and event.quality == "good")
        assert client.leave("1.count") == Answer("")
        assert client.ask("1.count.listen?remove", "self").error == "unknown"
        assert client.ask("1.nope.listen", "self").error == "unknown"
        assert client.ask("1.door_code.listen", "self").error == "write-only"
        assert client.ask("1.count.listen?queue=0", "self").error == "bad-parameter"
        assert client.ask("1.count.listen", "display/count").error == "denied"


def test_a_proxy_stands_for_the_whole_line(built: Path, cable: Cable, place: str) -> None:
    path = f"{place}/bus.sock"
    with (
        devices(built, cable, "1", "4") as pids,
        bridge(f"serial:{cable.near}?address=1-4", f"unix:{path}", allow_set=["*"]),
        connect_unix(path, BOUND_S) as client,
    ):
        assert client.ask("2.speed", "0.5") == Answer("")
        assert client.ask("2.speed") == Answer("0.5")
        # Commands say how long they wait; a small device does not know that parameter.
        for name in ("1.speed", "all.speed"):
            assert client.ask(f"{name}?timeout=5", "0.75") == Answer("")
            assert client.ask("1.speed?timeout=5") == Answer("0.75")
        assert client.ask("1.speed?of=5", "0.75").error == "bad-parameter"
        os.kill(pids["3"], signal.SIGKILL)
        assert client.ask("3.speed").error == "timeout"
        assert client.ask("3.speed") == Answer("device 3 is silent", "no-service")
        assert client.ask("all.speed", "1") == Answer("")
        assert [client.ask(f"{name}.speed").payload for name in "124"] == ["1.0"] * 3
        client.listen("4.count")
        assert client.event(BOUND_S) is not None
        cable.unplug(cable.near)
        until(lambda: client.ask("4.count").error == "no-service", "the line is gone")
        cable.plug(cable.near)
        until(lambda: client.ask("4.count?echo", "9").error == "", "it is back")
        until(lambda: (told := client.event(BOUND_S)) is not None and told.payload == "9", "")


def test_devices_of_a_line_are_members_of_a_group(built: Path, cable: Cable, place: str) -> None:
    path = f"unix:{places.service_socket('line')}"
    group = Group(robots="line.1 line.2 line.3", deadline=5.0)
    with (
        devices(built, cable, "1", "3"),
        bridge(f"serial:{cable.near}?address=1-3", path, allow_set=["*"]),
        serve(group, "swarm", is_on_zenoh=False),
        rtkit.Client(BOUND_S) as client,
    ):
        client.set("swarm.speed", 0.25)
        assert [client.get(f"line.{each}.speed") for each in (1, 2, 3)] == [0.25] * 3
        client.set("swarm.robots.2.speed", 1.0)
        assert client.get("swarm.speed") == 0.5
        assert client.get("swarm.robots.2.arm.angle") == 3
        assert client.get("swarm.status") == "ready"  # of those that have a status
        client.set("swarm.groups.few", "(1 3)")
        client.set("swarm.groups.few.speed", 0.0)
        assert dict(client.get("swarm.speed", form="list")) == {"1": 0.0, "2": 1.0, "3": 0.0}


def test_a_line_that_is_gone_is_said(built: Path, cable: Cable) -> None:
    with devices(built, cable, "1", "2"), line(cable, "address=1,2") as client:
        assert client.ask("1.count") == Answer("7")
        client.listen("1.count")
        cable.unplug(cable.near)
        with pytest.raises(Unreachable, match="unplugged"):
            client.ask("2.count")
        with pytest.raises(Unreachable, match="unplugged"):
            events_of(client, lambda event: False)
