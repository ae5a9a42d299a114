"""Garbage on every door of a manager: it is answered or dropped, and the manager lives on."""

from __future__ import annotations

import json
import os
import random
import socket
import struct
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import zenoh
from waiting import until

from rtkit.container.manager_connection import PROTOCOL
from rtkit.deployment.actions import ChangeState, Create
from rtkit.deployment.batch import Batch, batch_to_text, results_from_text
from rtkit.errors import Malformed, NotFound, Refused, RtkitError
from rtkit.link import zenoh_keys
from rtkit.link.zenoh import ZenohLink, open_client, unix_endpoint
from rtkit.rtc.enums import Transition
from rtkit.tree.client import Tree

KEEPS_MANAGER = True
BOUND_S = 60.0
SEED = 20_240_607
MODULE = """
from rtkit.component import Component, InPort, OutPort, TimedLong

class Thing(Component):
    into = InPort(TimedLong)
    out = OutPort(TimedLong)

def ThingInit(manager):
    manager.register_factory(Thing)
"""


@pytest.fixture
def world(manager: Any, tree: Tree) -> Tree:
    """A manager with a component in a slave."""
    (manager.modules / "Thing.py").write_text(MODULE)
    tree.perform(Create("Thing?instance_name=A&manager_name=s"))
    return tree


def lives(tree: Tree, pid: int) -> None:
    """Check that the manager is the one it was, and works."""
    assert tree.listing().pid == pid
    tree.perform(ChangeState("A", "0", Transition.ACTIVATE))
    tree.perform(ChangeState("A", "0", Transition.DEACTIVATE))
    assert [row.instance for row in tree.listing().rows] == ["A"]


def descriptors(pid: int) -> int:
    return len(list(Path(f"/proc/{pid}/fd").iterdir()))


def frame(message: object) -> bytes:
    payload = message if isinstance(message, bytes) else json.dumps(message).encode()
    return struct.pack("<I", len(payload)) + payload


def throw(path: str, data: bytes, *, is_waiting: bool = False) -> bytes:
    """Send bytes to a socket and return what it answers, nothing unless waited for."""
    keeps_packets = path.endswith(".data")
    kind = socket.SOCK_SEQPACKET if keeps_packets else socket.SOCK_STREAM
    with socket.socket(socket.AF_UNIX, kind) as connection:
        connection.connect(path)
        connection.settimeout(BOUND_S)
        try:
            connection.sendall(data)
            connection.shutdown(socket.SHUT_WR)
            return connection.recv(4096) if is_waiting else b""
        except (BrokenPipeError, ConnectionResetError):
            return b""


# the control socket


def hello(**changes: object) -> dict[str, object]:
    return {"hello": 1, "pid": os.getpid(), "protocol": PROTOCOL, **changes}


HELD = {"components": [], "wires": []}
FRAMES: tuple[object, ...] = (
    {},
    [],
    5,
    None,
    "hello",
    b"",
    b"{",
    b"\xff\xfe",
    b"[" * 100_000,
    b'{"hello":1e999,"pid":1,"protocol":2}',
    b'{"hello":' + b"9" * 10_000 + b',"pid":1,"protocol":2}',
    hello(),
    hello(hello=0),
    hello(hello=None),
    hello(hello=[]),
    hello(hello={}),
    hello(hello=True),
    hello(hello="1"),
    hello(pid=None),
    hello(pid=1),
    hello(pid="1"),
    hello(protocol=0),
    hello(protocol=None),
    {"reply": 1, "value": ""},
    {"facts": {}},
    {"gone": "A"},
    {"pid": os.getpid(), "protocol": PROTOCOL, "found": 5},
    {"pid": 1, "protocol": PROTOCOL, "found": "s", **HELD},
    {"pid": os.getpid(), "protocol": PROTOCOL, "found": "s"},
    {"pid": os.getpid(), "protocol": PROTOCOL, "found": "s", "components": 5, "wires": []},
    {"pid": os.getpid(), "protocol": PROTOCOL, "found": "s", "components": [5], "wires": [5]},
    {"pid": os.getpid(), "protocol": 1, "found": "s", **HELD},
)


def test_a_first_message_that_is_wrong_is_refused(world: Tree) -> None:
    pid = world.listing().pid
    path = f"{os.environ['RTKIT_RUNTIME_DIR']}/manager.ctl"
    throw(path, b"\x01\0\0\0?", is_waiting=True)  # the first refusal opens the log
    before = descriptors(pid)
    for message in FRAMES:
        assert throw(path, frame(message), is_waiting=True) == b"", message
        until(lambda: descriptors(pid) <= before, "the connection's end")
        lives(world, pid)


