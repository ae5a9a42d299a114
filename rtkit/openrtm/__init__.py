"""Runs components written for OpenRTM-aist-Python as they lie, without OpenRTM and omniORB.

The loader of modules hands a file that imports `OpenRTM_aist` to `rtkit.openrtm.loading.module`.
Names in camel case are those that authors of such components call.

- `convert` writes such components as native ones.
- `loading` runs their modules, with the names that these import.
- `csp` has the ports of CSP.
- `api` has all else of `OpenRTM_aist`.
- `corba` has data, objects and services: CORBA, `RTC` and what IDL files declare.
- `migrate` makes Python 3 of their sources.
"""
