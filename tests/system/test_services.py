"""Service ports on real processes: called, refused, stuck, killed."""

from __future__ import annotations

import json
import os
import select
import signal
import time
from typing import Any

import jsonrecords
import pytest

from rtkit.deployment import actions as act
from rtkit.errors import Refused, RtkitError
from rtkit.resources import resource
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect

KEEPS_MANAGER = True

FILE = resource("profiles", "systems", "my-service.xml")
PEERS = """
import os
import time
from typing import Protocol
from rtkit.component import Component, ServicePort, raises, returns


class Work(Protocol):
    def work(self, how: str) -> str: ...


class Again(Protocol):
    def again(self) -> str: ...


class Busy(Exception):
    def __init__(self, seconds: float):
        self.seconds = seconds


class Hand(Protocol):
    @raises(Busy)
    @returns("", "width")
    def grip(self, force: float, words: list[str]) -> tuple[bool, float]: ...

    def again(self) -> str: ...


class Peer(Component):
    \"\"\"Offers Work and Again; calls Work on activation, as its parameter says.\"\"\"

    rate = 100.0
    offered = ServicePort.provided(Work).provide(Again)
    hand = ServicePort.provided(Hand).provide(Again, "second")
    needed = ServicePort.required(Work, timeout_s=0.3)

    def on_activated(self, context):
        self.logger.info("answered: %s", self.needed.client.work(self.options.get("how", "")))

    def work(self, how):
        if how == "raise":
            raise ValueError("not today")
        if how == "stuck":
            if os.path.exists(os.environ["RTKIT_STATE_DIR"] + "/diary"):
                fd = os.open(os.environ["RTKIT_STATE_DIR"] + "/diary", os.O_WRONLY)
                os.write(fd, b"stuck\\n")
            while True:
                time.sleep(60)
        if how == "sleep":
            time.sleep(0.5)
        if how == "back":
            return self.needed.client.work("back")
        return "done by " + self.instance

    def again(self):
        return "again"

    def grip(self, force, words):
        if force > 9:
            raise Busy(2.5)
        return len(words) > 0, force / 2


def PeerInit(manager):
    manager.register_factory(Peer)
"""


@pytest.fixture
def tree(tree: Tree, manager: Any) -> Tree:
    (manager.modules / "Peer.py").write_text(PEERS)
    return tree


def peer(tree: Tree, instance: str, place: str, how: str = "") -> None:
    create = f"Peer?instance_name={instance}&how={how}"
    tree.perform(act.Create(f"{create}&manager_name={place}" if place else create))


def wire(tree: Tree, consumer: str, provider: str, **properties: str) -> None:
    ends = (PortRef(consumer, "needed"), PortRef(provider, "offered"))
    named = {key.replace("__", "."): value for key, value in properties.items()}
    tree.perform(act.Connect(ConnectorProfile(consumer + provider, "w", ends, named)))


def activate(tree: Tree, instance: str) -> None:
    tree.perform(act.ChangeState(instance, "0", Transition.ACTIVATE))


@pytest.mark.parametrize("place", ["near", "far"])
def test_calls_in_one_process_and_between_two(tree: Tree, place: str) -> None:
    peer(tree, "A", "near")
    peer(tree, "B", place)
    wire(tree, "A", "B")
    activate(tree, "A")
    facts = tree.snapshot().component("A")
    assert facts is not None
    assert (facts.state, facts.cause) == ("Active", "")
    tree.perform(act.Disconnect("AB"))
    tree.perform(act.ChangeState("A", "0", Transition.DEACTIVATE))
    with pytest.raises(Refused, match=r"A.needed: no provider of Work is connected"):
        activate(tree, "A")


@pytest.mark.parametrize("place", ["near", "far"])
def test_an_exception_of_the_provider_is_named_to_the_caller(tree: Tree, place: str) -> None:
    peer(tree, "A", "near", "raise")
    peer(tree, "B", place)
    wire(tree, "A", "B")
    told = r"Refused: B.offered: Work.work failed: ValueError: not today \(Peer.py:\d+ in work\)"
    with pytest.raises(Refused, match=told):
        activate(tree, "A")


