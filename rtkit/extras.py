"""Extras of rtkit: which one brings a module, and how it is had where this process runs."""

from __future__ import annotations

import os
import sys

_OF_MODULES = {
    "Ice": "ice", "cryptography": "hosts", "cv2": "vision", "fissix": "openrtm", "h11": "http",
    "numpy": "sim", "paho": "mqtt", "pynmea2": "gps", "rdflib": "rdf", "serial": "serial",
    "starlette": "web", "textual": "gui", "uvicorn": "web", "watchfiles": "storage",
}  # fmt: skip


def how_to_get(extra: str) -> str:
    """Return the command that brings an extra to the Python that runs this.

    Where another host has made it, that host does: what is installed beside goes with the version.
    """
    if f"{os.sep}rtkit{os.sep}versions{os.sep}" not in os.path.realpath(sys.prefix):
        return f"pip install 'rtkit[{extra}]'"
    name = os.environ.get("RTKIT_HOSTNAME", "NAME")
    start = f"rtmgr start --replace --host {name}"
    return (
        f"where this host was started: rthost add --force {name} ADDRESS --extra {extra}; {start}"
    )


def hint(error: BaseException) -> str:
    """Return how a module that is not there is had, with a colon before; empty if by no extra."""
    if not isinstance(error, ModuleNotFoundError):
        return ""
    extra = _OF_MODULES.get((error.name or "").partition(".")[0])
    return f": {how_to_get(extra)}" if extra else ""
