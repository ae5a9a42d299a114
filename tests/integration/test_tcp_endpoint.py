"""A manager's session and TCP endpoint, with and without clients, end without a word of zenoh."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

ROUNDS = 15
"""How often in one process; a wrong order of closing panicked in an eighth of all cases."""

SCRIPT = """
import os, socket, sys, threading
from contextlib import ExitStack
from rtkit.link import zenoh_keys, places, secret
from rtkit.link import tcp_endpoint as door
from rtkit.link.zenoh import ZenohLink, open_client, open_listener, unix_endpoint
from rtkit.manager.endpoints.listening_process import TcpEndpoint
from rtkit.manager.endpoints.ports import open_ports
from rtkit.manager.initial_state import initial_state
from rtkit.settings.configuration import CommandLineSettings, read

settings = read(CommandLineSettings(overrides=("net.endpoints:localhost:0",))).settings
for number in range(int(sys.argv[1])):
    name = f"m{number}"
    state = initial_state(name, "/", settings)
    inner = unix_endpoint(places.manager_socket(name))
    with ExitStack() as stack:
        session = open_listener(inner)
        link = ZenohLink(session)
        stack.callback(link.close)
        link.serve(zenoh_keys.service(state.host, name), lambda request: None)
        open_ports(state, session, TcpEndpoint(inner), inner, print, stack)
        stack.callback(link.withdraw)
        clients = []
        silent = []
        if sys.argv[2] == "silence":
            silent = [socket.create_connection((door.LOOPBACK, state.port)) for _ in range(150)]
            for each in silent:
                each.send(b"abc")
        if sys.argv[2] != "alone":
            clients = [door.log_in(state.port, secret.read(), 20.0), open_client(inner, 20.0)]
        leaving = [threading.Thread(target=client.close) for client in clients]
        for thread in leaving[:1]:
            thread.start()
    for thread in leaving[1:]:
        thread.start()
    for thread in leaving:
        thread.join()
print("done", flush=True)
os._exit(0)
"""


EARLY = """
import os, threading
from rtkit.link import places, tcp_endpoint
from rtkit.link.zenoh import open_client, open_listener, unix_endpoint

inner = unix_endpoint(places.manager_socket("m"))
manager, client = open_listener(inner), open_client(inner, 20.0)
identity = tcp_endpoint.Identity("h", "m", "manager")
threading.Timer(0.3, tcp_endpoint.introduce, (manager, identity)).start()
print(tcp_endpoint.ask_identity(client, 20.0) == identity, flush=True)
os._exit(0)
"""


LOST = """
import json, os, zenoh
from rtkit.link import zenoh_keys, places, tcp_endpoint
from rtkit.link.zenoh import open_client, open_listener, unix_endpoint

inner = unix_endpoint(places.manager_socket("m"))
manager, client = open_listener(inner), open_client(inner, 20.0)
identity = tcp_endpoint.Identity("h", "m", "manager")
asked = []

def answer_but_the_first(query):
    asked.append(query)
    if len(asked) > 1:
        query.reply(zenoh_keys.introduction(), json.dumps(identity))
        query.drop()

handler = zenoh.handlers.Callback(answer_but_the_first, indirect=False)
manager.declare_queryable(zenoh_keys.introduction(), handler)
print(tcp_endpoint.ask_identity(client, 5.0) == identity, flush=True)
os._exit(0)
"""


@pytest.fixture
def folder() -> Iterator[Path]:
    """A folder with a path short enough for sockets."""
    folder = Path(tempfile.mkdtemp(prefix="rtk"))
    for name in ("run", "state"):
        (folder / name).mkdir(mode=0o700)
    yield folder
    shutil.rmtree(folder)


@pytest.mark.parametrize("company", ["alone", "company"])
def test_a_manager_with_a_door_ends_in_silence(folder: Path, company: str) -> None:
    assert run(folder, SCRIPT, str(ROUNDS), company) == (0, "done\n", "")


def test_who_connects_and_says_nothing_shuts_no_door(folder: Path) -> None:
    assert run(folder, SCRIPT, "1", "silence") == (0, "done\n", "")


def test_who_asks_before_the_manager_can_be_reached_there_is_answered_then(folder: Path) -> None:
    assert run(folder, EARLY) == (0, "True\n", "")


def test_a_question_that_is_lost_on_the_way_is_repeated(folder: Path) -> None:
    assert run(folder, LOST) == (0, "True\n", "")


def run(folder: Path, script: str, *arguments: str) -> tuple[int, str, str]:
    """Return status, output and errors of a process that runs a script."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(sys.path),
        "RTKIT_RUNTIME_DIR": str(folder / "run"),
        "RTKIT_STATE_DIR": str(folder / "state"),
    }
    done = subprocess.run(
        [sys.executable, "-c", script, *arguments],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr
