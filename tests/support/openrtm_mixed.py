"""Two components that do the same: one written for OpenRTM-aist, one native, of the same types.

Each passes on what comes in at `NAME_in` to `NAME_out`, provides a store, and uses the one that it
is connected with when it is activated: it prints what that answers.
"""

from __future__ import annotations

from pathlib import Path

from openrtm_files import write_component

IDL = """
module Cell {
  enum Mode { IDLE, DRIVE };
  typedef sequence<long> Slots;
  struct Part { string name; double weight; Mode mode; Slots free; };
  exception Missing { string name; long tries; };
  interface Store {
    void put(in Part item);
    double weigh(in string name, out Mode kind) raises (Missing);
    long count();
  };
};
"""
TYPES = {
    "long": "TimedLong",
    "doubles": "TimedDoubleSeq",
    "text": "TimedString",
    "wide": "TimedWString",
    "octets": "TimedOctetSeq",
    "chars": "TimedCharSeq",
    "flags": "TimedBooleanSeq",
    "pose": "TimedPose2D",
    "speed": "TimedVelocity2D",
    "image": "CameraImage",
    "part": "Part",
}
"""Data type of each pair of ports; the last one is of the IDL file."""
_STORE = """
class Store_i(Cell__POA.Store):
    def __init__(self):
        self.items = []

    def put(self, item):
        self.items.append(item)

    def count(self):
        return len(self.items)

    def weigh(self, name):
        for each in self.items:
            if each.name == name:
                return each.weight, each.mode
        raise Cell.Missing(name, 3)

"""
_OLD = """
def __init__(self, manager):
    OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
    self.gain = [2]
    self.pairs = []
    for name, kind in ({kinds}):
        into = OpenRTM_aist.InPort(name + "_in", OpenRTM_aist.instantiateDataType(kind))
        out = OpenRTM_aist.OutPort(name + "_out", OpenRTM_aist.instantiateDataType(kind))
        self.pairs.append((name, into, out))
    self.provided = OpenRTM_aist.CorbaPort("provided")
    self.needed = OpenRTM_aist.CorbaPort("needed")
    self.store = Store_i()
    self.consumer = OpenRTM_aist.CorbaConsumer(interfaceType=Cell.Store)

def onInitialize(self):
    for name, into, out in self.pairs:
        self.addInPort(name + "_in", into)
        self.addOutPort(name + "_out", out)
    self.provided.registerProvider("store", "Cell::Store", self.store)
    self.needed.registerConsumer("store", "Cell::Store", self.consumer)
    self.addPort(self.provided)
    self.addPort(self.needed)
    self.bindParameter("gain", self.gain, "2")
    return RTC.RTC_OK

def onActivated(self, ec_id):
    store = self.consumer._ptr()
    if store is not None:
        store.put(Cell.Part("cup", 0.25, Cell.DRIVE, [1, 2]))
        weight, mode = store.weigh("cup")
        print("weighed", weight, "in", mode, "of", store.count(), flush=True)
        try:
            store.weigh("hat")
        except Cell.Missing as error:
            print("missing", error.name, error.tries, flush=True)
    return RTC.RTC_OK

def onExecute(self, ec_id):
    for name, into, out in self.pairs:
        while into.isNew():
            out.write(into.read())
    return RTC.RTC_OK
"""
_NEW = '''
import rtkit.component as rt
from Cell_idl import Missing, Mode, Part, Store


class New(rt.Component):
    """A test."""

    vendor = "me"
    category = "example"
    version = "1.2"

{ports}
    provided = rt.ServicePort.provided(Store, "store", type_name="Cell::Store")
    needed = rt.ServicePort.required(Store, "store", type_name="Cell::Store")
    gain = rt.Parameter(2)

    def on_initialize(self):
        self.items = []

    def put(self, item):
        self.items.append(item)

    def count(self):
        return len(self.items)

    def weigh(self, name):
        for each in self.items:
            if each.name == name:
                return each.weight, each.mode
        raise Missing(name, 3)

    def on_activated(self, context):
        if self.needed.is_connected:
            store = self.needed.client
            store.put(Part("cup", 0.25, Mode.DRIVE, (1, 2)))
            weight, mode = store.weigh("cup")
            print("weighed", weight, "in", mode.name, "of", store.count(), flush=True)
            try:
                store.weigh("hat")
            except Missing as error:
                print("missing", error.name, error.tries, flush=True)

    def on_execute(self, context):
        for name in {names}:
            for value in self.ports[name + "_in"].read_all():
                self.ports[name + "_out"].write(value)


def NewInit(manager):
    manager.register_factory(New)
'''


def write_both(folder: Path) -> tuple[Path, Path]:
    """Write both components and the IDL file; return the file of the old one and the native one.

    The native one needs the types file that ``rtbuild Cell.idl -o .`` makes.
    """
    (folder / "Cell.idl").write_text(IDL)
    kinds = ", ".join(
        f'("{name}", {"Cell" if kind == "Part" else "RTC"}.{kind})' for name, kind in TYPES.items()
    )
    before = f"import Cell_idl\nimport Cell, Cell__POA\n{_STORE}"
    old = write_component(
        folder, "Old", _OLD.format(kinds=kinds), '"conf.default.gain", "2",', before
    )
    ports = "".join(
        f"    {name}_{end} = rt.{port}({_native(kind)})\n"
        for name, kind in TYPES.items()
        for end, port in (("in", "InPort"), ("out", "OutPort"))
    )
    new = folder / "New.py"
    new.write_text(_NEW.format(ports=ports, names=tuple(TYPES)))
    return old, new


def _native(kind: str) -> str:
    return kind if kind == "Part" else f"rt.{kind}"
