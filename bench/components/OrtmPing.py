# mypy: ignore-errors
"""Both ends of the round trip of `Ping` and `Echo`, as for OpenRTM-aist-Python."""

import statistics
import time

import OpenRTM_aist
import RTC

PING_SPEC = [
    "implementation_id",
    "OrtmPing",
    "type_name",
    "OrtmPing",
    "description",
    "Measures round trips",
    "version",
    "1.0",
    "vendor",
    "rtkit",
    "category",
    "bench",
    "language",
    "Python",
    "lang_type",
    "SCRIPT",
    "exec_cxt.periodic.rate",
    "1.0",
    "conf.default.count",
    "500",
    "conf.default.result",
    "",
    "",
]
ECHO_SPEC = [
    "implementation_id",
    "OrtmEcho",
    "type_name",
    "OrtmEcho",
    "description",
    "Sends back what comes",
    "version",
    "1.0",
    "vendor",
    "rtkit",
    "category",
    "bench",
    "language",
    "Python",
    "lang_type",
    "SCRIPT",
    "",
]


def pose():
    return RTC.TimedPose2D(RTC.Time(0, 0), RTC.Pose2D(RTC.Point2D(0.0, 0.0), 0.0))


class OrtmPing(OpenRTM_aist.DataFlowComponentBase):
    """Send a pose, wait until it is back, and again; write how long that takes to a file."""

    def __init__(self, manager):
        OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
        self._d_out = pose()
        self._outOut = OpenRTM_aist.OutPort("out", self._d_out)
        self._backIn = OpenRTM_aist.InPort("back", pose())
        self._count = [500]
        self._result = ["-"]

    def onInitialize(self):
        self.addOutPort("out", self._outOut)
        self.addInPort("back", self._backIn)
        self.bindParameter("count", self._count, "500")
        self.bindParameter("result", self._result, "-")
        return RTC.RTC_OK

    def onActivated(self, ec_id):
        self.trips(50)
        median_s = statistics.median(self.trips(self._count[0]))
        with open(self._result[0], "w") as file:
            file.write(str(median_s * 1e6))
        return RTC.RTC_OK

    def trips(self, count):
        taken = []
        for number in range(count):
            begin = time.perf_counter()
            self._d_out.data.heading = float(number)
            self._outOut.write()
            came = self._backIn.read()
            taken.append(time.perf_counter() - begin)
            if came.data.heading != number:
                raise RuntimeError("it did not come back")
        return taken


class OrtmEcho(OpenRTM_aist.DataFlowComponentBase):
    """Send back what arrives, at once."""

    def __init__(self, manager):
        OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
        self._intoIn = OpenRTM_aist.InPort("into", pose())
        self._outOut = OpenRTM_aist.OutPort("out", pose())
        self._last = None

    def onInitialize(self):
        self.addInPort("into", self._intoIn)
        self.addOutPort("out", self._outOut)
        return RTC.RTC_OK

    def onExecute(self, ec_id):
        while True:
            value = self._intoIn.read()
            if value is self._last:  # none came in time
                return RTC.RTC_OK
            self._last = value
            self._outOut.write(value)


def OrtmPingInit(manager):
    for spec, kind in ((PING_SPEC, OrtmPing), (ECHO_SPEC, OrtmEcho)):
        profile = OpenRTM_aist.Properties(defaults_str=spec)
        manager.registerFactory(profile, kind, OpenRTM_aist.Delete)