def test_a_thousand_random_and_a_thousand_mutated_frames(world: Tree) -> None:
    pid = world.listing().pid
    path = f"{os.environ['RTKIT_RUNTIME_DIR']}/manager.ctl"
    throw(path, b"\x01\0\0\0?", is_waiting=True)  # the first refusal opens the log
    before = descriptors(pid)
    chance = random.Random(SEED)
    good = [frame(message) for message in FRAMES if not isinstance(message, bytes)]
    for _ in range(1000):
        throw(path, chance.randbytes(chance.randrange(200)))
        mutated = bytearray(chance.choice(good))
        for _ in range(chance.randrange(1, 4)):
            mutated[chance.randrange(len(mutated))] = chance.randrange(256)
        throw(path, bytes(mutated))
    until(lambda: descriptors(pid) <= before, "the connections' ends")
    lives(world, pid)


def test_messages_of_any_length_and_in_pieces(world: Tree) -> None:
    pid = world.listing().pid
    path = f"{os.environ['RTKIT_RUNTIME_DIR']}/manager.ctl"
    throw(path, struct.pack("<I", 0xFFFFFFFF), is_waiting=True)
    throw(path, struct.pack("<I", 10_000_000) + b" " * 10_000_000, is_waiting=True)
    with socket.socket(socket.AF_UNIX) as slow:
        slow.connect(path)
        for byte in frame(hello())[:-1]:
            slow.send(bytes([byte]))
        lives(world, pid)


def test_many_idle_connections(world: Tree) -> None:
    pid = world.listing().pid
    idle = []
    for _ in range(300):
        connection = socket.socket(socket.AF_UNIX)
        connection.connect(f"{os.environ['RTKIT_RUNTIME_DIR']}/manager.ctl")
        idle.append(connection)
    lives(world, pid)
    for connection in idle:
        connection.close()
    lives(world, pid)


def test_raw_bytes_on_the_sockets_of_the_transport(world: Tree, manager: Any) -> None:
    world.perform(Create("Thing?instance_name=B&manager_name=t"))
    manager.ok("rtcon /localhost/A.rtc:out /localhost/B.rtc:into")
    pid = world.listing().pid
    folder = Path(os.environ["RTKIT_RUNTIME_DIR"])
    chance = random.Random(SEED)
    endpoints = [path for path in folder.iterdir() if path.suffix in (".sock", ".data")]
    assert len(endpoints) > 1
    for endpoint in endpoints:
        for _ in range(200):
            throw(str(endpoint), chance.randbytes(chance.randrange(500)))
    assert world.listing().pid == pid
    manager.ok("rtact /localhost/A.rtc /localhost/B.rtc")


# batches


@pytest.fixture
def link(world: Tree) -> Any:
    """A link of our own to the manager."""
    link = ZenohLink(
        open_client(unix_endpoint(f"{os.environ['RTKIT_RUNTIME_DIR']}/manager.sock"), 5)
    )
    yield link
    link.close()


def key(world: Tree, name: str) -> str:
    return zenoh_keys.property_key(zenoh_keys.service(world.host, "manager"), name)


def batch(*actions: object, **others: object) -> str:
    return json.dumps({"actions": actions, "ordered": True, "timeout": 5.0, **others})


CREATE = {"do": "Create", "create": "Thing"}
BATCHES = {
    "nothing": "",
    "no JSON": "{",
    "deep": "[" * 100_000,
    "deeper": '{"actions":' * 100_000,
    "null": "null",
    "number": "5",
    "list": "[]",
    "text": '"x"',
    "no actions": '{"ordered":true,"timeout":1}',
    "no order": '{"actions":[],"timeout":1}',
    "no time-out": '{"actions":[],"ordered":true}',
    "actions are text": batch() and '{"actions":"abc","ordered":true,"timeout":1}',
    "actions are a number": '{"actions":5,"ordered":true,"timeout":1}',
    "actions are a table": '{"actions":{"do":"Create"},"ordered":true,"timeout":1}',
    "an action is no table": batch(5),
    "an action has no name": batch({"create": "Thing"}),
    "an action is unknown": batch({"do": "Explode"}),
    "an action's name is a list": batch({"do": []}),
    "a field is missing": batch({"do": "Create"}),
    "a field is unknown": batch({**CREATE, "more": 1}),
    "a field is of another type": batch({"do": "Create", "create": 5}),
    "names are no list": batch({**CREATE, "names": "a"}),
    "a pattern is empty": batch({**CREATE, "pattern": {}}),
    "a transition is unknown": batch(
        {"do": "ChangeState", "instance": "A", "context": "0", "transition": "explode"}
    ),
    "a connector is a list": batch({"do": "Connect", "connector": []}),
    "time-out 0": batch(CREATE, timeout=0),
    "time-out negative": batch(CREATE, timeout=-1),
    "time-out not a number": '{"actions":[],"ordered":true,"timeout":NaN}',
    "time-out huge": batch(timeout=10**400),
    "time-out text": batch(timeout="soon"),
    "time-out null": batch(timeout=None),
    "digits": '{"actions":[],"ordered":true,"timeout":' + "9" * 10_000 + "}",
}


