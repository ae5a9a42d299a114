"""Reads the states that a system's profile defines."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rtkit.errors import InvalidDocument, Malformed, NotFound

if TYPE_CHECKING:
    from rtkit.api.document import SystemDocument
    from rtkit.api.planning import DeploymentInputs
    from rtkit.deployment.states.machine import SystemStates, Table
    from rtkit.deployment.states.states import States


def states_of(begun: DeploymentInputs) -> States:
    """Return the states of a system.

    Raises:
        InvalidDocument: Its profile tells none, or they make no sense.
    """
    from rtkit.deployment.states.states import States

    return States(begun.document.profile.id, read_machine(begun.document), begun.goal)


def read_machine(document: SystemDocument) -> SystemStates:
    """Return the states of a system profile, checked.

    Raises:
        InvalidDocument: It tells none, or they make no sense.
    """
    from rtkit.deployment.described import properties_of
    from rtkit.deployment.extension import STATE_CHART, STATES
    from rtkit.deployment.states.machine import machine_of

    profile = document.profile
    properties = properties_of(profile.properties)
    sets = {c.instance_name: [s.id for s in c.configuration_sets] for c in profile.components}
    chart = properties.get(STATE_CHART)
    try:
        table = _chart(chart, document.source) if chart is not None else None
        machine = machine_of(properties, sets, table)
    except Malformed as error:
        raise InvalidDocument(f"{document.source}: {error}") from error
    if machine is None:
        raise InvalidDocument(f"{document.source}: it tells no states ({STATES} of the system)")
    return machine


def _chart(text: str, source: str) -> Table:
    """Return states and transitions of SCXML: the text, or a file beside the profile."""
    from rtkit.profile.read import STDIN, read_bytes
    from rtkit.profile.scxml import read_scxml

    if text.lstrip().startswith("<"):
        return read_scxml(text.encode(), source).states
    folder = os.path.dirname(source) if source != STDIN else ""
    path = os.path.join(folder, text.strip())
    try:
        return read_scxml(read_bytes(path), path).states
    except NotFound as error:
        raise InvalidDocument(f"{source}: the state chart: {error}") from error
