"""Measures one small system in one manager, over two of a host, and over two linked hosts.

Three senders and three receivers, in two processes; spread, each process has a manager of its own.
"""

from __future__ import annotations

import os
import re
import statistics
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from bench import far
from bench.harness import Lines, Missing, Row, command, manager, process, timed
from bench.pairs import alone, medians, paired
from rtkit.tree.connect import connect

_COUNT = 3
_LAUNCHES, _LISTINGS, _SETS, _TRIPS, _REQUESTS = 5, 9, 3, 200, 200
_COMPONENTS = Path(__file__).parent / "components"
_MOST = 1.3
"""How much more a spread system may cost."""
_ONE = "localhost"
_ONE_IS = "the same in one manager"
_WAITING = (
    "dataport.subscription_type=flush",
    "dataport.buffer.read.empty_policy=block",
    "dataport.buffer.read.timeout=1",
)


class _System(NamedTuple):
    """The system with its receivers below a folder of the tree.

    Attributes:
        base: Folder of files.
        folder: Of the receivers: ``localhost``, ``localhost/other.mgr``, ``b0``.
    """

    base: str
    folder: str

    @property
    def profile(self) -> str:
        """The file of the system."""
        return f"{self.base}/{self.folder.replace('/', '-')}.xml"

    def write(self) -> None:
        """Write the file."""
        import rts_text  # type: ignore[import-not-found]

        kinds = (("ConsoleIn", "out", _ONE, "a"), ("ConsoleOut", "in", self.folder, "b"))
        types = [f"RTC:rtkit:example:{kind}:1.0" for kind, *_ in kinds]
        parts = [
            rts_text.component(
                f"{kind}{number}",
                {"create": f"{kind}?manager_name={process}"},
                type_id=type_id,
                port=port,
                folder=folder,
                rate=10.0,
            )
            for (kind, port, folder, process), type_id in zip(kinds, types, strict=True)
            for number in range(_COUNT)
        ]
        parts += [
            rts_text.wire(f"w{number}", f"ConsoleIn{number}.out", f"ConsoleOut{number}.in", types)
            for number in range(_COUNT)
        ]
        Path(self.profile).write_text(rts_text.system("Spread", *parts), encoding="utf-8")

    def launch_ms(self) -> float:
        """Return how long the system takes from nothing [ms]."""
        elapsed_ms = process([command("rtapply"), self.profile])
        process([command("rtteardown"), "--exit", self.profile])
        return elapsed_ms

    def trip_us(self) -> float:
        """Return how long a value takes there and back, between fresh processes [us]."""
        there = f"/{self.folder}" + "/manager.mgr" * ("/" not in self.folder)
        result = f"{self.base}/median"
        values = f"conf.default.result={result}&conf.default.count={_TRIPS}"
        ping, echo = f"/{_ONE}/manager.mgr/P.rtc", f"{there}/E.rtc"
        policy = [word for each in _WAITING for word in ("-p", each)]
        for line in (
            ["rtmgr", f"/{_ONE}/manager.mgr", "-c",
             f"Ping?instance_name=P&manager_name=p&{values}"],
            ["rtmgr", there, "-c", "Echo?instance_name=E&manager_name=e"],
            ["rtcon", *policy, f"{ping}:out", f"{echo}:into"],
            ["rtcon", *policy, f"{echo}:out", f"{ping}:back"],
            ["rtact", echo],
            ["rtact", ping],
            ["rtexit", echo],  # first: without a connector it would read the last value for ever
            ["rtexit", ping],
        ):  # fmt: skip
            _run(*line)
        return float(Path(result).read_text(encoding="utf-8"))

    @contextmanager
    def up(self) -> Iterator[None]:
        """Have the system run."""
        _run("rtapply", self.profile)
        yield
        _run("rtteardown", "--exit", self.profile)


def _run(name: str, *words: str) -> None:
    process([command(name), *words])


