# mypy: ignore-errors
"""Asking end of the round trip of `Ping`, as for OpenRTM-aist-Python."""

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


def OrtmPingInit(manager):
    profile = OpenRTM_aist.Properties(defaults_str=PING_SPEC)
    manager.registerFactory(profile, OrtmPing, OpenRTM_aist.Delete)
