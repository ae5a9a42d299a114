"""Parses connections made at start: ``A.out?port=B.in&dataflow_type=push`` to connectors."""

from __future__ import annotations

from rtkit.deployment.shown_ports import OwnEnds
from rtkit.errors import Malformed, NotFound
from rtkit.manager.core.state import ManagerState
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import PortType
from rtkit.rtc.nearest import did_you_mean
from rtkit.rtc.port_types import are_reversed
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef

_DEFAULTS = {
    "dataport.dataflow_type": "push",
    "dataport.interface_type": "zenoh",
    "dataport.subscription_type": "new",
}
_OWN = ("dataport.", "port.", "rtkit.")


def connector(state: ManagerState, text: str) -> ConnectorProfile | None:
    """Return the connector to be made, None when the ports are connected already.

    Raises:
        Malformed: The text cannot be read.
        NotFound: A port is not there.
    """
    options = dict(parse_create(text).options)
    other = options.pop("port", "")
    if not other:
        raise Malformed(f"not COMPONENT.PORT?port=COMPONENT.PORT: {text}")
    one_ref, one = _port(state, text.partition("?")[0])
    other_ref, its = _port(state, other)
    ends = (one_ref, other_ref)
    if are_reversed((one.port_type, its.port_type)):
        ends = (other_ref, one_ref)
    if any(set(wire.ports) == set(ends) for wire in state.connectors.values()):
        return None
    given = {key if key.startswith(_OWN) else f"dataport.{key}": v for key, v in options.items()}
    if one.port_type is PortType.SERVICE:
        properties = {"port.port_type": PortType.SERVICE.value, **given}
    else:
        data_type = one.data_type or its.data_type
        properties = {**_DEFAULTS, "dataport.data_type": data_type, **given}
    name = "_".join(end.port for end in ends)
    return ConnectorProfile("-".join(map(str, ends)), name, ends, properties)


def _port(state: ManagerState, text: str) -> tuple[PortRef, PortProfile]:
    """Find a port by ``COMPONENT.PORT``; both names may have dots."""
    parts = text.split(".")
    for index in range(len(parts) - 1, 0, -1):
        facts = state.components.get(".".join(parts[:index]))
        port = facts.port(".".join(parts[index:])) if facts is not None else None
        if port is not None:
            ref = PortRef(".".join(parts[:index]), port.name)
            return OwnEnds(state.components).end(ref), port
    known = [f"{name}.{port.name}" for name, c in state.components.items() for port in c.ports]
    raise NotFound(f"no such port: {text}{did_you_mean(text, known)}")
