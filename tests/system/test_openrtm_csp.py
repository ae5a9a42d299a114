"""Ports of CSP of components written for OpenRTM-aist, live: in one process and between two."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import pytest
from openrtm_files import write_component
from waiting import told_pid, until

PLACE = "/localhost/manager.mgr"
CHANNEL = "-p dataport.interface_type=csp_channel -p dataport.dataflow_type=duplex"
SOURCE = """
def onInitialize(self):
    self._data = RTC.TimedLong(RTC.Time(0, 0), 0)
    self._port = OpenRTM_aist.CSPOutPort("out", self._data)
    self.addOutPort("out", self._port)
    return RTC.RTC_OK

def onExecute(self, ec_id):
    self._data.data += 1
    print("wrote" if self._port.write() else "failed", self._data.data, flush=True)
    return RTC.RTC_OK
"""
SINK = """
def onInitialize(self):
    self._manager = OpenRTM_aist.CSPManager()
    self._ports = []
    for name in ("one", "two"):
        data = RTC.TimedLong(RTC.Time(0, 0), 0)
        self._ports.append(OpenRTM_aist.CSPInPort(name, data, self._manager))
        self.addInPort(name, self._ports[-1])
    self._count = 0
    return RTC.RTC_OK

def onExecute(self, ec_id):
    if self._count < 5:
        is_there, _, port = self._manager.select(1000)
        if is_there:
            self._count += 1
            print("read", port.name(), port.readData().data, flush=True)
    return RTC.RTC_OK
"""


def told(shell: Any, component: str, word: str) -> list[str]:
    logged = shell.ok(f"rtvlog --no-follow -n 1000 -g {word} /localhost/{component}.rtc")
    return [line.split("> ", 1)[1] for line in logged.splitlines()]


@pytest.mark.parametrize("place", ["", "&manager_name=other"], ids=["one process", "two"])
def test_a_writer_goes_no_faster_than_its_reader(manager: Any, tmp_path: Path, place: str) -> None:
    source, sink = (
        write_component(tmp_path, name, body) for name, body in (("Src", SOURCE), ("Snk", SINK))
    )
    manager.ok(f"rtmgr -l {source}:SrcInit -c 'Src?port.outport.out.channel_timeout=1000' {PLACE}")
    unbuffered = "port.inport.two.buffer.length=0"
    manager.ok(f"rtmgr -l {sink}:SnkInit -c 'Snk?{unbuffered}{place}' {PLACE}")
    manager.ok(f"rtcon {CHANNEL} /localhost/Src0.rtc:out /localhost/Snk0.rtc:two")
    manager.ok("rtact /localhost/Src0.rtc /localhost/Snk0.rtc")
    read = until(lambda: (lines := told(manager, "Snk0", "read"))[4:] and lines, "five are read")
    assert read == [f"read two {each}" for each in range(1, 6)]
    wrote = until(lambda: (lines := told(manager, "Src0", "wrote"))[4:] and lines, "all are told")
    assert wrote == [f"wrote {each}" for each in range(1, 6)]  # the sixth one waits
    # A write, or a choice, that waits for minutes ends when its component is deactivated.
    manager.ok("rtdeact /localhost/Src0.rtc /localhost/Snk0.rtc")
    states = manager.ok("rtls -l /localhost")
    assert states.count("Inactive") == 2
    manager.ok("rtact /localhost/Src0.rtc")
    if place:  # and one whose reader is killed goes on, as nobody is connected
        os.kill(told_pid(manager, "other"), signal.SIGKILL)
        until(lambda: told(manager, "Src0", "failed"), "the writer has gone on")
