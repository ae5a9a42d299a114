"""Measures a hundred managers as a hundred linked hosts, and routers as trees and meshes.

The hosts are on one machine, without SSH: each manager has a name, sockets and logs of its own, and
the router of a link joins it to the manager that links all, under the rules of links.
"""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress

from bench.harness import Lines, Missing, Row, command, create, folders, process, until_listed
from bench.pairs import alone
from bench.processes import processor_s, pss_mib
from rtkit.errors import Unreachable
from rtkit.hosts.link_process import rules
from rtkit.link import host_links, places
from rtkit.link.host_links import HostLink
from rtkit.link.zenoh import ask_router_id, await_answerer, open_between, open_listener
from rtkit.link.zenoh import unix_endpoint as endpoint
from rtkit.link.zenoh_keys import property_key
from rtkit.link.zenoh_keys import service as key_of
from rtkit.tree import managers
from rtkit.tree.connect import connect

COUNT = 100
COMPONENTS = 100
"""Of each manager, in its own process."""

_AT_ONCE = 10
_PATIENCE_S = 60.0
_LEASE_MS = 2500
_ROUNDS = 5
_SETTLE_S, _WINDOW_S = 2.0, 10.0
_SILENT = 3
"""How many managers are stopped."""
_MESHES = (10, 20, 30, 40)
_BRANCHES = 10
_NAMES = [f"h{index}" for index in range(COUNT)]


def _linked() -> Lines:
    with folders() as folder, ExitStack() as stack:
        stack.callback(_stop_all, folder)
        _start_all(folder)
        pids = {name: _fill(folder, name) for name in ("near", *_NAMES)}
        began = _of(os.getpid())
        with _place(folder, "near"):
            for name in _NAMES:
                stack.callback(_link(folder, name))
            yield _row("router of a link, one of 100: memory (PSS)", "MiB",
                       (_of(os.getpid())[0] - began[0]) / COUNT)  # fmt: skip
            time.sleep(_SETTLE_S)
            yield _row("100 idle links: processor, their routers", "% of a core",
                       _load_percent([os.getpid()]))  # fmt: skip
            yield _row("100 idle links: processor, the manager that links all", "% of a core",
                       _load_percent([pids["near"]]))  # fmt: skip
            what = f"rtls -R / of {COUNT * COMPONENTS:,} components of {COUNT} linked hosts"
            yield _row(what, "ms", _listing_ms(), 5000.0)
            for name in _NAMES[:_SILENT]:
                os.kill(pids[name], signal.SIGSTOP)
            try:
                what = f"{what}, {_SILENT} of which do not answer and are named"
                yield _row(what, "ms", _named_ms(_NAMES[:_SILENT]), 5000.0)
            finally:
                for name in _NAMES[:_SILENT]:
                    os.kill(pids[name], signal.SIGCONT)


def _row(what: str, unit: str, figure: float, target: float | None = None) -> Row:
    return Row(what, unit, alone(figure, 0.0), target, False, "nothing: the figure stands alone")


def _of(pid: int) -> tuple[float, float]:
    return pss_mib([pid]), processor_s([pid])


def _load_percent(pids: list[int]) -> float:
    before = processor_s(pids)
    time.sleep(_WINDOW_S)
    return (processor_s(pids) - before) / _WINDOW_S * 100


