"""Lists what components in the manager's process started, so that the next manager ends it.

Slaves have a zygote that inherits what they leave. A manager that is killed leaves its own to
whoever is above it, so the next one knows it by a mark in its environment, and by a list that is
written once a second: for what hides from the mark.
"""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Collection, Iterator
from contextlib import suppress

from rtkit.container.orphans import began_at, end_family, environment_of, family, family_beside
from rtkit.link import places, running
from rtkit.link.deadline import boot_id
from rtkit.manager.child_process import MARK

_log = logging.getLogger(__name__)
KIND = "family"
"""Kind of the file with the list."""
_LOOKS = 5
"""How often at most is looked again while something new is found."""


def bear_mark(manager: str) -> None:
    """Have the manager's own process pass the mark on."""
    os.environ["RTKIT_MANAGER"] = manager  # for what components connect to, or start
    os.environ[MARK] = f"{places.manager_lock(manager)}:{os.getpid()}:{began_at(os.getpid())}"


class Descendants:
    """Writes the list of descendants of this process other than its zygotes and slaves."""

    def __init__(self, manager: str) -> None:
        folder = places.runtime_dir()
        self._path = os.path.join(folder, f"{manager}.{os.getpid()}.{KIND}")
        self._written: dict[int, int] = {}

    def note(self, others: Collection[int]) -> None:
        """Write what there is beside these, if that has changed."""
        present = family_beside(others)
        if present == self._written:
            return
        self._written = present
        text = json.dumps({"boot": boot_id(), "began": present})
        try:
            with open(f"{self._path}.new", "w", encoding="ascii", opener=_opened) as file:
                file.write(text)
            os.replace(f"{self._path}.new", self._path)
        except OSError as error:
            _log.warning("what components here have started cannot be noted: %s", error)


def _opened(path: str, flags: int) -> int:
    return os.open(path, flags, 0o600)


def end_descendants(manager: str) -> list[int]:
    """Kill what components in a manager of that name left that was killed; return its pids."""
    ended: list[int] = []
    for path in running.traces(manager, KIND).values():
        known = _read(path)
        for pid, began in known.items():
            if began_at(pid) == began:
                below = family(pid)
                end_family({pid: began, **below})
                ended += [pid, *below]
    if _is_one_dead(manager):
        for _ in range(_LOOKS):
            marked = dict(_marked(manager))
            if not marked:
                break
            end_family(marked)
            ended += marked
    return sorted(set(ended))


def _read(path: str) -> dict[int, int]:
    """Return the processes of a list, by pid when each began; only of this run of the machine."""
    with suppress(OSError, ValueError, TypeError, AttributeError), open(path, "rb") as file:
        record = json.load(file)
        if record.get("boot") == boot_id():
            return {int(pid): int(began) for pid, began in record["began"].items()}
    return {}


def _is_one_dead(manager: str) -> bool:
    """Return whether a process of a manager was killed: only then all processes are searched."""
    return any(not began_at(pid) for pid in running.traces(manager, "beats"))


def _marked(manager: str) -> Iterator[tuple[int, int]]:
    """Yield pid and start of the processes that bear the mark of a manager that has ended."""
    begins = f"{MARK}={places.manager_lock(manager)}:".encode()
    for entry in os.listdir("/proc"):
        if not entry.isdigit():
            continue
        for each in environment_of(int(entry)):
            if each.startswith(begins) and _has_ended(each[len(begins) :].decode()):
                began = began_at(int(entry))
                if began:
                    yield int(entry), began


def _has_ended(owner: str) -> bool:
    pid, _, began = owner.partition(":")
    return pid.isdigit() and str(began_at(int(pid))) != began
