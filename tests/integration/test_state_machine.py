"""State machine service: controls real services, is edited under load, and hangs at none."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from state_machine_reference import Reference

import rtkit
from rtkit.services.statemachine import StateMachine
from rtkit.services.statemachine.interpreter import MachineLogEntry
from rtkit.services.statemachine.rdf import read_machine
from rtkit.services.storage import Storage

_BOUND_S = 20.0
HEAD = "@prefix sm: <urn:rtkit:statemachine#> .\n@prefix : <#> .\n"
HOME = f"""{HEAD}
:home a sm:Machine ; sm:initial :dark ; sm:variable [ sm:name "visits" ; sm:value 0 ] .
:dark a sm:State ;
    sm:entry [ sm:set "house/light.on" ; sm:value "false" ] ;
    sm:transition [ sm:when "robots/r1.location.x > 1 and robots/r2.location.x > 1" ; sm:to :lit ] .
:lit a sm:State ; sm:initial :first ; sm:substate :first, :second ;
    sm:entry ( [ sm:set "house/light.on" ; sm:value "true" ]
               [ sm:set "variables.visits" ; sm:expression "variables.visits + 1" ] ) ;
    sm:transition [ sm:when "robots/r1.location.x < 0 or robots/r2.location.x < 0" ; sm:to :dark ] .
:first a sm:State ;
    sm:entry [ sm:set "robots/r1.velocity" ; sm:value "(1 0 0)" ] ;
    sm:transition ( [ sm:when "variables.visits > 1" ; sm:to :second ]
                    [ sm:on "swap" ; sm:to :second ] ) .
:second a sm:State ; sm:entry [ sm:set "robots/r2.velocity" ; sm:value "(2 0 0)" ] .
"""


class Robot:
    """Robot that stands where it is put."""

    def __init__(self) -> None:
        self.location = (0.0, 0.0, 0.0)
        self.velocity = (0.0, 0.0, 0.0)


class Light:
    """Light whose switch may hang."""

    def __init__(self) -> None:
        self.lit = False
        self._is_free = threading.Event()
        self._is_free.set()

    def get_on(self) -> bool:
        return self.lit

    def set_on(self, value: bool) -> None:
        assert self._is_free.wait(_BOUND_S)
        self.lit = value


@pytest.fixture
def client(place: str) -> Iterator[rtkit.Client]:
    with rtkit.Client(timeout_s=_BOUND_S) as client:
        yield client


def until(holds: Callable[[], object]) -> None:
    """Wait until something holds; what is awaited is in another thread's hands."""
    end = time.monotonic() + _BOUND_S
    while not holds():
        assert time.monotonic() < end, "it never came to hold"
        time.sleep(0.005)


def served(ends: ExitStack, machine: StateMachine) -> tuple[Robot, Robot, Light]:
    r1, r2, light = Robot(), Robot(), Light()
    for thing, name in ((r1, "robots/r1"), (r2, "robots/r2"), (light, "house/light")):
        ends.enter_context(rtkit.serve(thing, name))
    ends.enter_context(rtkit.serve(machine, "butler"))
    return r1, r2, light


def test_one_machine_controls_two_robots_and_a_light(client: rtkit.Client, ends: ExitStack) -> None:
    r1, r2, light = served(ends, StateMachine(HOME))
    light.lit = True
    client.set("butler.run", "start")
    assert client.get("butler.state") == "dark"
    until(lambda: not light.lit)
    client.set("robots/r1.location", "(2 0 0)")
    client.set("robots/r2.location.x", "2")
    until(lambda: client.get("butler.state") == "lit.first")
    until(lambda: light.lit and r1.velocity[0] == 1)
    # a transition of the running machine is edited: its condition holds at once
    text = client.get_bytes("butler.machine.lit.first").decode()
    client.set("butler.machine.lit.first", text.replace("variables.visits > 1", "house/light.on"))
    until(lambda: client.get("butler.state") == "lit.second" and r2.velocity[0] == 2)
    client.set("robots/r1.location.x", "-1")
    until(lambda: not light.lit)
    assert "house/light.on" in client.get_bytes("butler/gui.html").decode(), "its graph"
    assert client.get("butler.run.gui").attributes["choices"] == "(start stop pause step)"
    told = [entry[3] for entry in client.get("butler.log") if entry[2] == "transition"]
    assert told == [
        "dark -> lit: when robots/r1.location.x > 1 and robots/r2.location.x > 1",
        "lit.first -> lit.second: when house/light.on",
        "lit.second -> dark: when robots/r1.location.x < 0 or robots/r2.location.x < 0",
    ]