def test_a_provider_that_is_stuck_holds_up_its_caller_no_longer_than_the_time_out(
    tree: Tree,
) -> None:
    peer(tree, "A", "", "stuck")
    peer(tree, "B", "far")
    wire(tree, "A", "B", service__timeout="0.2")
    with pytest.raises(Refused, match=r"A.needed: B.offered: Work.work: no answer within 0.2 s"):
        activate(tree, "A")
    tree.perform(act.Disconnect("AB"))
    wire(tree, "A", "B")
    tree.perform(act.Delete("B"))
    assert tree.snapshot().component("B") is None


def test_two_that_wait_for_each_other_are_bounded(tree: Tree) -> None:
    peer(tree, "A", "one", "back")
    peer(tree, "B", "two", "back")
    wire(tree, "A", "B")
    wire(tree, "B", "A")
    # Both waits end at one moment: either may be told first.
    with pytest.raises(Refused, match=r"B\.offered: Work\.work.*: no answer within 0.3 s"):
        activate(tree, "A")
    for instance in ("A", "B"):
        tree.perform(act.Delete(instance))


def test_a_provider_that_is_killed_is_noticed_at_once(tree: Tree, notes: Any) -> None:
    peer(tree, "A", "", "stuck")
    peer(tree, "B", "far")
    wire(tree, "A", "B", service__timeout="60")
    far = next(p for p in tree.snapshot().processes if p.name == "far")
    tree.perform(act.ChangeState("A", "0", Transition.ACTIVATE, wait=False))
    assert notes.next(1) == ["stuck"]
    os.kill(far.pid, signal.SIGKILL)
    with pytest.raises(Refused, match=r"precondition not met \(state is Error\)"):
        tree.perform(act.ChangeState("A", "0", Transition.ACTIVATE))
    facts = tree.snapshot().component("A")
    assert facts is not None
    assert "A.needed: B.offered: Work.work: the provider is gone" in facts.cause


def test_what_does_not_match_is_refused(manager: Any, tree: Tree) -> None:
    peer(tree, "A", "")
    peer(tree, "B", "far")
    a, b = "/localhost/A.rtc", "/localhost/B.rtc"
    for ends, why in (
        (f"{a}:needed {b}:needed", "Polarities do not match."),
        (f"{a}:offered {b}:offered", "Polarities do not match."),
    ):
        outcome = manager.run(f"rtcon {ends}")
        assert (outcome.status, outcome.out) == (1, "")
        assert why in outcome.err
    manager.ok(f"rtcon {a}:needed {b}:offered")
    shown = manager.ok(f"rtcat -ll {b}:offered")
    for word in ("Interface:", "Work", "Again", "Provided", "/localhost/A.rtc:needed"):
        assert word in shown
    manager.ok(f"rtdis {a}:needed {b}:offered")


CALLED = [
    ("offered.work well", 0, "done by P\n", ""),
    ("hand.grip -3 [a]", 0, "True\nwidth: -1.5\n", ""),
    ("hand.grip 10 []", 1, "", "rtcall: P.hand: grip raised Busy: seconds=2.5\n"),
    ("hand.second.again", 0, "again\n", ""),
    ("offered.work raise", 1, "", "rtcall: P.offered: Work.work failed: ValueError: not today ("),
    ("needed.work x", 1, "", "rtcall: P.needed provides no interface, it requires some\n"),
    ("handd.grip 1", 1, "", "Port not found: /localhost/P.rtc:handd.grip (did you mean hand?)\n"),
]


def test_operations_are_called_by_hand(tree: Tree, manager: Any) -> None:
    peer(tree, "P", "far")
    for words, status, out, err in CALLED:
        done = manager.run(f"rtcall /localhost/P.rtc:{words}")
        assert (done.status, done.out) == (status, out), words
        assert err in done.err if err else not done.err, words
    assert [row.instance for row in tree.listing().rows] == ["P"]
    assert not tree.snapshot().connectors


