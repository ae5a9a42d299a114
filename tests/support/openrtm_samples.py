"""Components and scripts in the manner of the samples that OpenRTM-aist-Python is shipped with."""

from __future__ import annotations

from pathlib import Path

from openrtm_files import write_component

MAIN = """

def MyModuleInit(manager):
    {name}Init(manager)
    manager.createComponent("{name}")


if __name__ == "__main__":
    import sys
    manager = OpenRTM_aist.Manager.init(sys.argv)
    manager.setModuleInitProc(MyModuleInit)
    manager.activateManager()
    manager.runManager()
"""
_IN = """
def __init__(self, manager):
    OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)

def onInitialize(self):
    self._data = RTC.TimedLong(RTC.Time(0, 0), 0)
    self._port = OpenRTM_aist.OutPort("out", self._data)
    self.addOutPort("out", self._port)
    return RTC.RTC_OK

def onExecute(self, ec_id):
    print("Please input number: ", end="", flush=True)
    self._data.data = int(input())
    if self._data.data < 0:
        return self.exit()
    OpenRTM_aist.setTimestamp(self._data)
    self._port.write()
    print("Sent", self._data.data, flush=True)
    return RTC.RTC_OK
"""
_OUT = """
def __init__(self, manager):
    OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)

def onInitialize(self):
    self._port = OpenRTM_aist.InPort("in", RTC.TimedLong(RTC.Time(0, 0), 0))
    self.addInPort("in", self._port)
    return RTC.RTC_OK

def onExecute(self, ec_id):
    if self._port.isNew():
        print("Received:", self._port.read().data, flush=True)
    return RTC.RTC_OK
"""
CONNECTOR = """
import sys
import time

from omniORB import CORBA

import OpenRTM_aist
import RTC

NV = OpenRTM_aist.NVUtil.newNV


def found(naming, name):
    consumer = OpenRTM_aist.CorbaConsumer()
    for _ in range(100):
        try:
            consumer.setObject(naming.resolve(name))
            return consumer.getObject()._narrow(RTC.RTObject)
        except CORBA.Exception:
            time.sleep(0.1)


naming = OpenRTM_aist.CorbaNaming(CORBA.ORB_init(sys.argv), "localhost")
source, sink = found(naming, "In0.rtc"), found(naming, "Out0.rtc")
(out,), (into,) = source.get_ports(), sink.get_ports()
out.disconnect_all()
profile = RTC.ConnectorProfile("connector0", "", [into, out], [])
for name, text in (("interface_type", "corba_cdr"), ("dataflow_type", "push"),
                   ("subscription_type", "Flush")):
    OpenRTM_aist.CORBA_SeqUtil.push_back(profile.properties, NV("dataport." + name, text))
code, made = out.connect(profile)
print(code, [each.name for each in out.get_connector_profiles()], flush=True)
contexts = [each.get_owned_contexts()[0] for each in (source, sink)]
for context, component in zip(contexts, (source, sink)):
    print(context.get_component_state(component), context.activate_component(component),
          context.get_component_state(component), context.get_kind(), flush=True)
"""
"""A script that connects the two and activates them, as ``Connector.py`` of SimpleIO."""
TICKER = (
    CONNECTOR
    + """
from OpenRTM import ExtTrigExecutionContextService

clocks = []
for context in contexts:
    clocks.append(OpenRTM_aist.CorbaConsumer(interfaceType=ExtTrigExecutionContextService))
    clocks[-1].setObject(context)
for line in sys.stdin:
    print(clocks[int(line)]._ptr().tick(), flush=True)
"""
)
"""The same, which then ticks one of them for each number that it reads."""


def write_pair(folder: Path) -> tuple[Path, Path]:
    """Write a component that reads numbers, and one that prints them, both also scripts."""
    pair = []
    for name, body in (("In", _IN), ("Out", _OUT)):
        file = write_component(folder, name, body)
        file.write_text(file.read_text() + MAIN.format(name=name))
        pair.append(file)
    return pair[0], pair[1]