def test_a_machine_has_names_of_its_own_for_services(
    client: rtkit.Client, ends: ExitStack, tmp_path: Path
) -> None:
    (tmp_path / "home.ttl").write_text(HOME.replace("robots/", "").replace("house/", "h/"))
    ends.enter_context(rtkit.serve(Storage(str(tmp_path)), "files"))
    names = "r1=/localhost/robots/r1 h=house h/light=house/lamp r2=robots/r2 store=files"
    machine = StateMachine(source="store.home.ttl", names=names, start=True)
    r1, r2, _ = served(ends, machine)
    lamp = Light()
    with rtkit.serve(lamp, "house/lamp"):
        client.set("robots/r1.location", "(2 0 0)")
        client.set("robots/r2.location", "(2 0 0)")
        until(lambda: lamp.lit and r1.velocity[0] == 1)
        client.set("butler.event", "swap")
        until(lambda: r2.velocity[0] == 2)
    client.set("robots/r1.location", "(-1 0 0)")
    failure = "h/light.on: no-service: "
    until(lambda: any(failure in entry[3] for entry in client.get("butler.log")))
    client.set("butler.save", "store.copy.ttl")
    until(lambda: client.get("butler.source") == "store.copy.ttl")
    assert (tmp_path / "copy.ttl").read_text() == (tmp_path / "home.ttl").read_text()


@pytest.mark.parametrize("names", ["r1", "=robots/r1", "r1=", "r1=a r1=b"])
def test_names_that_are_none_are_refused(names: str) -> None:
    with pytest.raises(rtkit.PropertyError, match=r"^names: "):
        StateMachine(names=names)


class Finder:
    """Finds lights, and has a picture."""

    def __init__(self) -> None:
        self.picture = bytes(range(256)) * 8

    def get_search(self, type: str = "") -> list[str]:
        return ["house/light"] if type == "light" else []


GETTING = f"""{HEAD}
:m a sm:Machine ; sm:initial :find ; sm:variable [ sm:name "light" ; sm:value "" ] .
:find a sm:State ;
    sm:entry [ sm:set "variables.light" ; sm:get "finder.search.0?type=light" ] ;
    sm:transition ( [ sm:when "variables.light != \\"\\"" ; sm:to :use ]
                    [ sm:on "failed.variables.light" ; sm:to :none ] ) .
:use a sm:State ; sm:entry ( [ sm:set "${{light}}.on" ; sm:value "true" ]
                             [ sm:set "files.ball.jpg" ; sm:get "finder.picture" ] ) .
:none a sm:State .
"""


def test_what_is_got_is_used_and_copied(
    client: rtkit.Client, ends: ExitStack, tmp_path: Path
) -> None:
    ends.enter_context(rtkit.serve(Storage(str(tmp_path)), "files"))
    ends.enter_context(rtkit.serve(Finder(), "finder"))
    _, _, light = served(ends, StateMachine(GETTING, start=True))
    until(lambda: light.lit)
    until(lambda: (tmp_path / "ball.jpg").exists())
    assert (tmp_path / "ball.jpg").read_bytes() == Finder().picture
    assert client.get("butler.variables.light") == "house/light"
    client.set("butler.run", "stop")
    client.set("butler.machine", GETTING.replace("type=light", "type=door"))
    client.set("butler.run", "start")
    until(lambda: client.get("butler.state") == "none")


def test_what_is_large_is_got_copied_and_saved(
    client: rtkit.Client, ends: ExitStack, tmp_path: Path
) -> None:
    large = bytes(range(256)) * 5000
    (tmp_path / "a.bin").write_bytes(large)
    copying = f"""{HEAD}:m a sm:Machine ; sm:initial :a .
    :a a sm:State ; sm:entry [ sm:set "files.b.bin" ; sm:get "files.a.bin" ] .\n"""
    (tmp_path / "m.ttl").write_text(copying + "# a long comment\n" * 80_000, encoding="utf-8")
    states = "".join(f'<state id="s{count}_{"x" * 90}"/>' for count in range(11_000))
    scxml = f'<scxml xmlns="http://www.w3.org/2005/07/scxml">{states}</scxml>'
    (tmp_path / "m.scxml").write_text(scxml, encoding="utf-8")
    ends.enter_context(rtkit.serve(Storage(str(tmp_path)), "files"))
    ends.enter_context(rtkit.serve(StateMachine(), "butler"))
    client.set("butler.source", "files.m.scxml")
    assert len(client.get_bytes("butler.machine", form="scxml")) > 1 << 20
    client.set("butler.source", "files.m.ttl")
    client.set("butler.run", "start")
    until(lambda: (tmp_path / "b.bin").exists())
    assert (tmp_path / "b.bin").read_bytes() == large
    client.call("butler.save", "files.n.ttl")
    assert (tmp_path / "n.ttl").read_bytes() == (tmp_path / "m.ttl").read_bytes()
    with pytest.raises(rtkit.PropertyError) as refused:
        client.set("butler.machine", scxml)
    assert refused.value.code == "too-large"


