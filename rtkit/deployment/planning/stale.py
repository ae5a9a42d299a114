"""Stale code: finds components whose module files changed after loading, and the remedy.

A process loads a module once. So a new slave has to replace the old one, with all components in
it, to load the present file; the manager's own process loads it only when it starts again.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.live_index import LiveIndex


class Stale:
    """The components of one snapshot by their processes, and which files have changed."""

    def __init__(self, live: LiveIndex, named: Collection[str], code: Mapping[str, str]) -> None:
        """Index a snapshot.

        Args:
            live: Facts of the live system.
            named: Components that a plan may make again.
            code: CRC-32 of files of modules, as they are.
        """
        self._named = named
        self._files: dict[str, str] = {}
        self._holders: dict[str, tuple[str, str]] = {}
        self._held: dict[tuple[str, str], list[str]] = {}
        for facts in live.snapshot.components if code else ():
            if facts.zombie:
                continue
            holder = (live.home(facts.instance), facts.process)
            self._holders[facts.instance] = holder
            self._held.setdefault(holder, []).append(facts.instance)
            file = facts.changed_code(code)
            if file:
                self._files[facts.instance] = file
        self._guests = {
            (manager, process.name)
            for manager, snapshot in live.managers.items()
            for process in snapshot.processes
            if process.is_guest
        }
        self._slaves = {
            (manager, process.name)
            for manager, snapshot in live.managers.items()
            for process in snapshot.processes
            if process.is_slave
        }

    def mates(self, instance: str) -> tuple[str, ...]:
        """Return who else must have ended before a component is created again with its new code."""
        return tuple(each for each in self._together(instance) if each != instance)

    def reasons(self, facts: ComponentFacts) -> Iterator[str]:
        """Yield why a component must be created again: its code, or that of others in its slave."""
        for each in self._together(facts.instance) if not self._hindrance(facts.instance) else ():
            if each in self._files:
                whose = "its" if each == facts.instance else f"in its slave {each}'s"
                yield f"{whose} code has changed since it was loaded ({self._files[each]})"

    def notes(self, facts: ComponentFacts, path: str) -> Iterator[str]:
        """Yield the text for a user about a component that runs old code, with a hint."""
        file = self._files.get(facts.instance)
        if file:
            helps = self._hindrance(facts.instance) or "--replace makes it again"
            yield f"{path}: its code has changed since it was loaded ({file}); {helps}"

    def _together(self, instance: str) -> list[str]:
        """Return all that is in the process of a component, if any of it runs old code."""
        held = self._held.get(self._holders.get(instance, ("", "")), [])
        return held if any(each in self._files for each in held) else []

    def _hindrance(self, instance: str) -> str:
        holder = self._holders.get(instance, ("", ""))
        if holder in self._guests:
            return "it was started by hand: start it again"
        if holder not in self._slaves:
            return "rtmgr restart loads it anew"
        strangers = [each for each in self._held[holder] if each not in self._named]
        others = ", ".join(strangers)
        return f"its slave {holder[1]} holds {others}, too: not in the profile" if others else ""
