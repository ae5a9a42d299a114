"""The short form of a snapshot: one row a component, which is all that a listing needs.

The manager answers with it in one small reply; clients rebuild it from a full snapshot.
"""

from __future__ import annotations

import json
from collections import Counter
from typing import TYPE_CHECKING, NamedTuple

from rtkit.errors import Malformed
from rtkit.rtc.enums import PortType

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts, Snapshot


_ABSENT = "no "


def device_absence(device: str) -> str:
    """Return for which end a component is to be made again that waits for a device."""
    return f"{_ABSENT}{device}"


def is_device_absence(why: str) -> bool:
    """Return whether a component that is to be made again waits for a device."""
    return why.startswith(f"{_ABSENT}/")


class ListingRow(NamedTuple):
    """One component in short.

    Attributes:
        ins: How many in ports it has; ``ins_connected`` … ``services_connected`` count likewise.
        context: Id of its first execution context.
        cause: Cause of its Error, one line with file:line.
        again: Input that it waits for; how often its policy restarted it, and for what; what else
            was done about its health; empty for nothing.
        restarts: How often it was restarted after its loss.
        restarted_for: For what its policy did so the last time; mostly empty.
        due_s: When it is to be restarted, on the monotonic clock of its host [s]; 0 for never.
        given_up: Why it is restarted no more; empty when it is not given up.
    """

    instance: str
    state: str
    ins: int
    ins_connected: int
    outs: int
    outs_connected: int
    services: int
    services_connected: int
    process: str
    zombie: str
    trouble: str
    is_stand_in: bool
    names: tuple[str, ...]
    context: str = ""
    cause: str = ""
    again: str = ""
    restarts: int = 0
    restarted_for: str = ""
    due_s: float = 0.0
    given_up: str = ""

    @property
    def is_in_hand(self) -> bool:
        """Return whether it is dead, and its policy brings it back, or gave it up."""
        is_seen_to = self.due_s or self.given_up or is_device_absence(self.zombie)
        return bool(self.zombie) and bool(is_seen_to)

    def coming(self, now_s: float) -> str:
        """Return in how long it comes back, from monotonic `now_s` [s] on; empty if it does not."""
        if is_device_absence(self.zombie):
            return "comes back with it"
        if not self.due_s:
            return ""
        left_s = self.due_s - now_s
        if left_s <= 0:
            return "just coming back"
        return f"comes back in {left_s:.{0 if left_s >= 1 else 1}f} s"


class Listing(NamedTuple):
    """A manager's short answer about itself.

    Attributes:
        slaves: Name, state and reason of each slave process.
        names: Paths under which the manager itself is registered.
        trouble: Work that is stuck in the manager's own process and is no component.
    """

    host: str
    manager: str
    pid: int
    slaves: tuple[tuple[str, str, str], ...]
    rows: tuple[ListingRow, ...]
    names: tuple[str, ...] = ()
    trouble: str = ""


def listing_of(snapshot: Snapshot) -> Listing:
    """Return the short form of a snapshot."""
    slaves = tuple((p.name, p.state, p.reason) for p in snapshot.processes if p.is_slave)
    connected = connected_ports(snapshot)
    rows = tuple(row_of(component, connected) for component in snapshot.components)
    rows = _with_halves(rows, snapshot)
    trouble = next((p.reason for p in snapshot.processes if p.pid == snapshot.pid), "")
    return Listing(
        snapshot.host, snapshot.manager, snapshot.pid, slaves, rows, snapshot.names, trouble
    )


def _with_halves(rows: tuple[ListingRow, ...], snapshot: Snapshot) -> tuple[ListingRow, ...]:
    """Return rows with a remark where only half of a connection to another manager is there."""
    halves = [connector for connector in snapshot.connectors if connector.trouble]
    if not halves:
        return rows
    texts: dict[str, str] = {}
    for connector in halves:
        for end in connector.ports:
            texts[end.instance] = f"half a connection at {end.port}: {connector.trouble}"
    return tuple(
        row._replace(again=", ".join(filter(None, (row.again, texts.get(row.instance, "")))))
        for row in rows
    )


def connected_ports(snapshot: Snapshot) -> Counter[tuple[str, str]]:
    """Count the connections of each (instance, port), also under the names that composites show."""
    counts = Counter(
        (end.instance, end.port) for connector in snapshot.connectors for end in connector.ports
    )
    composites = [facts for facts in snapshot.components if facts.members]
    if not composites:
        return counts
    from rtkit.deployment.shown_ports import OwnEnds

    own = OwnEnds.of(snapshot)
    for facts in composites:
        for name, end in own.ends(facts).items():
            count = counts.get((end.instance, end.port), 0)
            if count:
                counts[facts.instance, name] = count
    return counts


def row_of(component: ComponentFacts, connected: Counter[tuple[str, str]]) -> ListingRow:
    """Return one component's row."""
    made = dict.fromkeys(PortType, 0)
    wired = dict.fromkeys(PortType, 0)
    for port in component.ports:
        made[port.port_type] += 1
        wired[port.port_type] += (component.instance, port.name) in connected
    return ListingRow(
        component.instance,
        component.state,
        made[PortType.IN],
        wired[PortType.IN],
        made[PortType.OUT],
        wired[PortType.OUT],
        made[PortType.SERVICE],
        wired[PortType.SERVICE],
        component.process,
        component.zombie,
        component.trouble or component.restart_status.trouble,
        component.is_stand_in,
        component.names,
        component.contexts[0].id if component.contexts else "",
        component.cause,
        "; ".join(filter(None, (component.waits, component.restart_status.history))),
        component.restart_status.restarts,
        component.restart_status.why,
        component.restart_status.due_s,
        component.restart_status.given_up,
    )


def listing_to_text(listing: Listing) -> str:
    """Return a listing as the text that travels."""
    return json.dumps(listing, separators=(",", ":"))


def listing_from_text(text: str) -> Listing:
    """Rebuild a listing.

    Raises:
        Malformed: The text is no listing.
    """
    try:
        host, manager, pid, slaves, rows, names, trouble = json.loads(text)
        return Listing(
            str(host),
            str(manager),
            int(pid),
            tuple((str(name), str(state), str(why)) for name, state, why in slaves),
            tuple(
                ListingRow._make(
                    [
                        *row,
                        tuple(names),
                        *map(str, (context, cause, again)),
                        int(restarts),
                        str(why),
                        float(due_s),
                        str(given_up),
                    ]
                )
                for *row, names, context, cause, again, restarts, why, due_s, given_up in rows
            ),
            tuple(map(str, names)),
            str(trouble),
        )
    except (ValueError, TypeError) as error:
        raise Malformed(f"not a listing: {error}") from error