def test_a_long_log_is_read_in_pages_while_events_arrive(
    client: rtkit.Client, ends: ExitStack
) -> None:
    text = f"""{HEAD}:m a sm:Machine ; sm:initial :a .
    :a a sm:State ; sm:transition [ sm:on "x" ; sm:action [ sm:raise "y" ] ] ."""
    butler = StateMachine(text, start=True, length=100_000)
    ends.enter_context(rtkit.serve(butler, "butler"))
    is_over = threading.Event()

    def send() -> None:
        while not is_over.is_set():
            butler.set_event("x")
            is_over.wait(0.0005)

    for _ in range(500):
        butler.set_event("x")
    sender = threading.Thread(target=send)
    sender.start()
    read: list[int] = []
    while len(read) < 1500 or not is_over.is_set():
        page = client.get("butler.log", n=70, since=read[-1] if read else 0)
        read += [each[0] for each in page]
        if len(read) >= 1500:
            is_over.set()
    sender.join(_BOUND_S)
    assert read == [*range(1, len(read) + 1)]
    assert [each[0] for each in client.get("butler.log", n=2)] == [
        len(butler.get_log(10**6)) - 1,
        len(butler.get_log(10**6)),
    ]
    assert butler.get_log(n=5, since=10**9) == butler.get_log(n=-1) == []


def test_the_status_tells_why_it_is_paused(client: rtkit.Client, ends: ExitStack) -> None:
    text = f"""{HEAD}:m a sm:Machine ; sm:initial :a .
    :a a sm:State ; sm:transition [ sm:on "go" ; sm:to :b ] .
    :b a sm:State ; sm:transition ( [ sm:on "go" ; sm:to :a ] [ sm:on "loop" ; sm:to :c ] ) .
    :c a sm:State ; sm:transition [ sm:to :c ] ."""
    ends.enter_context(rtkit.serve(StateMachine(text, start=True), "butler"))
    told = []
    for word in ("pause", "step", "go", "step", "start", "loop"):
        client.set("butler.event" if word in ("go", "loop") else "butler.run", word)
        told.append(client.get("butler.status"))
    assert told == [
        "paused in a: run was set to pause",
        "paused in a: stepping, no transition was enabled",
        "paused in a: stepping, no transition was enabled",
        "paused in b: stepping, a -> b: on go",
        "running",
        "paused in c: error, 100 transitions at once, the last c -> c: at once",
    ]


def test_listeners_hear_of_every_state_in_order(client: rtkit.Client, ends: ExitStack) -> None:
    served(ends, StateMachine(HOME.replace("robots/r1.location.x > 1", "light.x > 1")))
    heard: list[str] = []
    with client.listen("butler.state", lambda change: heard.append(change.value), queue=100):
        client.set("butler.run", "start")
        client.set("butler.machine", HOME.replace("sm:initial :dark", "sm:initial :lit"))
        client.set("butler.run", "stop")
        client.set("butler.run", "start")
        client.set("butler.event", "swap")
        until(lambda: heard[-1:] == ["lit.second"])
    assert heard == ["", "dark", "", "lit.first", "lit.second"]


def test_a_service_that_hangs_or_is_dead_holds_up_nothing(
    client: rtkit.Client, ends: ExitStack
) -> None:
    text = HOME.replace("robots/r1.velocity", "nobody/here.speed")
    text = text.replace(
        '[ sm:on "swap"', '[ sm:on "failed.nobody/here" ; sm:to :second ] [ sm:on "x"'
    )
    _, r2, light = served(ends, StateMachine(text, timeout=0.5))
    light._is_free.clear()
    begun = time.monotonic()
    client.set("butler.run", "start")
    client.set("robots/r1.location.x", "2")
    client.set("robots/r2.location.x", "2")
    until(lambda: client.get("butler.state") == "lit.second")
    until(lambda: r2.velocity[0] == 2)
    until(lambda: any("timeout" in entry[3] for entry in client.get("butler.log")))
    assert time.monotonic() - begun < 5.0
    failed = [entry[3] for entry in client.get("butler.log") if entry[2] == "failed"]
    assert any(each.startswith("nobody/here.speed: no-service: no service ") for each in failed)
    assert any(each.startswith("house/light.on: timeout: ") for each in failed)
    light._is_free.set()


