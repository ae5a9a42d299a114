"""Live properties with the real commands: an object served, got, set, listened to, ended."""

from __future__ import annotations

import json
import re
import signal
from collections.abc import Iterator
from typing import Any

import jsonrecords
import pytest
from terminal import opened

from rtkit.property.values import Word
from rtkit.wires.serve import serve

KEEPS_MANAGER = True
MODULE = '''
class Arm:
    """An arm of nothing."""

    def __init__(self, angle=0.0, name="left"):
        self.angle = angle
        self.name = name
        self.picture = b"\\xff\\x00\\n"
        self.pose = [1.0, 2.0, 3.0]

    def get_reach(self, unit: str = "m"):
        return 0.5 if unit == "m" else 50

    def raised(self, by: float):
        self.angle += by
        return self.angle


    def lowered(self, by: float):
        raise ValueError("the floor is there")


def broken():
    raise ValueError("no arm")
'''


@pytest.fixture
def arm(shell: Any) -> Iterator[Any]:
    """A shell with an arm that is served."""
    (shell.folder / "arm.py").write_text(MODULE, encoding="utf-8")
    process = shell.open(
        "rtserve arm:Arm robots/arm -a 0.5 -a name=right --port 0 --http 0 --hide hidden"
        " --history na*=2"
    )
    _, shell.address, shell.web = process.stdout.readline().split()
    yield shell
    process.send_signal(signal.SIGTERM)
    assert process.communicate(timeout=30) == ("", "")
    assert process.returncode == 0


def test_services_are_listed_by_the_place_above_them_without_a_manager(arm: Any) -> None:
    for line in ("rtls robots", "rtls /localhost/robots", "rtls robots/"):
        assert arm.run(line) == (0, "arm/\n", "")
    assert arm.run("rtls -R /localhost") == (0, ".:\nrobots/\n\n./robots:\narm/\n\n", "")
    for typed in ("robots/leg", "/localhost/robots/leg", "robot"):
        told = arm.run(f"rtls {typed}")
        name = typed.removeprefix("/localhost/")
        assert told.err.startswith(f"rtls: {typed}: no-service: no service named {name} (there is ")
        assert (told.status, told.out, "robots/arm" in told.err) == (1, "", True)
    why = "rtls: manager 'manager' is not running (start it with: rtmgr start)\n"
    assert arm.run("rtls /x/robots") == (1, "", why)


def test_an_object_is_got_set_and_listened_to(arm: Any) -> None:
    assert arm.ok("rtget robots/arm") == "(raised lowered angle name picture pose reach)\n"
    line = "rtget robots/arm.angle /localhost/robots/arm/name robots/arm/pose.y"
    assert arm.ok(line) == '0.5\n"right"\n2.0\n'
    assert arm.ok("rtset robots/arm.angle -0.25") == ""
    assert arm.ok("rtset robots/arm angle -1e-3 --echo") == "-0.001\n"
    assert arm.ok("rtset --echo robots/arm.raised 2") == (
        '<call state="done"><result>1.999</result></call>\n'
    )
    assert arm.ok("rtset --echo -p by=0 robots/arm.raised") == (
        '<call state="done"><result>1.999</result></call>\n'
    )
    assert arm.ok(f"rtget --at {arm.address} robots/arm.angle") == "1.999\n"
    assert arm.ok(f"rtget {arm.web}.angle {arm.web}/pose/y") == "1.999\n2.0\n"
    endpoint = arm.web.removesuffix("/ps/robots/arm")
    assert arm.ok(f"rtset --echo --at {endpoint} robots/arm.angle 2") == "2\n"
    assert arm.ok(f"rtget {arm.address}/robots/arm.angle") == "2\n"
    for at in (arm.web, f"{arm.address}/robots/arm", f"tcp:{arm.address}/robots/arm/"):
        assert arm.ok(f"rtget --at {at} angle pose/y /localhost/robots/arm.angle") == "2\n2.0\n2\n"
    refused = arm.run(f"rtget --at {arm.address}/robots/leg angle").err
    why = "no service named robots/leg (there is robots/arm)"
    assert refused == f"rtget: angle: no-service: {why}\n"
    assert arm.ok(f"rtlisten -n 1 {arm.web}/name") == '"right"\n'
    arm.ok("rtset robots/arm properties '((angle 3) (name up))'")
    assert arm.ok("rtget -p values -p names='(angle name)' robots/arm") == (
        '((angle 3) (name "up"))\n'
    )
    (record,) = jsonrecords.checked(arm.ok("rtget --json robots/arm.pose"))
    assert (record["schema"], record["value"]) == ("rtkit.property/1", [1.0, 2.0, 3.0])
    listening = arm.open("rtlisten --json -n 2 robots/arm.angle robots/arm.name")
    first = [listening.stdout.readline() for _ in range(2)]
    assert listening.communicate(timeout=30)[1] == ""
    records = jsonrecords.checked("".join(first))
    assert {record["target"] for record in records} == {"robots/arm.angle", "robots/arm.name"}
    assert {record["schema"] for record in records} == {"rtkit.property-event/1"}
    changes = arm.open("rtlisten --queue 9 -n 3 robots/arm.angle")
    heard = [changes.stdout.readline()]
    for value in ("4", "5"):
        arm.ok(f"rtset robots/arm.angle {value}")
        heard.append(changes.stdout.readline())
    assert heard == ["3\n", "4\n", "5\n"]
    assert changes.wait(30) == 0
    changes.communicate()


