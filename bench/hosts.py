"""Measures other hosts: bring-up from bare ones, of ten at once, and commands over the kept link.

The hosts are network namespaces of this machine, so the network costs next to nothing, and ten of
them share its processors: what waits is told apart from processor time.
"""

from __future__ import annotations

import os
import re
import socket
import statistics
import subprocess
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Any

from bench import far
from bench.harness import Lines, Missing, Row, command, process, timed
from bench.pairs import alone, medians, paired, pairs_of
from bench.processes import own_group
from rtkit.hosts import inventory, wheels
from rtkit.hosts.connection import connect
from rtkit.hosts.far_side import look
from rtkit.hosts.host import Host

_TEN = 10
_ROUNDS, _BARE_ROUNDS = 9, 3
_SILENT_S = 2
_LOCAL_IS = "the same of the manager here"
_BYTES_IS = "the same wheels sent by ssh and cat"
_MANAGERS_IS = "ten managers of this host, started at once by rtmgr start"


def _known() -> Lines:
    with far.hosts(1) as found, far.linked(found):
        far_ls, near_ls = ([command("rtls"), path] for path in ("/b0", "/localhost"))
        what = "rtls of another host over the kept link, whole process"
        ratios = paired(lambda: process(far_ls), lambda: process(near_ls))
        yield Row(what, "ms", ratios, 1.5, True, _LOCAL_IS)
        what = f"{_TEN} components on another host, one rtmgr, whole process"
        ratios = paired(lambda: _made("b0"), lambda: _made("localhost"), _ROUNDS)
        yield Row(what, "ms", ratios, 1.3, True, _LOCAL_IS)


def _made(host: str) -> float:
    names = [f"N{index}" for index in range(_TEN)]
    path = f"/{host}/manager.mgr"
    texts = [word for name in names for word in ("-c", f"ConsoleIn?instance_name={name}")]
    elapsed_ms = process([command("rtmgr"), path, *texts])
    process([command("rtmgr"), path, *(word for name in names for word in ("-d", name))])
    return elapsed_ms


def _bare() -> Lines:
    with far.hosts(1) as found:
        (host,) = found
        login = far.login(host)
        with connect(inventory.host("b0")) as connection:
            files = wheels.wheels_for(look(connection).kind).files
        size = sum(map(os.path.getsize, files.values()))
        sent: list[float] = []

        def bring_up() -> float:
            login.script("pkill rtkit || true; rm -rf .local")
            with ExitStack() as stack:
                process([command("rtmgr"), "start", "--no-door"])
                stack.callback(process, [command("rtmgr"), "stop"])
                elapsed_ms = timed(lambda: sent.append(_sent(far.line("start", found))))
                process(far.line("stop", found))
            return elapsed_ms / 1e3

        def copy() -> float:
            words = [*login.line, "cat > wheels"]
            with subprocess.Popen(["cat", *files.values()], stdout=subprocess.PIPE) as source:
                ms = timed(lambda: subprocess.run(words, stdin=source.stdout, check=True))
            return ms / 1e3

        pairs = [(bring_up(), copy()) for _ in range(_BARE_ROUNDS)]
        what = "a bare host: rtkit made there, its manager started and linked"
        yield Row(what, "s", medians(pairs), None, False, _BYTES_IS)
        mb = statistics.median(sent)
        what = "a bare host: bytes sent"
        yield Row(what, "MB", alone(mb, size / 1e6), None, False, "the wheels")


def _sent(words: Sequence[str]) -> float:
    """Run a command; return how much it has sent [MB]."""
    told = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True).stdout
    return float(re.findall(r"([0-9.]+) MB sent", told)[0])


def _ten() -> Lines:
    with (
        own_group("there") as there_s,
        far.hosts(_TEN) as found,
        own_group("here") as here_s,
        far.linked(found),
    ):
        process(far.line("stop", found))
        used: dict[str, list[float]] = {"hosts": [], "of it here": [], "managers": []}

        def at_hosts() -> float:
            there, here = there_s(), here_s()
            elapsed_ms = process(far.line("start", found))
            there, here = there_s() - there, here_s() - here
            used["hosts"].append(there + here)
            used["of it here"].append(here)
            process(far.line("stop", found))
            return elapsed_ms / 1e3

        def here() -> float:
            before = here_s()
            elapsed_ms = timed(lambda: _each("start", "--no-door"))
            used["managers"].append(here_s() - before)
            _each("stop")
            return elapsed_ms / 1e3

        pairs = pairs_of(at_hosts, here, _BARE_ROUNDS)
        what = f"managers of {_TEN} known hosts, started and linked by one command"
        yield Row(what, "s", medians(pairs), 1.3, True, _MANAGERS_IS)
        for where, name in (("hosts", "processor time"), ("of it here", "processor time here")):
            spent = list(zip(used[where], used["managers"], strict=True))[-len(pairs) :]
            target = 1.3 if where == "of it here" else None
            yield Row(f"{what}: {name}", "s", medians(spent), target, True, _MANAGERS_IS)
        process(far.line("start", found))


def _each(word: str, *options: str) -> None:
    names = [f"m{index}" for index in range(_TEN)]
    words = [command("rtmgr"), word]
    running = [subprocess.Popen([*words, name, *options]) for name in names]
    statuses = [each.wait() for each in running]
    if any(statuses):
        raise RuntimeError(f"rtmgr {word} of {_TEN} managers failed")


def _silent() -> Lines:
    with far.hosts(1), ExitStack() as stack:
        for index in range(_TEN):
            listener = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
            inventory.add(Host(f"s{index}", "127.0.0.1", "root", listener.getsockname()[1]))
        words = [command("rthost"), "check", "--timeout", str(_SILENT_S)]
        all = [*words, *(f"s{index}" for index in range(_TEN))]
        ratios = paired(lambda: _fails(all), lambda: _fails([*words, "s0"]), _BARE_ROUNDS)
        what = f"{_TEN} hosts that do not answer within {_SILENT_S} s, told by one rthost check"
        yield Row(what, "s", ratios, 1.3, True, "the same of one such host")


def _fails(words: list[str]) -> float:
    return timed(lambda: subprocess.run(words, stderr=subprocess.DEVNULL, check=False)) / 1e3


def _if_possible(part: Callable[[], Lines], what: str) -> Callable[[], Lines]:
    def measured() -> Lines:
        if why := far.missing():
            yield Missing(what, why)
        else:
            yield from part()

    return measured


_PARTS: dict[str, Any] = {"known": _known, "bare": _bare, "ten": _ten, "silent": _silent}
PARTS = {name: _if_possible(part, f"other hosts: {name}") for name, part in _PARTS.items()}