def test_what_is_repeated_to_a_missing_service_is_one_entry_of_the_log(
    client: rtkit.Client, ends: ExitStack
) -> None:
    text = f"""{HEAD}:m a sm:Machine ; sm:initial :a . :a a sm:State ;
    sm:do [ sm:set "robot.velocity" ; sm:value "(1 0 0)" ; sm:every 0.01 ] ."""
    made = StateMachine(text, logs_all=True, start=True)
    ends.enter_context(rtkit.serve(made, "butler"))

    def texts(kind: str) -> list[str]:
        return [entry[3] for entry in client.get("butler.log", n=1000) if entry[2] == kind]

    until(lambda: len(texts("event")) >= 5)  # each time it fails, the machine is told
    assert len(texts("failed")) == 1
    robot = Robot()
    with rtkit.serve(robot, "robot"):
        until(lambda: robot.velocity[0] == 1)
    until(lambda: len(texts("failed")) > 1)
    count = len(texts("event"))
    until(lambda: len(texts("event")) >= count + 5)
    again = texts("failed")[1:]
    assert len(again) == len(set(again))  # it may fail in other words while the service ends


def test_a_service_that_dies_while_it_is_looked_at_is_an_event(
    client: rtkit.Client, ends: ExitStack
) -> None:
    text = f"""{HEAD}:m a sm:Machine ; sm:initial :a .
    :a a sm:State ; sm:transition ( [ sm:when "robot.location.x > 1" ; sm:to :b ]
                                    [ sm:on "failed.robot" ; sm:to :dead ] ) .
    :b a sm:State . :dead a sm:State ; sm:transition [ sm:on "on" ; sm:to :a ] ."""
    robot = rtkit.serve(Robot(), "robot")
    ends.enter_context(rtkit.serve(StateMachine(text, logs_all=True, start=True), "butler"))
    until(lambda: "value" in [entry[2] for entry in client.get("butler.log")])
    robot.close()
    until(lambda: client.get("butler.state") == "dead")
    assert "robot.location.x: no-service: it has gone" in [
        entry[3] for entry in client.get("butler.log")
    ]
    ends.enter_context(rtkit.serve(Robot(), "robot"))
    client.set("butler.event", "on")
    client.set("robot.location.x", "2")
    until(lambda: client.get("butler.state") == "b")


def test_a_guard_waits_for_a_service_that_comes_later(
    client: rtkit.Client, ends: ExitStack
) -> None:
    ends.enter_context(rtkit.serve(StateMachine(HOME, start=True), "butler"))
    assert client.get("butler.state") == "dark"
    for name in ("robots/r1", "robots/r2"):
        robot = Robot()
        robot.location = (3.0, 0.0, 0.0)
        ends.enter_context(rtkit.serve(robot, name))
    until(lambda: client.get("butler.state") == "lit.first")


def test_a_machine_is_got_from_storage_edited_and_saved_there(
    client: rtkit.Client, ends: ExitStack, tmp_path: Path
) -> None:
    (tmp_path / "machines").mkdir()
    (tmp_path / "machines" / "home.ttl").write_text(HOME, encoding="utf-8")
    butler = StateMachine(source="files.machines.home.ttl", start=True)
    ends.enter_context(rtkit.serve(butler, "butler"))
    assert client.get("butler.status").startswith("failed: ")
    ends.enter_context(rtkit.serve(Storage(str(tmp_path)), "files"))
    until(lambda: client.get("butler.state") == "dark")
    assert client.get("butler.status") == "running"
    assert client.get_bytes("butler.machine").decode() == HOME, "as it was written"
    part = client.get_bytes("butler.machine.lit")
    client.set("files.machines.lit.ttl", part)
    client.set("butler.machine.dark.inner", client.get_bytes("files.machines.lit.ttl"))
    assert client.get("butler.state") == "dark.inner.first"
    turnstile = """<scxml xmlns="http://www.w3.org/2005/07/scxml"><state id="locked"/></scxml>"""
    client.set("butler.machine.lit.gate", turnstile)
    ends.enter_context(rtkit.serve(StateMachine(), "other"))
    client.set("other.machine", HOME.replace('"visits" ; sm:value 0', '"visits" ; sm:value 5'))
    client.set("other.machine.kept", client.get_bytes("files.machines.lit.ttl"))
    assert client.get("other.variables.visits") == 5, "its own"
    client.set("other.machine", f"{HEAD}:o a sm:Machine . :dark a sm:State .")
    client.set("other.machine.kept", client.get_bytes("files.machines.lit.ttl"))
    assert client.get("other.variables.visits") == 0, "variables travel with a state"
    client.call("butler.save", "files.machines.new.ttl")
    saved = read_machine((tmp_path / "machines" / "new.ttl").read_text(encoding="utf-8"))
    assert {"dark.inner.second", "lit.gate.locked"} <= set(saved.states)
    assert client.get("butler.source") == "files.machines.new.ttl"


