"""Values of ports of a manager that is reached over mutual TLS: read, written, recorded."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from forked import Commands
from robotkit import BOUND_S, Robot, opened_robot
from waiting import until

import rtkit
from rtkit.api.ports import PortReader
from rtkit.component import Time, TimedLong
from rtkit.component.values.codec import codec_for
from rtkit.link.tap_messages import call_to_bytes, values_from_bytes, values_to_bytes

OPEN, TAKE, WRITE, LOST = (f"%40x%2Ftap%2F{word}" for word in ("open", "take", "write", "lost"))
COUNTER = '''
from rtkit.component import Component, InPort, OutPort, TimedLong


class Counter(Component):
    """Write numbers, many a second; keep those that come."""

    rate = 1000.0
    out = OutPort(TimedLong)
    into = InPort(TimedLong)
    number = 0

    def on_execute(self, context):
        self.number += 1
        self.out.write(TimedLong(data=self.number))
        for value in self.into.read_all():
            self.logger.info("got %d", value.data)


def CounterInit(manager):
    manager.register_factory(Counter)
'''

GRIPPER = '''
import time
from typing import Protocol

from rtkit.component import Component, ServicePort, raises


class Stuck(Exception):
    def __init__(self, force: float) -> None:
        super().__init__(f"at {force}")
        self.force = force


class Hand(Protocol):
    @raises(Stuck)
    def close(self, force: float) -> float: ...

    def wait(self, time_s: float) -> None: ...


class Gripper(Component):
    """Close until it is stuck."""

    hand = ServicePort.provided(Hand)

    def close(self, force: float) -> float:
        if force > 10.0:
            raise Stuck(force)
        return force / 2.0

    def wait(self, time_s: float) -> None:
        time.sleep(time_s)


def GripperInit(manager):
    manager.register_factory(Gripper)
'''


@pytest.fixture(scope="module")
def robot(commands: Commands) -> Iterator[Robot]:
    with opened_robot(commands, {"Counter.py": COUNTER, "Gripper.py": GRIPPER}) as robot:
        assert robot.there("rtmgr -c Counter?manager_name=s /localhost/manager.mgr").err == ""
        assert robot.there("rtmgr -c Gripper /localhost/manager.mgr").err == ""
        for name in ("ConsoleIn0", "ConsoleOut0", "Counter0", "Gripper0"):
            assert robot.by("bert", f"rtact AT/{name}.rtc").err == ""
        yield robot


def _taps(robot: Robot) -> list[str]:
    """Return the processes of taps of a robot: of its folders."""
    found = []
    for each in Path("/proc").glob("[0-9]*"):
        try:
            words, variables = ((each / name).read_bytes() for name in ("cmdline", "environ"))
        except OSError:
            continue
        if b"rtkit.probe.far_tap" in words and str(robot.shell.folder).encode() in variables:
            found.append(each.name)
    return found


def _asked(writes: bool = False, **more: object) -> str:
    end = ("ConsoleOut0", "in", "p") if writes else ("ConsoleIn0", "out", "p")
    asked = {"kind": "probe", "rate": 0, "writes": writes, "lossless": False, "is_patient": False}
    return json.dumps({**asked, "streams": [("s", [end])], **more})


def test_whoever_only_looks_reads_values_and_writes_none(robot: Robot) -> None:
    done = robot.by("anna", "rtprint --json -n 3 AT/ConsoleIn0.rtc:out")
    assert (done.status, done.err) == (0, "")
    records = [json.loads(line) for line in done.out.splitlines()]
    assert [each["value"]["data"] for each in records] == [0, 0, 0]
    assert {each["clock"]["host"] for each in records} == {"robot1"}
    for line, what in (
        ("rtinject -c 1 AT/ConsoleOut0.rtc:in", "write values to ConsoleOut0.in"),
        ("rtprint --lossless -n 1 AT/ConsoleIn0.rtc:out", "read values of ConsoleIn0.out lossless"),
    ):
        done = robot.by("anna", line)
        assert (done.status, done.out) == (1, "")
        assert f"denied: anna (viewer) may not {what}: it takes operator" in done.err
        assert robot.record()[-1]["what"] == f"{what} at manager"
    assert "probe" not in robot.by("anna", "rtls AT").out


def test_no_value_is_lost_by_whoever_asks_for_all(robot: Robot) -> None:
    done = robot.by("bert", "rtprint --lossless --json -n 3000 AT/Counter0.rtc:out")
    assert (done.status, done.err) == (0, "")
    numbers = [json.loads(line)["value"]["data"] for line in done.out.splitlines()]
    assert numbers == list(range(numbers[0], numbers[0] + 3000))


def test_what_is_written_arrives_in_order_and_is_on_record(robot: Robot) -> None:
    assert robot.by("bert", "rtinject --lossless -n 200 -r 400 -c 7 AT/Counter0.rtc:into").err == ""
    told = robot.by("anna", "rtvlog --no-follow -g got AT/Counter0.rtc").out
    until(
        lambda: (
            robot.by("anna", "rtvlog --no-follow -g 'got 7' AT/Counter0.rtc").out.count("got 7")
            == 200
        ),
        f"all of them arrive {told[-200:]}",
    )
    last = robot.record()[-1]
    assert (last["name"], last["what"], last["result"]) == (
        "bert", "write values to Counter0.into lossless at manager", "done",
    )  # fmt: skip


def test_what_was_recorded_is_played(robot: Robot) -> None:
    assert robot.by("anna", "rtlog -f run.mcap -t 1 AT/ConsoleIn0.rtc:out").status == 0
    info = json.loads(robot.by("anna", "rtlog --info --json -f run.mcap").out)
    (channel,) = info["channels"]
    assert (channel["clock"], channel["entries"] > 3) == ("robot1", True)
    assert robot.by("bert", "rtlog -p -f run.mcap AT/ConsoleOut0.rtc:in").status == 0
    done = robot.by("anna", "rtlog -a -f all.mcap -t 1")
    assert done.status != 0  # of the manager here, which does not run
    with robot.usual():
        assert robot.by("anna", "rtlog -a -f all.mcap -t 1").status == 0


def test_scripts_read_and_write_at_once(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RTKIT_KEYS", f"{robot.keys}.bert")
    with (
        rtkit.connect(robot.path[1:]) as tree,
        PortReader(tree, [f"{robot.path}/Counter0.rtc:out"]) as out,
    ):
        assert out.read(timeout_s=BOUND_S).data > 0
        assert tree.write(f"{robot.path}/ConsoleOut0.rtc:in", {"data": 5}) == 1
        assert out.read(timeout_s=BOUND_S).data > 0
    until(lambda: not _taps(robot), "their taps end")


def test_a_tap_ends_with_its_client(robot: Robot) -> None:
    with robot.keys_of("anna"):
        reader = robot.shell.open(f"rtprint {robot.path}/ConsoleIn0.rtc:out")
    assert reader.stdout is not None
    assert reader.stdout.readline()
    assert "rtprint_reader0" in robot.by("anna", "rtls AT").out
    reader.kill()
    until(lambda: "rtprint_reader0" not in robot.by("anna", "rtls AT").out, "its component leaves")
    until(lambda: not _taps(robot), "its process ends")


def test_taps_of_one_name_are_few(robot: Robot) -> None:
    with robot.connected("anna") as a, robot.connected("anna") as b, robot.connected("anna") as c:
        with robot.connected("anna") as d, robot.connected("anna") as e:
            for client in (a, b, c, d):
                assert client.ask(OPEN, _asked()).error == ""
            assert "enough taps" in str(e.ask(OPEN, _asked()).payload)
            assert "a tap already" in str(d.ask(OPEN, _asked()).payload)
        until(lambda: len(_taps(robot)) == 3, "one ends")
        with robot.connected("anna") as f:
            assert f.ask(OPEN, _asked()).error == ""
            assert f.ask(TAKE, "").error == ""
    until(lambda: not _taps(robot), "all end")


ODD = ("", "[", "7", "{}", '{"writes": 1}', "[" * 9000, '{"writes":0,"lossless":0,"streams":[[1]]}')


@pytest.mark.parametrize("text", ODD)
def test_rubbish_opens_no_tap(robot: Robot, text: str) -> None:
    with robot.connected("owner1") as client:
        assert client.ask(OPEN, text).error == "malformed"
        for word in (TAKE, WRITE, LOST, "%40x%2Ftap%2Fkill", "%40x%2Ftap%2F"):
            assert client.ask(word, "").error == "malformed"
        assert _taps(robot) == []


def test_a_client_names_its_component_and_ports_as_names_are(robot: Robot) -> None:
    for kind in ("", "../x", "a b", "a/b", "\x1b[31m", "x" * 99):
        with robot.connected("anna") as client:
            assert client.ask(OPEN, _asked(kind=kind)).error == "refused", kind
    with robot.connected("anna") as client:
        assert client.ask(OPEN, _asked()).error == ""
        for name in ("", "s", "a b", "x" * 999, "\x1b"):
            assert client.ask("%40x%2Ftap%2Fextend", json.dumps([name])).error == "refused", name
        assert client.ask("%40x%2Ftap%2Fextend", '["t"]').error == ""
        assert client.ask("%40x%2Ftap%2Fextend", '["t"]').error == "refused"
    output = (robot.shell.folder / "robot.state/manager.out").read_text()
    assert "Traceback" not in output


def test_a_tap_takes_values_of_its_type_only(robot: Robot) -> None:
    good = codec_for(TimedLong).encode(TimedLong(Time(), 99))
    with robot.connected("bert") as client:
        lacking = _asked(streams=[("s", [("Nobody", "out", "/n.rtc:out")])])
        assert client.ask(OPEN, lacking) == ("No such port: /n.rtc:out", "not-found")
    with robot.connected("bert") as client:
        assert client.ask(OPEN, _asked(writes=True)).error == ""
        for values in (
            [(0, 0, b"")], [(0, 0, good[:-1])], [(7, 0, good)], [(0, 0, b"\xff" * 500)],
        ):  # fmt: skip
            assert client.ask(WRITE, values_to_bytes(values)).error == "malformed", values
        assert client.ask(WRITE, b"\0\0\xff").error == "malformed"
        assert client.ask(WRITE, values_to_bytes([(0, 0, good)])).error == ""
        assert client.ask(LOST, "").payload in ("0", b"0")
    assert robot.is_alive()


def test_values_are_split_as_they_were_joined() -> None:
    values = [(1, 5, b"abc"), (0, -7, b""), (65535, 2**62, b"\0" * 9)]
    data = values_to_bytes(values)
    assert list(values_from_bytes(data)) == values
    ends = {len(values_to_bytes(values[:count])) for count in range(len(values) + 1)}
    for end in set(range(len(data))) - ends:
        with pytest.raises(ValueError, match="cut off"):
            list(values_from_bytes(data[:end]))


def test_operations_are_called_by_operators(robot: Robot) -> None:
    listed = robot.by("anna", "rtcall AT/Gripper0.rtc:hand")
    assert "double close(in double force)" in listed.out
    done = robot.by("bert", "rtcall AT/Gripper0.rtc:hand.close 3")
    assert (done.status, done.out, done.err) == (0, "1.5\n", "")
    done = robot.by("bert", "rtcall --json AT/Gripper0.rtc:hand.close 30")
    raised = json.loads(done.out)["raised"]
    assert (done.status, raised) == (1, {"name": "Stuck", "members": {"force": 30.0}})
    done = robot.by("bert", "rtcall --timeout 1 AT/Gripper0.rtc:hand.wait 9")
    assert (done.status, done.out) == (1, "")
    assert "no answer within 1 s" in done.err
    for who, role in (("anna", "viewer"), ("carl", "component")):
        done = robot.by(who, "rtcall AT/Gripper0.rtc:hand.close 3")
        why = f"denied: {who} ({role}) may not call Gripper0.hand.close: it takes operator"
        assert (done.status, done.out, done.err) == (1, "", f"rtcall: {why}\n")
    told = [each for each in robot.record() if each["what"].startswith("call Gripper0.hand")]
    assert [(each["name"], each["result"].split(":")[0]) for each in told] == [
        ("bert", "done"), ("bert", "raised Stuck Gripper0.hand"), ("bert", "unreachable"),
        ("anna", "denied"), ("carl", "denied"),
    ]  # fmt: skip
    until(lambda: not _taps(robot), "their taps end")


def test_scripts_call_again_and_again_by_one_tap(
    robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RTKIT_KEYS", f"{robot.keys}.bert")
    with rtkit.connect(robot.path[1:]) as tree:
        port = f"{robot.path}/Gripper0.rtc:hand"
        assert [tree.call(f"{port}.close", force) for force in (2.0, 4.0)] == [1.0, 2.0]
        assert len(_taps(robot)) == 1
        assert "rtcall" not in robot.by("anna", "rtls AT").out


CALLS = (
    b"", b"[", b"[]", b"[" * 9000, b"7\nx", b'[["Gripper0", "hand"], 1]\nx',
    b'[["Gripper0", "hand", "p"], "x"]\nx', b'[["Gripper0", "hand", "p"], -1]\nx',
    b'[["Gripper0", "hand", "p"], NaN]\nx', b'[["Gripper0", "hand", "p"], 1]\n',
)  # fmt: skip


def test_rubbish_calls_nothing(robot: Robot) -> None:
    call = "%40x%2Ftap%2Fcall"
    good = call_to_bytes(["Gripper0", "hand", "p"], 5.0, b"Hand\tclose(d)d\n")
    with robot.connected("bert") as client:
        for body in CALLS:
            assert client.ask(call, body).error == "malformed", body
        assert _taps(robot) == []
        lacking = call_to_bytes(["Nobody", "hand", "/n.rtc:hand"], 5.0, b"Hand\tclose\n")
        assert client.ask(call, lacking) == ("No such port: /n.rtc:hand", "not-found")
        assert client.ask(call, good.replace(b"Hand\t", b"\xff\x1b\t")).error == "not-found"
        assert "interfaces differ" in str(client.ask(call, good).payload)
    assert robot.is_alive()
    assert "\x1b" not in json.dumps(robot.record(), ensure_ascii=False)


def test_what_takes_a_link_says_so(robot: Robot) -> None:
    done = robot.by("owner1", "rtmove AT/ConsoleIn0.rtc AT/manager.mgr/s.mgr")
    assert (done.status, done.out) == (1, "")
    assert "over TLS: components are moved" in done.err