def test_calls_as_json(tree: Tree, manager: Any) -> None:
    peer(tree, "P", "far")
    line = "rtcall --json /localhost/P.rtc:hand"
    [called] = jsonrecords.checked(manager.ok(f"{line}.grip 1 []"))
    assert (called["schema"], called["result"]) == ("rtkit.call/1", False)
    assert (called["out"], called["raised"]) == ({"width": 0.5}, None)
    [raised] = jsonrecords.checked(manager.run(f"{line}.grip 10 []").out)
    assert raised["raised"] == {"name": "Busy", "members": {"seconds": 2.5}}
    listed = jsonrecords.checked(manager.ok(line))
    assert {each["schema"] for each in listed} == {"rtkit.operation/1"}
    assert [each["path"].partition(":")[2] for each in listed] == [
        "hand.hand.grip",
        "hand.hand.again",
        "hand.second.again",
    ]
    again = manager.run("rtcall /localhost/P.rtc:hand.again").err
    assert "several interfaces: hand.again or second.again" in again


def test_connection_limits_hold_for_services(tree: Tree) -> None:
    for name in ("A", "B"):
        peer(tree, name, "near")
    tree.perform(
        act.Create("Peer?instance_name=C&manager_name=far&port.service.offered.connection_limit=1")
    )
    wire(tree, "A", "C")
    with pytest.raises(RtkitError, match="takes no more than 1"):
        wire(tree, "B", "C")
    assert [w.connector_id for w in tree.snapshot().connectors] == ["AC"]
    tree.perform(act.Disconnect("AC"))
    wire(tree, "B", "C")


def test_the_samples_as_a_system(manager: Any) -> None:
    assert manager.run(f"rtresurrect {FILE}") == (0, "", "")
    names = ("MyServiceProvider0", "MyServiceConsumer0")
    manager.ok("rtact " + " ".join(f"/localhost/{name}.rtc" for name in names))
    assert manager.ok(f"rtcheck {FILE}") == ""
    told = json.loads(manager.ok("rtcat --json /localhost/MyServiceConsumer0.rtc"))
    assert told["state"] == "Active"
    manager.ok(f"rtteardown {FILE}")


def test_calls_go_on_while_the_manager_is_away_and_the_next_one_knows_of_them(
    manager: Any, tree: Tree
) -> None:
    peer(tree, "A", "near")
    peer(tree, "B", "far")
    wire(tree, "A", "B")
    status = json.loads(manager.ok("rtmgr status --json"))
    pidfd = os.pidfd_open(status["pid"])
    os.kill(status["pid"], signal.SIGKILL)
    assert select.select([pidfd], [], [], 10.0)[0]
    os.close(pidfd)
    manager.ok("rtmgr start")
    with connect() as later:
        assert [w.connector_id for w in later.snapshot().connectors] == ["AB"]
        activate(later, "A")
        later.perform(act.Disconnect("AB"))
        later.perform(act.ChangeState("A", "0", Transition.DEACTIVATE))
        with pytest.raises(Refused, match="no provider of Work is connected"):
            activate(later, "A")


# components that call each other

MUTUAL = """
import threading
import time
from typing import Protocol
from rtkit.component import Component, ServicePort, raises, returns


class Work(Protocol):
    def work(self) -> str: ...


class Mutual(Component):
    \"\"\"Calls the other with its own lock held, which it also needs to be called.\"\"\"

    rate = 50.0
    offered = ServicePort.provided(Work)
    needed = ServicePort.required(Work, timeout_s=0.4)

    def on_initialize(self):
        self.lock = threading.Lock()

    def on_execute(self, context):
        with self.lock:
            time.sleep(0.1)  # until the other holds its own too
            self.needed.client.work()

    def work(self):
        with self.lock:
            return "done by " + self.instance


class Nested(Component):
    \"\"\"Is called back by whom it calls, with its lock held.\"\"\"

    rate = 50.0
    offered = ServicePort.provided(Work)
    needed = ServicePort.required(Work, timeout_s=0.4)

    def on_initialize(self):
        self.lock = threading.Lock()

    def on_activated(self, context):
        if self.options.get("locks"):
            with self.lock:
                self.logger.info("answered: %s", self.needed.client.work())
        else:
            self.logger.info("answered: %s", self.needed.client.work())

    def work(self):
        if self.options.get("calls"):
            return self.needed.client.work()
        with self.lock:
            return "done by " + self.instance


def MutualInit(manager):
    manager.register_factory(Mutual)
    manager.register_factory(Nested)
"""


