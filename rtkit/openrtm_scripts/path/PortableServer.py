"""First name of OpenRTM that a script imports; see `rtkit.openrtm_scripts.script`."""

from rtkit.openrtm_scripts.script import take_over

take_over(__name__)