@pytest.mark.parametrize(
    ("target", "value", "code", "why"),
    [
        ("machine", HOME.replace("sm:to :dark", "sm:to :drak"), "bad-value", "line 11: lit: no st"),
        ("machine", "<scxml/>", "bad-value", "line 1: the root is not scxml"),
        ("machine.dark?delete=1", "", "bad-value", "initial state of the machine is none of"),
        ("machine.lit?delete=1", "", "bad-value", "dark: no state to go to: lit"),
        ("machine.lit", "rubbish", "bad-value", "line 1: expected directive"),
        ("machine.none?delete=1", "", "unknown", "no such property"),
        ("variables.visit", "1", "unknown", "did you mean visits?"),
        ("variables.visits", "many", "bad-value", ""),
        ("run", "go", "bad-value", "expected one of start stop pause step"),
        ("run", "step", "conflict", "cannot step: it is running"),
        ("event", "", "bad-value", "an event has a name"),
        ("source", "nobody/files.x", "no-service", ""),
        ("save", "()", "bad-value", "save where?"),
        ("other", "1", "unknown", ""),
        ("state", "lit", "read-only", ""),
    ],
)
def test_what_is_wrong_is_refused_and_changes_nothing(
    client: rtkit.Client, ends: ExitStack, target: str, value: str, code: str, why: str
) -> None:
    butler = StateMachine(HOME, start=True)
    ends.enter_context(rtkit.serve(butler, "butler"))
    until(lambda: "failed" in [entry[2] for entry in client.get("butler.log")])  # there is no light
    before = client.get_bytes("butler.machine"), client.get("butler.log")
    work = client.call if target == "save" else lambda name: client.set(name, value)
    with pytest.raises(rtkit.PropertyError) as refused:
        work(f"butler.{target}")
    assert refused.value.code == code
    assert why in str(refused.value)
    assert (client.get_bytes("butler.machine"), client.get("butler.log")) == before


def test_deleting_the_active_state_must_say_where_to_go(
    client: rtkit.Client, ends: ExitStack
) -> None:
    text = f"""{HEAD}:m a sm:Machine ; sm:initial :a .
    :a a sm:State ; sm:transition [ sm:on "go" ; sm:to :b ] . :b a sm:State ."""
    ends.enter_context(rtkit.serve(StateMachine(text, start=True), "butler"))
    client.set("butler.event", "go")
    client.set("butler.machine.a", f"{HEAD}:a a sm:State .")
    with pytest.raises(rtkit.PropertyError, match="say where to go: goto=STATE") as refused:
        client.set("butler.machine.b", "", delete=True)
    assert (refused.value.code, client.get("butler.state")) == ("conflict", "b")
    client.set("butler.machine.b", "", delete=True, goto="a")
    assert client.get("butler.state") == "a"
    assert client.get("butler.machine.properties") == ("a",)


def test_an_edit_of_what_was_edited_meanwhile_is_refused(
    client: rtkit.Client, ends: ExitStack
) -> None:
    ends.enter_context(rtkit.serve(StateMachine(HOME), "butler"))
    revision = client.get("butler.machine.meta.revision")
    part = client.get_bytes("butler.machine.lit.first").decode()
    client.set("butler.machine.lit.first", part.replace("swap", "turn"))
    assert client.get("butler.edits") == 1
    for condition in ({"edits": 0}, {"if": revision}):
        with pytest.raises(rtkit.PropertyError) as refused:
            client.set("butler.machine", HOME, **condition)
        assert refused.value.code == "conflict"
    assert "turn" in client.get_bytes("butler.machine").decode()
    client.set("butler.machine", HOME, edits=1)
    assert client.get_bytes("butler.machine").decode() == HOME
    assert client.get("butler.edits") == 2