def test_an_unknown_property_is_reported_with_names_like_it(arm: Any) -> None:
    for command, end in (("rtget", ""), ("rtset", " 1"), ("rtlisten", "")):
        for typed, meant in (
            ("robots/arm.angel", "robots/arm.angle"),
            (f"{arm.web}/angel", f"{arm.web}/angle"),
            ("localhost.lod", None),
        ):
            done = arm.run(f"{command} {typed}{end}")
            hint = f" (did you mean {meant}?)"
            assert done.status == 1
            assert done.err.endswith(f"{hint}\n") is (meant is not None), done.err
    why = "unknown: no such property: quite.other"
    assert arm.run("rtget robots/arm.quite.other").err == f"rtget: robots/arm.quite.other: {why}\n"


def test_echo_of_a_failed_action_prints_its_outcome_and_ends_with_1(arm: Any) -> None:
    why = "ValueError: the floor is there"
    assert arm.run("rtset --echo robots/arm.lowered 2") == (
        1,
        f'<call state="failed"><error code="bad-value">{why}</error></call>\n',
        f"rtset: robots/arm.lowered: bad-value: {why}\n",
    )
    assert arm.run("rtset robots/arm.lowered 2") == (0, "", "")  # it has only been started


def test_getters_take_parameters_and_values_are_remembered(arm: Any) -> None:
    assert arm.ok("rtget -p unit=cm robots/arm.reach") == "50\n"
    assert arm.ok("rtget robots/arm.reach.parameters") == '((unit string "m" () ""))\n'
    refused = arm.run("rtget -p colour=red robots/arm.reach")
    assert (refused.status, refused.out) == (1, "")
    assert refused.err == "rtget: robots/arm.reach: bad-parameter: reach has no parameter colour\n"
    for value in ("7", "8", "9"):
        arm.ok(f"rtset robots/arm.name {value}")
    assert arm.ok("rtget robots/arm.name") == '"9"\n'
    assert re.sub(r"[\d.]+ good", "T", arm.ok("rtget robots/arm.name.history")) == (
        '((T "8") (T "9"))\n'
    )


class Thing:
    def __init__(self) -> None:
        self.size = 1


