"""Is a process of another system: run by the Python that has it, with nothing of rtkit.

``speak PLACE`` and ``dora-speak PLACE`` tell that they live and rest.
``tango|p4p serve|ask PORT`` serves a property, or reads a number of GETs a line and answers with
the time of one [us]. ``dora ping|echo PLACE SIZE``
are nodes: the first takes a number of round trips and answers with the median of one [us].
"""

from __future__ import annotations

import os
import signal
import socket
import sys
from collections.abc import Callable
from typing import Any


def _tell(place: str, text: str) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as end:
        end.sendto(text.encode(), f"{place}/up")


def _speak(place: str) -> None:
    _tell(place, "here")
    signal.pause()


def _speak_in_dora(place: str) -> None:
    from dora import Node  # type: ignore[import-not-found, unused-ignore]

    node = Node()
    _tell(place, "here")
    for event in node:
        if event["type"] == "STOP":
            return


def _answer(get: Callable[[], object]) -> None:
    import time

    get()
    print("ready", flush=True)
    for line in sys.stdin:
        count = int(line)
        begin = time.perf_counter()
        for _ in range(count):
            get()
        print((time.perf_counter() - begin) / count * 1e6, flush=True)


def _tango(role: str, port: str) -> None:
    import tango  # type: ignore[import-not-found, unused-ignore]

    if role == "ask":
        device = tango.DeviceProxy(f"tango://127.0.0.1:{port}/bench/peers/1#dbase=no")
        _answer(lambda: device.read_attribute("p7").value)
        return
    from tango.server import Device, attribute, run  # type: ignore[import-not-found, unused-ignore]

    class Numbers(Device):  # type: ignore[misc, unused-ignore]
        """A device with a number."""

        @attribute  # type: ignore[untyped-decorator, unused-ignore]
        def p7(self) -> float:
            """Return it."""
            return 2.5

    words = ["Numbers", "bench", "-nodb", "-dlist", "bench/peers/1"]
    run([Numbers], args=[*words, "-ORBendPoint", f"giop:tcp:127.0.0.1:{port}"])


def _p4p(role: str, port: str) -> None:
    if role == "ask":
        from p4p.client.thread import Context  # type: ignore[import-not-found, unused-ignore]

        found = {"EPICS_PVA_NAME_SERVERS": f"127.0.0.1:{port}", "EPICS_PVA_AUTO_ADDR_LIST": "NO"}
        with Context("pva", conf=found, useenv=False) as context:
            _answer(lambda: float(context.get("bench:p7")))
        return
    from p4p.nt import NTScalar  # type: ignore[import-not-found, unused-ignore]
    from p4p.server import Server  # type: ignore[import-not-found, unused-ignore]
    from p4p.server.thread import SharedPV  # type: ignore[import-not-found, unused-ignore]

    value = SharedPV(nt=NTScalar("d"), initial=2.5)
    here = {
        "EPICS_PVAS_INTF_ADDR_LIST": "127.0.0.1",
        "EPICS_PVAS_SERVER_PORT": port,
        "EPICS_PVAS_AUTO_BEACON_ADDR_LIST": "NO",
    }
    with Server(providers=[{"bench:p7": value}], conf=here, useenv=False):
        print("ready", flush=True)
        sys.stdin.read()


def _dora(role: str, place: str, size: str) -> None:
    import statistics
    import time

    import numpy as np
    import pyarrow as pa  # type: ignore[import-not-found, import-untyped, unused-ignore]
    from dora import Node  # type: ignore[import-not-found, unused-ignore]

    node = Node()

    def receive() -> Any:
        for event in node:
            if event["type"] == "INPUT":
                return event["value"]
        return None

    if role == "echo":
        _tell(place, f"echo {os.getpid()}")
        while (came := receive()) is not None:
            node.send_output("back", came)
        return
    sent = np.frombuffer(os.urandom(int(size)), np.uint8)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as asked:
        asked.bind(f"{place}/ask")
        _tell(place, f"ping {os.getpid()}")
        while count := int(asked.recv(64)):
            taken = []
            for _ in range(count):
                begin = time.perf_counter()
                node.send_output("there", pa.array(sent))
                came = receive()
                last = came.to_numpy()[-1]
                taken.append(time.perf_counter() - begin)
                if last != sent[-1]:
                    raise ValueError("another value came back")
            _tell(place, str(statistics.median(taken) * 1e6))


if __name__ == "__main__":
    ends: dict[str, Callable[..., None]] = {
        "speak": _speak,
        "dora-speak": _speak_in_dora,
        "dora": _dora,
        "tango": _tango,
        "p4p": _p4p,
    }
    ends[sys.argv[1]](*sys.argv[2:])