EDITED = f"""{HEAD}
:m a sm:Machine ; sm:initial :a ; sm:variable [ sm:name "n" ; sm:value 0 ] .
:a a sm:State ; sm:initial :x ; sm:substate :x, :y ;
    sm:transition ( [ sm:on "go" ; sm:to :b ] [ sm:on "tick" ;
        sm:action [ sm:set "variables.n" ; sm:expression "variables.n + 1" ] ] ) .
:x a sm:State ; sm:transition [ sm:when "meter.value > 50" ; sm:to :y ] .
:y a sm:State ; sm:transition [ sm:when "meter.value < 50" ; sm:to :x ] .
:b a sm:State ; sm:transition ( [ sm:on "go" ; sm:to :a ] [ sm:on "tick" ; sm:to :b ;
        sm:action [ sm:set "variables.n" ; sm:expression "variables.n + 1" ] ] ) .
"""


class Meter:
    """Meter whose value a thread pushes."""

    def __init__(self) -> None:
        self.value = 0

    def __served__(self, publish: Callable[[str, object], None]) -> None:
        self._publish = publish


def test_a_hundred_edits_at_a_thousand_events_a_second_lose_nothing(
    client: rtkit.Client, ends: ExitStack
) -> None:
    butler = StateMachine(EDITED, length=1_000_000, logs_all=True, start=True)
    meter = Meter()
    ends.enter_context(rtkit.serve(meter, "meter"))
    ends.enter_context(rtkit.serve(butler, "butler"))
    is_over = threading.Event()
    sent = {"tick": 0, "go": 0}

    def send(name: str, rate: float) -> None:
        with rtkit.Client(timeout_s=_BOUND_S) as own:
            begun = time.monotonic()
            while not is_over.is_set():
                assert own.ask_all([rtkit.Ask("butler.event", name)] * 5, _BOUND_S) == [""] * 5
                sent[name] += 5
                time.sleep(max(0.0, begun + sent[name] / rate - time.monotonic()))

    def push() -> None:
        begun, count = time.monotonic(), 0
        while not is_over.is_set():
            count += 1
            meter._publish("value", count % 100)
            time.sleep(max(0.0, begun + count / 500 - time.monotonic()))

    threads = [threading.Thread(target=send, args=each) for each in (("tick", 500), ("go", 250))]
    threads.append(threading.Thread(target=push))
    for each in threads:
        each.start()
    begun = time.monotonic()
    for count in range(100):
        until(lambda: time.monotonic() > begun + 0.01 * count and sum(sent.values()) >= 6 * count)  # noqa: B023
        if count % 2:
            limit, more = 40 + count % 20, ""
            if count % 3 == 0:
                more = f':c{count} a sm:State ; sm:transition [ sm:on "tick" ; sm:to :a ] .'
            client.set("butler.machine", EDITED.replace("50", str(limit)) + more)
        else:
            way = f'[ sm:when "meter.value < {count % 50}" ; sm:to <#a.x> ]'
            client.set("butler.machine.a.y", f"{HEAD}:y a sm:State ; sm:transition {way} .")
    took = time.monotonic() - begun
    is_over.set()
    for each in threads:
        each.join(_BOUND_S)
    client.set("butler.run", "pause")
    log = [MachineLogEntry(*each) for each in butler.get_log(n=10**7, detail=True)]
    assert [each.number for each in log] == [*range(1, len(log) + 1)]
    events = [each.text for each in log if each.kind == "event"]
    assert {name: events.count(name) for name in sent} == sent, "no event is lost"
    assert sum(each.kind == "edited" for each in log) == 100
    inputs = sum(each.kind in ("event", "value") for each in log)
    assert inputs >= 600, f"{inputs} events in {took:.1f} s"
    print(f"{inputs / took:.0f} events/s")
    reference = Reference(read_machine(EDITED))
    reference.replay(log, read_machine)
    done = [(e.kind, e.text) for e in log if e.kind in ("transition", "set", "assign")]
    assert reference.outputs == done
    assert reference.leaf == client.get("butler.state")
    assert reference.variables["n"] == client.get("butler.variables.n") == sent["tick"]