def test_a_listing_is_watched(shell: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", shell.environment["RTKIT_RUNTIME_DIR"])
    environment = {**shell.environment, "TERM": "xterm"}
    with serve(Thing(), "thing", is_on_zenoh=False) as served:
        names = shell.open("rtls --watch=0.05 thing")
        assert names.stdout.readline() == "size\n"
        line = shell.command("rtls -lR --watch=0.05 thing")
        with opened(line, environment, shell.folder) as screen:
            screen.until(r"size +1\r")
            shell.ok("rtset thing.size 2")
            screen.until(r"size +2\r")
            served.owned(lambda: served.service.add("inner.colour", Word("red")))
            screen.until(r"inner.colour +red\r")
            served.owned(lambda: served.service.update("inner.colour", Word("blue")))
            screen.until(r"inner.colour +blue\r")
            screen.type("\x03")
            assert screen.status() == -signal.SIGINT
        assert [names.stdout.readline() for _ in range(3)] == ["\n", "size\n", "inner\n"]
    ended = "rtls: thing: no-service: the connection has ended\n"
    assert shell.end_of(names) == (1, "", ended)


def test_files_and_stdin(arm: Any) -> None:
    content = bytes(range(256)) * 10
    (arm.folder / "in.bin").write_bytes(content)
    arm.ok("rtset --file in.bin robots/arm.picture")
    done = arm.open("rtget --raw robots/arm.picture")
    assert done.stdout.buffer.read() == content
    assert done.wait(30) == 0
    done.communicate()
    outcome = arm.run("rtset robots/arm.name -", text='"two words"\n')
    assert (outcome.status, outcome.err) == (0, "")
    assert arm.ok("rtget --raw robots/arm.name") == "two words"


REFUSED = [
    ("rtget robots/arm.nope", 4, "robots/arm.nope: unknown: no such property: nope"),
    ("rtget nope.x", 5, "nope.x: no-service: no service named nope (there is robots/arm)"),
    (
        "rtset robots/arm.angle red",
        2,
        "robots/arm.angle: bad-value: expected number, found word red",
    ),
    ("rtset -p x=1 robots/arm.name", 2, "robots/arm.name: bad-value: a value is needed: no action"),
    ("rtset -p by=1 robots/arm.nope", 4, "robots/arm.nope: unknown: no such property: nope"),
    ("rtset robots/arm.angle ((", 2, "robots/arm.angle: syntax: 2 expected )"),
    ("rtset --if 99 robots/arm.name x", 1, "robots/arm.name: conflict: revision of name is 1"),
    (
        "rtset robots/arm.angle.meta 3",
        1,
        "robots/arm.angle.meta: read-only: cannot be set: angle.meta",
    ),
    ("rtlisten robots/arm.gui", 1, "robots/arm.gui: read-only: cannot be listened to: gui"),
    ("rtget -p x=1 robots/arm.name", 2, "robots/arm.name: bad-parameter: name has no parameter x"),
    ("rtlisten robots/arm.nope", 4, "robots/arm.nope: unknown: no such property: nope"),
    ("rtserve arm:Arm robots/arm", 1, "a service named 'robots/arm' is running already"),
    (
        "rtget http://localhost:1/ps/x",
        5,
        "http://localhost:1/ps/x: no-service: cannot reach http://localhost:1: Connection refused",
    ),
    ("rtserve arm:Leg x", 4, "nothing of that name in arm: Leg"),
    ("rtserve arm:broken x", 1, "arm:broken: ValueError: no arm"),
    ("rtserve legs:Leg x", 4, "no such module: legs"),
    ("rtserve arm:Arm 'a b'", 2, "not a name of a service: 'a b'"),
]


def test_refusals_are_one_line(arm: Any) -> None:
    arm.environment["RTKIT_EXIT_DETAIL"] = "1"
    for line, status, error in REFUSED:
        outcome = arm.run(line)
        assert (outcome.status, outcome.err) == (status, f"{line.split()[0]}: {error}\n"), line
        assert outcome.out == ""


def test_a_listener_hears_that_the_service_has_gone(shell: Any) -> None:
    process = shell.open("rtserve statistics:NormalDist noise -a 10 -a 2")
    assert process.stdout.readline() == "/localhost/noise\n"
    listening = shell.open("rtlisten noise.mean")
    assert listening.stdout.readline() == "10.0\n"
    process.kill()
    process.communicate()
    assert listening.communicate(timeout=30) == (
        "", "rtlisten: noise.mean: no-service: the connection has ended\n")  # fmt: skip
    assert listening.returncode == 1
    assert shell.run("rtget noise.mean").err.startswith("rtget: noise.mean: no-service: ")
    again = shell.open("rtserve statistics:NormalDist noise")
    assert again.stdout.readline() == "/localhost/noise\n"
    assert json.loads(shell.ok("rtget --json noise.stdev"))["value"] == 1.0
    again.send_signal(signal.SIGINT)
    assert again.wait(30) == -signal.SIGINT
    again.communicate()
