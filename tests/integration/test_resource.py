"""The resource service knows what lives, finds what fits by live values, passes on, and starts."""

from __future__ import annotations

import math
import os
import random
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from time import monotonic
from typing import Any

import pytest
from asking import code, until

import rtkit
from rtkit.errors import Refused
from rtkit.services.resource import Resource

_BOUND_S = 20.0
_LIGHTS = """
import sys, time
import rtkit
class Light:
    type = ("light", "lamp")
    def __init__(self, x):
        self.location = (float(x), 0.0, 0.0, 0.0, 0.0, 0.0)
        self.level = x / 10
        self._slow_s = 0.0
        self.asked = 0
    def get_heat(self):
        self.asked += 1
        time.sleep(self._slow_s)
        return 20.0 + self.level
    def slow(self, seconds: float):
        self._slow_s = seconds
served = {x: rtkit.serve(Light(int(x)), f"lights/l{x}", is_on_zenoh=False) for x in sys.argv[1:]}
print("up", flush=True)
for line in sys.stdin:
    for x in line.split():
        served[x].close()
    print("closed", flush=True)
"""

_STARTER = """
import sys
import rtkit
from rtkit.services.resource import Resource
with rtkit.serve(Resource(period=0.2, starts=tuple(sys.argv[1:])), "resource", is_on_zenoh=False):
    with rtkit.Client(timeout_s=20) as client:
        print(client.call("resource.start", "light"), flush=True)
    sys.stdin.read()
"""


class Lights:
    """A process with lights, named after their places."""

    def __init__(self, places: Sequence[int]) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", _LIGHTS, *map(str, places)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == b"up\n"

    def close_some(self, places: Sequence[int]) -> None:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(f"{' '.join(map(str, places))}\n".encode())
        self.process.stdin.flush()
        assert self.process.stdout.readline() == b"closed\n"

    def kill(self) -> None:
        self.process.kill()
        self.process.communicate()

    def close(self) -> None:
        self.process.communicate(b"")


@pytest.fixture
def client(place: str) -> Iterator[rtkit.Client]:
    with rtkit.Client(timeout_s=_BOUND_S) as client:
        yield client
    for left in os.listdir(f"{place}/run"):  # of those that were killed
        os.unlink(f"{place}/run/{left}")


def served(resource: Resource) -> Any:
    return rtkit.serve(resource, "resource", is_on_zenoh=False)


def test_services_are_found_by_type_place_and_live_condition(client: rtkit.Client) -> None:
    lights = Lights(range(1, 5))
    with served(Resource(period=0.2)):
        until(lambda: len(client.get("resource.search", type="light")) == 4)
        assert client.get("resource.lights.l1.meta.type") == "element"
        assert client.get("resource.lights.l1") == rtkit.Element(
            "service",
            {"type": "light lamp"},
            (rtkit.Element("contact", {"protocol": "unix"}, (), rtkit.Word("lights/l1")),),
        )
        assert "resource" in client.get("resource.search", type="resource")
        assert client.get("resource.search", near=(2.0, 0.0, 1.1), type="lamp") == (
            "lights/l1",
            "lights/l2",
            "lights/l3",
        )
        assert client.get("resource.search", where="level > 0.25") == ("lights/l3", "lights/l4")
        client.set("lights/l1.level", 1.0)
        both = "level >= 0.4 and location.x < 2"
        assert client.get("resource.search", where=both) == ("lights/l1",)
        assert client.get("resource.search", where="name ~ */l3") == ("lights/l3",)
        for where, services in {
            'name = "lights/l3"': ("lights/l3",),
            "name ~ 'lights/l*' and level < 0.25": ("lights/l2",),
            "location = (2 0 0 0 0 0)": ("lights/l2",),
            "type != light and name ~ lights/*": (),
            "type = lamp and level != 1": ("lights/l2", "lights/l3", "lights/l4"),
        }.items():
            assert client.get("resource.search", where=where) == services
        for wrong in ("level", "level >", "level >> 2", "level < 1 or level > 2", "level < 1 and "):
            assert code(lambda w=wrong: client.get("resource.search", where=w)) == "bad-parameter"
        place = r"column 15: expected PROPERTY OP VALUE \[and …\]: level > 1 and level"
        with pytest.raises(rtkit.PropertyError, match=place):
            client.get("resource.search", where="level > 1 and level")
        assert code(lambda: client.get("resource.search", near=(1.0,))) == "bad-parameter"
        assert code(lambda: client.get("resource.search", color="red")) == "bad-parameter"
    lights.close()


