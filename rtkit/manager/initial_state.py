"""State that a manager begins with: its names, its settings, and what the machine is."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING

from rtkit.link.places import host_name
from rtkit.manager.core import events as ev
from rtkit.manager.core.state import ManagerState, Process
from rtkit.resources import resource as shipped
from rtkit.settings import formats
from rtkit.settings.properties import Settings
from rtkit.version import __version__

if TYPE_CHECKING:
    from rtkit.deployment.limits import Capacity

USUAL_NAME = "%n.mgr"
"""Template of the name that each manager has, so that all of a host are found in one place."""


def initial_state(name: str, folder: str, settings: Settings) -> ManagerState:
    """Return the state of a manager that begins, started in a folder.

    Raises:
        Malformed: A template gives a name with an empty element.
    """
    state = ManagerState(host_name(), name, os.getpid(), __version__)
    state.names = _names(state.host, name, settings)
    state.processes[ev.OWN_PROCESS] = Process(ev.OWN_PROCESS, name, os.getpid(), "up")
    state.settings, state.folder = settings, folder
    state.base_paths = _base_paths()
    state.capacity = _capacity
    state.properties.update(
        {
            "manager.instance_name": name,
            "manager.pid": str(os.getpid()),
            "manager.started": f"{time.time():.3f}",
            "manager.started_after_boot": f"{time.clock_gettime(time.CLOCK_BOOTTIME):.3f}",
            "openrtm.name": "rtkit",
            "openrtm.version": __version__,
            **_system(),
            "rtkit.version": __version__,
        }
    )
    return state


def _capacity() -> Capacity:
    from rtkit.manager.limits.control_groups import capacity

    return capacity()


def _names(host: str, name: str, settings: Settings) -> tuple[str, ...]:
    """Return under which names the manager itself is registered.

    Raises:
        Malformed: A template gives a name with an empty element.
    """
    templates = (USUAL_NAME, *formats.check_early(settings.text("manager.naming_formats")))
    return formats.expand(templates, instance=name, host=host, manager=name, pid=os.getpid())


def _system() -> dict[str, str]:
    """Return what this machine is."""
    system = os.uname()
    return {
        "os.name": system.sysname,
        "os.release": system.release,
        "os.version": system.version,
        "os.arch": system.machine,
        "os.hostname": system.nodename,
    }


def _base_paths() -> tuple[str, ...]:
    """Return where modules are always looked for: ``RTKIT_MODULE_PATH``, the samples."""
    chosen = os.environ.get("RTKIT_MODULE_PATH", "")
    named = [os.path.abspath(path) for path in chosen.split(os.pathsep) if path]
    return (*named, shipped("examples", "basic"))