@pytest.fixture
def mutual(tree: Tree, manager: Any) -> Tree:
    (manager.modules / "Mutual.py").write_text(MUTUAL)
    tree.perform(act.Load("Mutual.py"))
    return tree


def pair(tree: Tree, kind: str, places: tuple[str, str], *options: str) -> None:
    for instance, place, more in zip("AB", places, options or ("", ""), strict=True):
        where = f"&manager_name={place}" if place else ""
        tree.perform(act.Create(f"{kind}?instance_name={instance}{where}{more}"))
    wire(tree, "A", "B")
    wire(tree, "B", "A")


PLACES = [("near", "near"), ("near", "far"), ("", "")]


@pytest.mark.parametrize("places", PLACES)
def test_two_that_wait_for_each_other_are_parted_by_the_time_out_and_both_named(
    mutual: Tree, places: tuple[str, str]
) -> None:
    pair(mutual, "Mutual", places)
    mutual.apply(
        [act.ChangeState(each, "0", Transition.ACTIVATE) for each in "AB"], is_ordered=False
    )

    def causes() -> dict[str, str]:
        return {row.instance: row.cause for row in mutual.listing().rows if row.cause}

    deadline = time.monotonic() + 30.0
    while not (told := causes()):
        assert time.monotonic() < deadline, mutual.listing()
    ((instance, cause), *_) = told.items()
    other = "B" if instance == "A" else "A"
    why = f"Unreachable: {instance}.needed: {other}.offered: Work.work: no answer within 0.4 s"
    assert cause.startswith(why), cause
    if places[0] == places[1]:
        assert f"they call each other: {instance} → {other} → {instance}" in cause


@pytest.mark.parametrize("places", PLACES)
def test_one_that_is_called_back_while_it_holds_its_lock(
    mutual: Tree, places: tuple[str, str]
) -> None:
    pair(mutual, "Nested", places, "&locks=1", "&calls=1")
    with pytest.raises(Refused, match=r"A\.needed: B\.offered|B\.needed: A\.offered") as failure:
        activate(mutual, "A")
    if places[0] == places[1]:
        assert "they call each other: B → A → B" in str(failure.value)


@pytest.mark.parametrize("places", PLACES)
def test_one_that_is_called_back_without_a_lock_is_answered(
    mutual: Tree, places: tuple[str, str]
) -> None:
    pair(mutual, "Nested", places, "", "&calls=1")
    activate(mutual, "A")


def test_calls_that_do_not_come_back_are_bounded_in_number(mutual: Tree, manager: Any) -> None:
    (manager.modules / "Storm.py").write_text(STORM)
    mutual.perform(act.Load("Storm.py"))
    pair(mutual, "Storm", ("near", "near"), "&waits=1", "")
    (pid,) = [process.pid for process in mutual.snapshot().processes if process.name == "near"]
    told = r"B.needed: A.offered: Work.work: 16 earlier calls have not come back; they call"
    with pytest.raises(Refused, match=told):
        activate(mutual, "A")
    assert len(os.listdir(f"/proc/{pid}/task")) < 40
    mutual.perform(act.Delete("A"))
    mutual.perform(act.Delete("B"))


STORM = """
import threading
from typing import Protocol
from rtkit.component import Component, ServicePort
from rtkit.errors import Unreachable


class Work(Protocol):
    def work(self) -> str: ...


class Storm(Component):
    \"\"\"A calls B, which calls A back for ever; A does not answer.\"\"\"

    offered = ServicePort.provided(Work)
    needed = ServicePort.required(Work, timeout_s=0.02)

    def on_activated(self, context):
        self.needed.client.work()

    def work(self):
        if self.options.get("waits"):
            threading.Event().wait()
        while True:
            try:
                self.needed.client.work()
            except Unreachable as error:
                if "no answer" not in str(error):
                    raise


def StormInit(manager):
    manager.register_factory(Storm)
"""