def test_the_slow_are_named_in_time_and_who_is_killed_is_gone(client: rtkit.Client) -> None:
    events: SimpleQueue[rtkit.PropertyChange] = SimpleQueue()
    lights, others = Lights((1, 2)), Lights((3,))
    with served(Resource()):
        until(lambda: len(client.get("resource.search", type="light")) == 3)
        client.call("lights/l2.slow", 3.0)
        began = monotonic()
        found = client.get("resource.search", type="light", where="heat > 0", failed=1)
        assert monotonic() - began < 1.0 + 0.5
        assert found[:2] == ("lights/l1", "lights/l3")
        assert found[2] == rtkit.Element("failed", {"code": "timeout"}, (), rtkit.Word("lights/l2"))
        assert client.get("resource.unanswered") == (("lights/l2", "timeout"),)
        with client.listen("resource.lights.properties", events.put):
            assert events.get(timeout=_BOUND_S).value == ("l1", "l2", "l3")
            began = monotonic()
            others.kill()
            assert events.get(timeout=_BOUND_S).value == ("l1", "l2")
            assert monotonic() - began < 4.0
    lights.close()


def test_who_is_silent_for_a_while_is_gone_and_comes_back(client: rtkit.Client) -> None:
    lights = Lights((1, 2))
    with served(Resource(period=0.1)):
        until(lambda: len(client.get("resource.search", type="light")) == 2)
        os.kill(lights.process.pid, signal.SIGSTOP)
        until(lambda: not client.get("resource.search", type="light"))
        os.kill(lights.process.pid, signal.SIGCONT)
        until(lambda: client.get("resource.search", type="light") == ("lights/l1", "lights/l2"))
    lights.close()


def test_a_service_elsewhere_registers_itself_for_a_time(client: rtkit.Client) -> None:
    class Far:
        type = ("far",)
        level = 3

    events: SimpleQueue[rtkit.PropertyChange] = SimpleQueue()
    with rtkit.serve(Far(), "far/one", port=0) as far, served(Resource(watch="", period=0.1)):
        contact = f'<contact protocol="tcp">localhost:{far.port}</contact>'
        entry = f'<service type="x">{contact}</service>'
        with client.listen("resource.properties", events.put):
            events.get(timeout=_BOUND_S)
            client.set("resource.far.one", entry, lease=0.5)
            assert "far" in events.get(timeout=_BOUND_S).value
            until(lambda: client.get("resource.search", where="level = 3") == ("far/one",))
            until(lambda: client.get("resource.search", type="far") == ("far/one",))
            assert "far" not in events.get(timeout=_BOUND_S).value
        client.set("resource.far.one", entry, lease=0)
        client.set("resource.far.one", "<service/>", remove=1)
        assert code(lambda: client.get("resource.far.one")) == "unknown"
        for wrong in ("3", "<service/>", '<service><contact protocol="no">x</contact></service>'):
            assert code(lambda w=wrong: client.set("resource.a", w)) == "bad-value"  # type: ignore[misc]
        assert code(lambda: client.set("resource.a", entry, lease=1e9)) == "bad-parameter"


@pytest.mark.parametrize(
    ("protocol", "address"),
    [
        ("tcp", "desk"),
        ("tcp", "desk:0"),
        ("tcp", "desk:99999"),
        ("tcp", "a b:1"),
        ("tcp", "::1"),
        ("http", "http://desk:1"),
        ("unix", "../../etc/passwd"),
        ("zenoh", "**"),
    ],
)
def test_a_contact_that_leads_nowhere_is_refused_and_harms_nobody(
    client: rtkit.Client, protocol: str, address: str
) -> None:
    lights = Lights((1,))
    with served(Resource(period=0.1, route=True)):
        until(lambda: client.get("resource.search", type="light"))
        contact = f'<service><contact protocol="{protocol}">{address}</contact></service>'
        with pytest.raises(rtkit.PropertyError, match=f"{protocol}: not ") as caught:
            client.set("resource.a", contact)
        assert caught.value.code == "bad-value"
        assert code(lambda: client.get("resource.a")) == "unknown"
        client.set("resource.b", '<service><contact protocol="tcp">[::1]:1</contact></service>')
        assert "b" in client.get("resource.properties")
        assert client.get("resource.lights.l1.level") == 0.1
    lights.close()


def test_requests_are_passed_on_only_where_that_is_allowed(client: rtkit.Client) -> None:
    lights = Lights((1,))
    with served(Resource(period=0.2, route=True)):
        until(lambda: client.get("resource.search", type="light"))
        client.set("resource.lights.l1.level", 0.75)
        assert client.get("lights/l1.level") == 0.75
        assert client.get("resource.lights.l1").name == "service"
        assert client.call("resource.lights.l1.slow", 0.0) is None
    with served(Resource(period=0.2)):
        until(lambda: client.get("resource.search", type="light"))
        assert code(lambda: client.get("resource.lights.l1.level")) == "unknown"
    lights.close()


