"""The system that is broken: who lives where, who is connected to whom, under which policy."""

from __future__ import annotations

from campaign.counts import CELLS
from rtkit.deployment.actions import Action, ChangeState, Connect, Create, SetParameters
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef

NAMES = tuple(f"Cell{number}" for number in range(CELLS))
MANAGER = "manager"
PLACES = (
    *(MANAGER, "a", "a", "b", "b"),
    *(MANAGER, "c", "c", "d", "d"),
    *(MANAGER, "e", "e", "f", "f"),
    *(MANAGER, "g", "g", "h", "i"),
)
"""In which process each of the cells lives."""
SLAVES = tuple(sorted(set(PLACES) - {MANAGER}))

STEPS = (1, 7)
"""Each cell sends its numbers to those so many places further on."""
WIRES = tuple((n, (n + step) % CELLS) for step in STEPS for n in range(CELLS))

FAVOURS = tuple((n, (n + 1) % CELLS) for n in range(CELLS))
"""Each cell may call a service of the next one."""

DEADLINE_S = 1.0
"""How long a callback may take until it counts as stuck [s]."""

_POLICY = {
    "rtkit.restart": "on-failure",
    "rtkit.health.stuck": "restart",
    "exec_cxt.callback_deadline": f"{DEADLINE_S:g}",
}
_BUFFER = {
    "dataport.buffer.length": "1000",
    "dataport.buffer.write.full_policy": "block",
    "dataport.publisher.push_policy": "all",
}
"""No number may be lost: whoever writes to a full buffer waits."""


def members(place: str) -> tuple[int, ...]:
    """Return the cells that live in a process."""
    return tuple(number for number, its in enumerate(PLACES) if its == place)


def wire_id(sender: int, receiver: int) -> str:
    """Return the id of the connector from one cell to another."""
    return f"{NAMES[sender]}-{NAMES[receiver]}"


def favour_id(caller: int, provider: int) -> str:
    """Return the id of the connector over which a cell calls another."""
    return f"{NAMES[caller]}-asks-{NAMES[provider]}"


CONNECTORS = (*(wire_id(*wire) for wire in WIRES), *(favour_id(*wire) for wire in FAVOURS))
"""The ids of all connectors."""


def creations() -> list[Action]:
    """Return what makes the cells."""
    return [Create(_create_string(number)) for number in range(CELLS)]


def _create_string(number: int) -> str:
    place = PLACES[number]
    options = {"instance_name": NAMES[number], "index": str(number), **_POLICY}
    if place != MANAGER:
        options["manager_name"] = place
    return "Cell?" + "&".join(f"{key}={value}" for key, value in options.items())


def settings() -> list[Action]:
    """Return what connects and configures them."""
    connects: list[Action] = [Connect(_connector(*wire)) for wire in WIRES]
    connects += [Connect(_favour(*wire)) for wire in FAVOURS]
    sets = [
        SetParameters(name, "default", {"gain": gain(number)}) for number, name in enumerate(NAMES)
    ]
    return [*connects, *sets]


def gain(number: int) -> str:
    """Return the gain that a cell is to have."""
    return str(number + 2)


def _connector(sender: int, receiver: int) -> ConnectorProfile:
    ends = PortRef(NAMES[sender], "out"), PortRef(NAMES[receiver], "into")
    name = wire_id(sender, receiver)
    return ConnectorProfile(name, name, ends, _BUFFER)


def _favour(caller: int, provider: int) -> ConnectorProfile:
    ends = PortRef(NAMES[caller], "asks"), PortRef(NAMES[provider], "asked")
    name = favour_id(caller, provider)
    return ConnectorProfile(name, name, ends, {})


def activations() -> list[Action]:
    """Return what brings them to work."""
    return [ChangeState(name, "0", Transition.ACTIVATE) for name in NAMES]
