"""The part of a snapshot that concerns a few components, for who wants to know no more."""

from __future__ import annotations

from collections.abc import Iterable

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.records import replace


def part_of(snapshot: Snapshot, instances: Iterable[str]) -> Snapshot:
    """Return a snapshot with these components, their connectors, and who is at the other ends.

    Of those at the other ends, and of members and composites, only identity, place and names are
    told.
    """
    wanted = set(instances)
    wires = tuple(w for w in snapshot.connectors if any(e.instance in wanted for e in w.ports))
    near = {end.instance for wire in wires for end in wire.ports} - wanted
    for facts in snapshot.components:
        if facts.instance in wanted:
            near.update({*facts.members, facts.composite} - wanted)
    components = tuple(
        facts if facts.instance in wanted else _outline(facts)
        for facts in snapshot.components
        if facts.instance in wanted or facts.instance in near
    )
    return replace(snapshot, components=components, connectors=wires)


def _outline(facts: ComponentFacts) -> ComponentFacts:
    return ComponentFacts(
        facts.instance, facts.type, facts.process, names=facts.names, zombie=facts.zombie
    )