def test_what_is_on_the_list_is_started_also_by_a_search(client: rtkit.Client) -> None:
    program = _LIGHTS.replace("in sys.stdin", "in iter(lambda: time.sleep(60), 1)")
    command = f"light {sys.executable} -c '{program}' 7"
    with served(Resource(period=0.2, starts=(command, "broken false"))) as it:
        assert client.get("resource.search", type="light") == ()
        assert client.get("resource.search", type="light", start=1) == ("lights/l7",)
        assert client.get("resource.started") == ("light",)
        assert client.get("resource.search", type="light", start=1) == ("lights/l7",)
        assert code(lambda: client.call("resource.start", "tank")) == "denied"
        assert code(lambda: client.call("resource.start", "light; ls")) == "denied"
        assert code(lambda: client.call("resource.start", "broken")) == "internal"
        assert code(lambda: client.get("resource.search", type="tank", start=1)) == "denied"
        it.close()
    assert code(lambda: client.get("lights/l7.level")) == "no-service"


def test_what_is_started_and_does_not_fit_is_stopped_again(client: rtkit.Client) -> None:
    program = _LIGHTS.replace("in sys.stdin", "in iter(lambda: time.sleep(60), 1)")
    command = f"light sh -c '{sys.executable} -c \"$0\" 7; true' '{program}'"
    with served(Resource(period=0.2, starts=(command,))):
        bright = {"type": "light", "where": "level > 0.8", "start": 1, "within": 0.2}
        for _ in range(2):
            with pytest.raises(rtkit.PropertyError, match="none fits: lights/l7 was started, does"):
                client.get("resource.search", **bright)
            assert client.get("resource.started") == ()
            assert client.get("resource.search", type="light") == ()
            assert code(lambda: client.get("lights/l7.level")) == "no-service"
        fits = {"type": "light", "where": "level < 0.8", "start": 1}
        assert client.get("resource.search", **fits) == ("lights/l7",)
        with pytest.raises(rtkit.PropertyError, match="none fits: light was started, and runs"):
            client.get("resource.search", **bright)
        assert client.get("resource.search", **fits) == ("lights/l7",)
    assert code(lambda: client.get("lights/l7.level")) == "no-service"


