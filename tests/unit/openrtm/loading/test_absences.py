"""Names of OpenRTM that a source uses and rtkit does not have."""

from __future__ import annotations

from rtkit.openrtm.loading.absences import AbsentUse, absences_in

SOURCE = b"""
import OpenRTM_aist, RTC
import omniORB as orb
from omniORB import CORBA, URI
from SDOPackage import DeviceProfile as Part

class Robot(OpenRTM_aist.DataFlowComponentBase):
    def onInitialize(self):
        self.chooser = OpenRTM_aist.SdoServiceAdmin()
        self.again = OpenRTM_aist.SdoServiceAdmin.select
        self.addSdoServiceProvider(None, None)
        self.exit = 1
        if CORBA.is_nil(None):
            orb.findType("IDL:X:1.0")
        return RTC.RTC_OK, Part("a", ""), URI
"""


def test_absent_names_are_found_with_their_first_lines() -> None:
    assert absences_in(SOURCE, "Robot.py") == [
        AbsentUse(9, "OpenRTM_aist.SdoServiceAdmin"),
        AbsentUse(11, "RTObject.addSdoServiceProvider"),
        AbsentUse(14, "omniORB.findType"),
        AbsentUse(15, "SDOPackage.DeviceProfile"),
        AbsentUse(15, "omniORB.URI"),
    ]


def test_methods_of_its_own_are_none() -> None:
    source = b"import OpenRTM_aist\nclass R:\n  def exit(self): ...\n  def go(self): self.exit()\n"
    assert absences_in(source, "R.py") == []