def test_a_batch_that_is_none_is_malformed(world: Tree, link: ZenohLink) -> None:
    pid = world.listing().pid
    for case, text in BATCHES.items():
        reply = link.call(key(world, "batch"), text, BOUND_S)
        assert reply.error == "malformed", (case, reply)
        assert "\n" not in reply.text, case
        lives(world, pid)


def test_an_endless_time_out_harms_nobody(world: Tree, link: ZenohLink) -> None:
    pid = world.listing().pid
    for timeout in (1e10, 1e300, float("inf")):
        text = batch({"do": "Create", "create": "Thing?manager_name=manager_%p"}, timeout=timeout)
        (result,) = results_from_text(link.call(key(world, "batch"), text, BOUND_S).value())
        assert result.ok, timeout
        assert world.apply([]) == ()
        assert world.listing().pid == pid


def test_ten_megabytes(world: Tree, link: ZenohLink) -> None:
    pid = world.listing().pid
    assert link.call(key(world, "batch"), "x" * 10**7, BOUND_S).error == "malformed"
    name = "x" * 10**7
    (result,) = results_from_text(
        link.call(key(world, "batch"), batch({"do": "Create", "create": name}), BOUND_S).value()
    )
    assert not result.ok
    many = batch_to_text(Batch((Create("Thing?instance_name=A"),) * 50_000, False, 60.0))
    results = results_from_text(link.call(key(world, "batch"), many, BOUND_S).value())
    assert {result.value for result in results} == {"A"}
    lives(world, pid)


def test_bytes_that_are_no_text(world: Tree) -> None:
    pid = world.listing().pid
    endpoint = unix_endpoint(f"{os.environ['RTKIT_RUNTIME_DIR']}/manager.sock")
    session = open_client(endpoint, 5)
    try:
        for name in ("batch", "stop", "manager.pid"):
            replies = list(
                session.get(
                    key(world, name),
                    payload=b"\xff\xfe\x00",
                    handler=zenoh.handlers.FifoChannel(4),
                    timeout=BOUND_S,
                )
            )
            assert [reply.err is not None for reply in replies] == [True]
        for selector in ("rt/**", "rt/*/*/*/@/**", "rt/**/@/manager.pid", "rt/**/@x/listing?a=b"):
            list(session.get(selector, handler=zenoh.handlers.FifoChannel(16), timeout=2.0))
    finally:
        session.close()  # type: ignore[no-untyped-call]
    lives(world, pid)


NAMES = ["", "a/b", "..", "a\0b", "\n", "\x1b[31m", "x" * 300, "\ud800", "a b ", "%41", "\u202e"]


def test_names_that_cannot_be(world: Tree) -> None:
    pid = world.listing().pid
    for name in NAMES:
        options = (f"Thing?manager_name={name}", f"Thing?instance_name={name}")
        for text in (*options, f"../{name}", name):
            (result,) = world.apply([Create(text)])
            assert result.ok or result.why, text
            assert not set(result.why + result.value) & set("\0\n\x1b"), text
    assert world.listing().pid == pid


def test_properties_that_do_not_exist(world: Tree) -> None:
    for name in ("", "no such", "a/b", "a*b", "**", "a?b", "a#b", "$*", "é"):
        with pytest.raises((NotFound, Malformed)):
            world.get(name)
        with pytest.raises((Refused, NotFound, Malformed)):
            world.set(name, "x")
    with pytest.raises(RtkitError):
        world.set("manager.pid", "1")


def test_views_that_do_not_exist(world: Tree, link: ZenohLink) -> None:
    pid = world.listing().pid
    service = zenoh_keys.service(world.host, "manager")
    for name in ("no", "part", "part/", "part/%zz", "part/%", "listing/x", "snapshot/../x"):
        with suppress(Malformed):  # some of them are no keys
            reply = link.call(zenoh_keys.extension_key(service, name), None, BOUND_S)
            assert reply.error == "not-found" or name.startswith(("part", "listing/"))
    lives(world, pid)
