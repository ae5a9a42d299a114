"""Renders a manager, or a slave of one, for ``rtcat``: as lines, or as a record for JSON."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from rtkit.cli.shared import terminal

if TYPE_CHECKING:
    from rtkit.cli.shared.offers import Offers
    from rtkit.deployment.facts import ProcessFacts, Snapshot

_MODULES = (
    ("Load path", "manager.modules.load_path"),
    ("Config path", "manager.modules.config_path"),
    ("Preload", "manager.modules.preload"),
    ("Init function prefix", "manager.modules.init_func_prefix"),
    ("Init function suffix", "manager.modules.init_func_suffix"),
    ("Download allowed", "manager.modules.download_allowed"),
    ("Absolute path allowed", "manager.modules.abs_path_allowed"),
)
_SYSTEM = (
    ("Version", "os.version"),
    ("Architecture", "os.arch"),
    ("Release", "os.release"),
    ("Host name", "os.hostname"),
    ("Name", "os.name"),
)


def manager_lines(snapshot: Snapshot, process: ProcessFacts | None, offers: Offers) -> list[str]:
    """Describe a manager, or a slave of it by the facts of its process."""
    known = snapshot.properties
    name = snapshot.manager if process is None else process.name
    title = known.get("manager.instance_name", name) if process is None else name
    rows = [
        ("Name", known.get("manager.name", name) if process is None else name),
        ("Instance name", title),
        ("Process ID", str(snapshot.pid if process is None else process.pid)),
        ("Naming format", known.get("manager.naming_formats", "")),
        ("Refstring path", known.get("manager.refstring_path", "")),
        ("Components precreate", known.get("manager.components.precreate", "")),
    ]
    shown = _process(snapshot, process)
    if shown is not None and (shown.state != "up" or shown.reason):
        rows += [("State", f"{shown.state} {shown.reason}")]
    lines = _titled(rows)
    lines += ["Modules:", *_titled([(t, known.get(key, "")) for t, key in _MODULES], "  ")]
    lines += ["OS:", *_titled([(t, known.get(key, "")) for t, key in _SYSTEM], "  ")]
    lines += ["Loaded modules:"]
    paths = dict.fromkeys(module.path for module in snapshot.modules)
    lines += _titled([("Filepath", path) for path in paths], "  ")
    return [*lines, "Loadable modules:", *(f"  {terminal.printable(id)}" for id in offers.types)]


def _process(snapshot: Snapshot, slave: ProcessFacts | None) -> ProcessFacts | None:
    """Return the facts of the process that is shown: a slave, else the manager's own."""
    own = (process for process in snapshot.processes if process.pid == snapshot.pid)
    return slave if slave is not None else next(own, None)


def _titled(rows: Iterable[tuple[str, str]], indent: str = "") -> list[str]:
    return [f"{indent}{title}: {terminal.printable(text)}".rstrip() for title, text in rows]


def manager_record(
    snapshot: Snapshot, process: ProcessFacts | None, offers: Offers
) -> dict[str, Any]:
    """Return the facts of a manager, or of a slave of it, for JSON."""
    from rtkit.rtc.serde import encode

    shown = _process(snapshot, process)
    return {
        "name": snapshot.manager if process is None else process.name,
        "pid": snapshot.pid if process is None else process.pid,
        "state": "up" if process is None else process.state,
        "reason": shown.reason if shown is not None else "",
        "version": snapshot.version,
        "modules": [encode(module) for module in snapshot.modules],
        "loadable": [{"type": id, "module": file} for id, file in offers.types.items()],
        "properties": dict(snapshot.properties),
    }
