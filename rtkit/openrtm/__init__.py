"""Runs components written for OpenRTM-aist-Python as they lie, without OpenRTM and omniORB.

The loader of modules hands a file that imports `OpenRTM_aist` to `rtkit.openrtm.loading`. Names
in camel case are those that authors of such components call.
"""
