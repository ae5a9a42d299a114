# mypy: ignore-errors
"""Answering end of the round trip of `Echo`, as for OpenRTM-aist-Python."""

import OpenRTM_aist
import RTC

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


def OrtmEchoInit(manager):
    profile = OpenRTM_aist.Properties(defaults_str=ECHO_SPEC)
    manager.registerFactory(profile, OrtmEcho, OpenRTM_aist.Delete)