def _managers() -> Lines:
    with manager(str(_COMPONENTS)), tempfile.TemporaryDirectory(prefix="rtb") as base:
        _run("rtmgr", "start", "other", "--no-door")
        try:
            yield from _beside("two managers of a host", base, f"{_ONE}/other.mgr")
        finally:
            _run("rtmgr", "stop", "other")


def _hosts() -> Lines:
    if why := far.missing():
        yield Missing("a system over two linked hosts", why)
        return
    with far.hosts(1) as found, tempfile.TemporaryDirectory(prefix="rtb") as base:
        os.environ["RTKIT_MODULE_PATH"] = str(_COMPONENTS)
        found[0].write("/root/Echo.py", (_COMPONENTS / "Echo.py").read_text(encoding="utf-8"))
        with far.linked(found):
            with connect("b0/") as there, connect("manager") as here:
                ratios = paired(lambda: _request_us(there), lambda: _request_us(here), _LISTINGS)
            what = "a link: a request to the manager there, and back"
            yield Row(what, "us", ratios, None, True, "the same to the manager here")
            more_us = ratios.figure - ratios.floor
            yield from _beside("two linked hosts", base, "b0", *found, link_us=more_us)


def _beside(where: str, base: str, folder: str, *hosts: Any, link_us: float = 0.0) -> Lines:
    """Measure the system with its receivers in a folder beside the one that is all here.

    A way there and back takes so much longer by the link alone [us].
    """
    one, spread = _System(base, _ONE), _System(base, folder)
    for system in (one, spread):
        system.write()
    what = f"{_COUNT} senders and {_COUNT} receivers over {where}"
    launches = paired(spread.launch_ms, one.launch_ms, _LAUNCHES)
    yield Row(f"{what}: rtapply, whole process", "ms", launches, _MOST, True, _ONE_IS)
    (listing, mib), (one_listing, one_mib) = (_at_work(each, hosts) for each in (spread, one))
    what_listed = f"{what}: rtls -lR /, whole process"
    yield Row(what_listed, "ms", alone(listing, one_listing), _MOST, True, _ONE_IS)
    what_held = f"{what}: memory that it takes in all processes (PSS)"
    yield Row(what_held, "MiB", alone(mib, one_mib), _MOST, True, _ONE_IS)
    trips = medians([(spread.trip_us(), one.trip_us() + link_us) for _ in range(_SETS)])
    what = f"round trip of a TimedPose2D over {where}"
    floor_is = f"{_ONE_IS}, and what the link adds to a request" if link_us else _ONE_IS
    yield Row(what, "us", trips, _MOST, True, floor_is)


def _at_work(system: _System, hosts: Sequence[Any]) -> tuple[float, float]:
    """Return how long a listing takes while a system is up [ms], and what that takes [MiB]."""
    line = [command("rtls"), "-lR", "/"]
    idle = _all_mib(hosts)
    with system.up():
        process(line)
        return statistics.median(process(line) for _ in range(_LISTINGS)), _all_mib(hosts) - idle


def _request_us(tree: Any) -> float:
    """Return how long a request to a manager takes [us]."""
    return timed(lambda: [tree.get("manager.pid") for _ in range(_REQUESTS)]) / _REQUESTS * 1e3


def _all_mib(hosts: Sequence[Any]) -> float:
    """Return what all processes have in memory that serve here, and all of other hosts [MiB]."""
    mark = f"RTKIT_RUNTIME_DIR={os.environ['RTKIT_RUNTIME_DIR']}".encode()
    found = ""
    for entry in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # it has ended
            if mark in (entry / "environ").read_bytes().split(b"\0"):
                found += (entry / "smaps_rollup").read_text(encoding="ascii")
    for host in hosts:
        found += host.run("sh", "-c", "cat /proc/[0-9]*/smaps_rollup || true")
    return sum(map(int, re.findall(r"^Pss: +(\d+) kB", found, re.MULTILINE))) / 1024


PARTS = {"managers": _managers, "hosts": _hosts}