@pytest.mark.parametrize("left", ["adopt", "end"])
def test_what_a_killed_one_had_started_is_taken_up_by_the_next_of_its_name(
    client: rtkit.Client, left: str
) -> None:
    program = _LIGHTS.replace("in sys.stdin", "in iter(lambda: time.sleep(60), 1)")
    command = f"light sh -c 'exec >/dev/null; {sys.executable} -c \"$0\" 7; true' '{program}'"
    starter = subprocess.Popen(
        [sys.executable, "-c", _STARTER, command], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert starter.stdout is not None
    assert starter.stdout.readline() == b"lights/l7\n"
    with rtkit.serve(Resource(left="end"), "another", is_on_zenoh=False):
        assert client.get("another.started") == ()
        assert client.get("lights/l7.level") == 0.7
    with pytest.raises(Refused, match="running already"):
        served(Resource(left="end"))
    assert client.get("lights/l7.level") == 0.7
    starter.kill()
    starter.communicate()
    assert client.get("lights/l7.level") == 0.7
    with served(Resource(period=0.2, starts=(command,), left=left)):
        is_adopted = left == "adopt"
        assert client.get("resource.started") == (("light",) if is_adopted else ())
        if is_adopted:
            assert client.get("resource.search", type="light", start=1) == ("lights/l7",)
            bright = {"type": "light", "where": "level > 0.8", "start": 1}
            with pytest.raises(rtkit.PropertyError, match="light was started, and runs"):
                client.get("resource.search", **bright)
        else:
            assert code(lambda: client.get("lights/l7.level")) == "no-service"
    assert code(lambda: client.get("lights/l7.level")) == "no-service"


def test_a_kind_that_may_not_be_started_is_denied_before_anything_begins(
    client: rtkit.Client,
) -> None:
    with served(Resource(starts=("light true",))):
        with pytest.raises(rtkit.PropertyError, match='expected one of "light"') as caught:
            client.set("resource.start", "tank")
        assert caught.value.code == "denied"
        assert client.get("resource.start.state") == "idle"


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("sh -c 'echo no such bulb >&2; exit 3'", "x ended with 3: no such bulb"),
        ("false", "x ended with 1$"),
        ("/no/such/program", "x cannot be started: .*No such file"),
    ],
)
def test_a_service_that_ends_at_its_start_is_named_with_its_last_error(
    client: rtkit.Client, command: str, words: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with served(Resource(period=0.2, starts=(f"x {command}",))):
        with pytest.raises(rtkit.PropertyError, match=words) as caught:
            client.get("resource.search", type="x", start=1)
        assert caught.value.code == "internal"
        assert client.get("resource.started") == ()
    assert ("no such bulb" in capfd.readouterr().err) is ("bulb" in words)


def test_what_does_not_register_is_stopped_again(
    client: rtkit.Client, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    monkeypatch.setattr("rtkit.services.resource._STARTING_S", 0.5)
    command = f"x sh -c 'trap \"echo > {place}/ended; exit\" TERM; while :; do sleep 0.1; done'"
    with served(Resource(period=0.2, starts=(command,))):
        assert code(lambda: client.get("resource.search", type="x", start=1)) == "timeout"
        assert client.get("resource.started") == ()
        assert os.path.exists(f"{place}/ended")


def test_searches_at_once_of_what_is_slow_are_each_answered_in_a_second(
    client: rtkit.Client,
) -> None:
    lights = Lights(range(1, 6))
    with served(Resource()), ThreadPoolExecutor(10) as clients:
        until(lambda: len(client.get("resource.search", type="light")) == 5)
        client.call("lights/l2.slow", 3.0)

        def search(_: int) -> tuple[Any, float]:
            began = monotonic()
            found = client.get("resource.search", type="light", where="heat > 0", failed=1)
            return found, monotonic() - began

        outcomes = list(clients.map(search, range(10)))
        assert {tuple(map(str, found[:4])) for found, _ in outcomes} == {
            ("lights/l1", "lights/l3", "lights/l4", "lights/l5")
        }
        assert all(str(found[4].leaf) == "lights/l2" for found, _ in outcomes)
        assert max(took for _, took in outcomes) < 1.0 + 0.5
        assert client.get("lights/l1.asked") <= 5, "they share what they ask"
    lights.close()


def test_frames_have_names(client: rtkit.Client) -> None:
    with served(Resource(frames=("kitchen 1 2 0 0 0 1.5",))):
        assert client.get("resource.frames.kitchen") == (1.0, 2.0, 0.0, 0.0, 0.0, 1.5)
        client.set("resource.frames.hall", (0, 0, 0, 0, 0, 1))
        assert client.get("resource.frames") == ("kitchen", "hall")
        assert code(lambda: client.set("resource.frames.hall", (1, 2))) == "bad-value"
        no_place = (math.nan, 0, 0, 0, 0, 0)
        assert code(lambda: client.set("resource.frames.hall", no_place)) == "bad-value"


@pytest.mark.parametrize("within", [-1, 60, math.inf, math.nan])
def test_a_search_that_would_hold_up_others_is_refused(client: rtkit.Client, within: float) -> None:
    with served(Resource()):
        search = lambda: client.get("resource.search", where="x > 1", within=within)  # noqa: E731
        assert code(search) == "bad-parameter"


@pytest.mark.parametrize(
    ("processes", "each", "killed"),
    [
        (4, 10, "endpoints"),
        pytest.param(10, 50, "endpoints", marks=pytest.mark.campaign),
        pytest.param(10, 50, "process", marks=pytest.mark.campaign),
    ],
)
def test_of_many_services_a_tenth_is_killed_at_random_and_named_in_a_second(
    processes: int, each: int, killed: str, client: rtkit.Client
) -> None:
    """A killed endpoint is one that is no more: its socket refuses, or is gone."""
    count = processes * each
    lights = [Lights(range(at, at + each)) for at in range(0, count, each)]
    chance = random.Random(count)
    with served(Resource()):
        until(lambda: len(client.get("resource.search", type="light")) == count)
        until(lambda: len(client.get("resource.search", where="level >= 0")) == count)
        gone = set(chance.sample(range(count), count // 10))
        if killed == "process":
            at = chance.randrange(processes)
            gone = set(range(at * each, (at + 1) * each))
            lights[at].kill()
        else:
            for at, light in enumerate(lights):
                light.close_some([x for x in gone if x // each == at])
        began = monotonic()
        answer = client.get("resource.search", type="light", where="level >= 0", failed=1)
        took = monotonic() - began
        found = {name for name in answer if isinstance(name, str)}
        named = {str(each.leaf) for each in answer if not isinstance(each, str)}
        assert took < 1.0
        assert found == {f"lights/l{x}" for x in range(count) if x not in gone}
        assert named == {f"lights/l{x}" for x in gone}
        until(lambda: len(client.get("resource.search", type="light")) == count - len(gone))
        assert monotonic() - began < 4.0
        for at, light in enumerate(lights):
            if killed == "endpoints" or at * each not in gone:
                light.close()