def _listing_ms() -> float:
    everything = [command("rtls"), "-R", "/"]
    return sorted(process(everything) for _ in range(_ROUNDS))[_ROUNDS // 2]


def _named_ms(silent: list[str]) -> float:
    """Return how long a listing takes that names hosts which do not answer [ms]."""
    began = time.monotonic()
    done = subprocess.run([command("rtls"), "-R", "/"], capture_output=True, text=True, check=False)
    took_ms = (time.monotonic() - began) * 1e3
    if not all(f"/{name} was not listed" in done.stderr for name in silent):
        raise RuntimeError(f"rtls -R / does not name {' '.join(silent)}: {done.stderr}")
    return took_ms


def _own(folder: str, name: str) -> dict[str, str]:
    """Return the environment of what runs on a host."""
    runtime = f"{os.path.dirname(os.environ['RTKIT_RUNTIME_DIR'])}/{name}"
    own = {"RUNTIME_DIR": runtime, "STATE_DIR": f"{folder}/{name}", "HOSTNAME": name}
    return {f"RTKIT_{key}": value for key, value in own.items()}


@contextmanager
def _place(folder: str, name: str) -> Iterator[None]:
    """Be on a host."""
    mine = _own(folder, name)
    before = {key: os.environ.get(key) for key in mine}
    os.environ.update(mine)
    try:
        yield
    finally:
        for key, value in before.items():
            os.environ.pop(key) if value is None else os.environ.update({key: value})


def _start_all(folder: str) -> None:
    def start(name: str) -> None:
        line = [command("rtmgr"), "start", "--no-door", "--timeout", f"{_PATIENCE_S:g}"]
        subprocess.run(line, env=os.environ | _own(folder, name), check=True, capture_output=True)

    with ThreadPoolExecutor(_AT_ONCE) as pool:
        list(pool.map(start, ("near", *_NAMES)))


def _fill(folder: str, name: str) -> int:
    """Give a host its components, none to the near one; return the process of its manager."""
    with _place(folder, name), connect("manager", _PATIENCE_S) as tree:
        if name != "near":
            create(tree, [f"ConsoleIn?instance_name=N{each}" for each in range(COMPONENTS)])
            until_listed(tree, COMPONENTS)
        return int(tree.get("manager.pid"))


def _stop_all(folder: str) -> None:
    for name in ("near", *_NAMES):
        with _place(folder, name), suppress(Unreachable):
            managers.stop("manager", _PATIENCE_S)


def _link(folder: str, name: str) -> Callable[[], object]:
    """Join the router of a host to that of the near one; return what parts them."""
    near = endpoint(places.manager_socket("manager"))
    with _place(folder, name):
        far = endpoint(places.manager_socket("manager"))
    session = open_between((near, far), rules(ask_router_id(near), name), _LEASE_MS)
    await_answerer(near, property_key(key_of(name, "manager"), "manager.pid"), _PATIENCE_S)
    host_links.write(HostLink(name, "manager", "manager"))
    return session.close


def _routers() -> Lines:
    """Measure bare routers: none of rtkit but how it opens them."""
    with folders():
        os.makedirs(os.environ["RTKIT_RUNTIME_DIR"], mode=0o700)
        for count in (10, 40, COUNT):
            yield from _bare(f"tree of {count} routers, {_BRANCHES} below each", _tree(count))
        for count in _MESHES:
            yield from _bare(f"mesh of {count} routers", [list(range(at)) for at in range(count)])


def _tree(count: int) -> list[list[int]]:
    return [[(at - 1) // _BRANCHES] if at else [] for at in range(count)]


def _bare(what: str, ways: list[list[int]]) -> Lines:
    """Open routers, each joined to those before it; measure them."""
    import json

    folder = os.environ["RTKIT_RUNTIME_DIR"]
    ends = [endpoint(f"{folder}/{len(ways)}-{len(ways[-1])}-{at}") for at in range(len(ways))]
    links = sum(map(len, ways))
    before, began = _of(os.getpid())[0], time.monotonic()
    with ExitStack() as stack:
        sessions = []
        for end, to in zip(ends, ways, strict=True):
            more = {"connect/endpoints": json.dumps([ends[each] for each in to])}
            sessions.append(open_listener(end, more=more))
            stack.callback(sessions[-1].close)
        sessions[-1].declare_queryable("rt/x", lambda query: query.reply("rt/x", "y"))
        try:
            await_answerer(ends[0], "rt/x", _PATIENCE_S)
        except Unreachable:
            yield Missing(f"{what}, {links} links", f"not joined within {_PATIENCE_S:g} s")
            return
        yield _row(f"{what}: until all are joined", "ms", (time.monotonic() - began) * 1e3)
        yield _row(f"{what}: memory for each of {links} links", "MiB",
                   (_of(os.getpid())[0] - before) / links)  # fmt: skip
        yield _row(f"{what}: processor at rest, for each link", "% of a core",
                   _load_percent([os.getpid()]) / links)  # fmt: skip


PARTS = {"linked": _linked, "routers": _routers}
