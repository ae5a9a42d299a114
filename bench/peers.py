"""Measures rtkit beside other systems, installed from the package index: ``python -m bench peers``.

The floor of a row is the other system, so a ratio below one says that rtkit is quicker. Both take
turns in one run. What cannot be installed or started is told with the reason.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial
from pathlib import Path

from bench import ports, properties
from bench.harness import (
    Lines,
    Missing,
    Row,
    command,
    manager,
    process,
    remove,
    timed,
    until_listed,
)
from bench.pairs import Measure, paired
from bench.peer_launchers import ENDS, Dora, supervisord
from bench.peer_packages import PeerMissing, programs, version
from rtkit.link.tcp_endpoint import free_port
from rtkit.tree.client import Tree

_COUNT = 10
_GETS = 300
_ROUNDS = 9
_LAUNCH = f"{_COUNT} processes by one command, until all live, each"
_DORA = ("dora-rs", "dora-rs-cli", "numpy", "pyarrow")


def _beside(what: str, packages: tuple[str, ...], rows: Callable[[Path], Lines]) -> Lines:
    """Measure beside a system when it can be had, else tell why not."""
    try:
        yield from rows(programs(*packages))
    except PeerMissing as error:
        yield Missing(what, str(error))


def _supervised(folder: Path) -> Lines:
    floor_is = f"{version('supervisor')}: supervisorctl starts bare Python processes"
    with manager() as tree, supervisord(folder, _COUNT) as launch_ms:
        measured = paired(partial(_launch_ms, tree), lambda: launch_ms() / _COUNT, _ROUNDS)
        yield Row(f"{_LAUNCH}, beside supervisord", "ms", measured, None, True, floor_is)


def _flows(folder: Path) -> Lines:
    floor_is = f"{version('dora-rs')}: dora start of nodes in Python, its daemon running"
    with manager() as tree, ExitStack() as stack:
        dora = Dora(folder, stack)
        theirs = lambda: dora.launch_ms(_COUNT) / _COUNT  # noqa: E731
        measured = paired(partial(_launch_ms, tree), theirs, _ROUNDS)
        yield Row(f"{_LAUNCH}, beside dora", "ms", measured, None, True, floor_is)


def _launch_ms(tree: Tree) -> float:
    """Make components in slaves of their own by one ``rtmgr``; each until it is Inactive [ms]."""
    line = [command("rtmgr"), "/localhost/manager.mgr"]
    for index in range(_COUNT):
        line += ["-c", f"ConsoleIn?instance_name=N{index}&manager_name=n{index}"]

    def launch() -> None:
        process(line)
        until_listed(tree, _COUNT)

    elapsed_ms = timed(launch)
    remove(tree, _COUNT)
    return elapsed_ms / _COUNT


def _iceoryx2_trips(folder: Path) -> Lines:
    floor_is = f"{version('iceoryx2')} with its events, Python at both ends"
    python = str(folder / "python")
    yield from _trips("iceoryx2", floor_is, partial(ports.raw, "iceoryx2", python=python))


def _dora_trips(folder: Path) -> Lines:
    floor_is = f"{version('dora-rs')}: two nodes in Python, arrow arrays"
    yield from _trips("dora", floor_is, partial(_dora_ends, folder))


def _trips(name: str, floor_is: str, floor: ports.Floor) -> Lines:
    for trip, value in ((ports.SMALL, "a small value"), (ports.IMAGE, "an image of 1 MB")):
        what = f"round trip of {value} through two processes, beside {name}"
        yield from ports.by_placement(what, trip, floor, floor_is, None)


@contextmanager
def _dora_ends(
    programs: Path, folder: str, trip: ports.Trip
) -> Iterator[tuple[Measure, tuple[int, int]]]:
    with ExitStack() as stack:
        dora = Dora(programs, stack)
        yield stack.enter_context(dora.trips(trip.size, trip.trips))


def _gets(name: str, package: str, folder: Path) -> Lines:
    ways: dict[str, AbstractContextManager[Measure]] = {
        "as a line": properties.by_line(),
        "over zenoh": properties.by_zenoh(),
    }
    for way, ours in ways.items():
        with ours as our_us, _peer_get(name, folder) as their_us:
            measured = paired(our_us, their_us)
            what = f"GET of a property {way}, beside {package}"
            yield Row(what, "us", measured, None, True, f"{version(package)}, over TCP")


@contextmanager
def _peer_get(name: str, folder: Path) -> Iterator[Measure]:
    """Run a server of one value and a client; yield what measures a GET of it [us]."""
    port = str(free_port())
    pipe = subprocess.PIPE

    def end(role: str) -> subprocess.Popen[str]:
        words = [str(folder / "python"), ENDS, name, role, port]
        return subprocess.Popen(words, stdin=pipe, stdout=pipe, stderr=pipe, text=True)

    with ExitStack() as stack:
        server = stack.enter_context(end("serve"))
        stack.callback(server.kill)
        _await(server, "ready" if name == "p4p" else "Ready to accept")
        client = stack.enter_context(end("ask"))
        stack.callback(client.kill)
        _await(client, "ready")
        asked, answers = client.stdin, client.stdout
        assert asked is not None
        assert answers is not None

        def measure() -> float:
            asked.write(f"{_GETS}\n")
            asked.flush()
            return float(answers.readline())

        yield measure


def _await(end: subprocess.Popen[str], word: str) -> None:
    assert end.stdout is not None
    for line in end.stdout:
        if word in line:
            return
    assert end.stderr is not None
    told = end.stderr.read().strip().splitlines() or ["it told no reason"]
    raise PeerMissing(told[-1])


_GET = "GET of a property"
_TRIP = "round trip through two processes"
PARTS: dict[str, Callable[[], Lines]] = {
    "supervisord": partial(_beside, f"{_LAUNCH}, beside supervisord", ("supervisor",), _supervised),
    "dora": partial(_beside, f"{_LAUNCH}, beside dora", _DORA, _flows),
    "iceoryx2": partial(_beside, f"{_TRIP}, beside iceoryx2", ("iceoryx2",), _iceoryx2_trips),
    "dora-trip": partial(_beside, f"{_TRIP}, beside dora", _DORA, _dora_trips),
    "tango": partial(
        _beside, f"{_GET}, beside Tango", ("PyTango",), partial(_gets, "tango", "PyTango")
    ),
    "p4p": partial(_beside, f"{_GET}, beside p4p", ("p4p",), partial(_gets, "p4p", "p4p")),
}
