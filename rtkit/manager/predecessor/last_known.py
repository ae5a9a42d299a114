"""Reads from the disk what is known of a manager that does not run, as it would tell it itself.

Its store, the checkpoints of its slaves and their output are put together, nothing is changed.
"""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.container.slave_checkpoint import SlaveCheckpoint
from rtkit.deployment.facts import ComponentFacts, ProcessFacts, Snapshot
from rtkit.errors import Malformed
from rtkit.fast_dataclass import replace
from rtkit.link import places, running
from rtkit.link.places import host_name
from rtkit.manager.core.desired import DesiredState
from rtkit.manager.predecessor.crashes import UnseenCrash, unseen_crashes
from rtkit.manager.predecessor.unreported import checkpoint_of, living_slaves
from rtkit.manager.store.store import rows_of_copy
from rtkit.rtc.create import readable_create
from rtkit.rtc.names import LOCAL, MANAGER_SUFFIX
from rtkit.rtc.profiles import TypeProfile
from rtkit.rtc.serde import decode

UNKNOWN = "ended while no manager ran"
WITH_MANAGER = "ended with its manager"
_SIGNALS = {
    "Illegal instruction": "signal 4",
    "Aborted": "signal 6",
    "Bus error": "signal 7",
    "Floating-point exception": "signal 8",
    "Segmentation fault": "signal 11",
}
"""Signals by what the interpreter calls them in its report of a crash."""


def last_known(manager: str) -> Snapshot | None:
    """Return what is known of a manager that does not run; None if it left nothing."""
    desired = DesiredState()
    desired.read(rows_of_copy(places.store_file(manager)))
    living = living_slaves(manager)
    slaves = {
        pid: held
        for pid in running.traces(manager, "held")
        if (held := checkpoint_of(manager, pid)) is not None
    }
    dead = {pid: held for pid, held in slaves.items() if pid not in living}
    crashes = {each.pid: each for each in unseen_crashes(manager, dead)}
    own = next((each for each in crashes.values() if not each.slave), None)
    found: dict[str, ComponentFacts] = {}
    processes = [ProcessFacts(manager, False, own.pid if own else 0, "lost", _end(own, "ended"))]
    for pid, held in sorted(slaves.items()):
        end = "" if pid in living else _end(crashes.get(pid))
        processes.append(ProcessFacts(held.name, True, pid, "lost" if end else "up", end))
        for facts in _held(held):
            found[facts.instance] = replace(facts, process=held.name, zombie=end)
            if end and pid in crashes:
                found[facts.instance] = replace(
                    found[facts.instance], since=crashes[pid].words.time_s
                )
    found = {**dict(_missing(manager, desired, own)), **desired.zombies, **found}
    if not found:
        return None
    there = {each.name for each in processes}
    lost = {each.process: each.zombie for each in found.values() if each.process not in there}
    processes += [ProcessFacts(name, True, 0, "lost", end) for name, end in lost.items()]
    return Snapshot(
        host_name(),
        manager,
        0,
        "",
        names=(f"{LOCAL}/{manager}{MANAGER_SUFFIX}",),
        processes=tuple(processes),
        components=tuple(_complete(facts, desired) for facts in found.values()),
        connectors=tuple(desired.wires.values()),
    )


def _end(crash: UnseenCrash | None, otherwise: str = UNKNOWN) -> str:
    """Return how a process ended."""
    if crash is None:
        return otherwise
    what = crash.words.stacks.partition("\n")[0].removeprefix("Fatal Python error: ")
    return crash.words.reason(_SIGNALS.get(what, what))


def _held(held: SlaveCheckpoint) -> Iterator[ComponentFacts]:
    for each in held.components:
        try:
            yield decode(ComponentFacts, each)
        except Malformed:
            continue  # written by another version


def _missing(
    manager: str, desired: DesiredState, own: UnseenCrash | None
) -> Iterator[tuple[str, ComponentFacts]]:
    """Yield the components that are in no checkpoint: the manager held them, or nobody any more."""
    ends = {each.process: each for each in desired.zombies.values()}
    for instance, each in desired.components.items():
        create = readable_create(each.create)
        type = TypeProfile(create.implementation_id, create.vendor, create.category, create.version)
        process = create.place or manager
        end, since = UNKNOWN, 0.0
        if process in ends:
            end, since = ends[process].zombie, ends[process].since
        elif process == manager:
            end, since = _end(own, WITH_MANAGER), own.words.time_s if own is not None else 0.0
        facts = ComponentFacts(
            instance, type, process, sets=each.sets, active_set=each.active_set, zombie=end
        )
        yield instance, replace(facts, since=since)


def _complete(facts: ComponentFacts, desired: DesiredState) -> ComponentFacts:
    """Add what only the store knows."""
    kept = desired.components.get(facts.instance)
    watched = desired.watched.get(facts.instance)
    if kept is not None:
        facts = replace(facts, names=kept.names, create=kept.create)
    if watched is not None:
        facts = replace(facts, restart_status=watched.restart_status(""))
    return facts
