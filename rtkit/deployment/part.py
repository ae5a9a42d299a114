"""Takes from a snapshot the facts about a few components."""

from __future__ import annotations

from collections.abc import Iterable

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.shown_ports import OwnEnds
from rtkit.fast_dataclass import replace


def part_of(snapshot: Snapshot, instances: Iterable[str]) -> Snapshot:
    """Return a snapshot with these components, their connectors, and who is at the other ends.

    Of those at the other ends, and of members and composites, only identity, place and names are
    included, of members their ports, too.
    """
    wanted = set(instances)
    chosen = [facts for facts in snapshot.components if facts.instance in wanted]
    own = OwnEnds.of(snapshot)
    shown = {end for facts in chosen if facts.members for end in own.ends(facts).values()}
    connectors = tuple(
        connector
        for connector in snapshot.connectors
        if any(end.instance in wanted or end in shown for end in connector.ports)
    )
    inner = {member for facts in chosen if facts.members for member in own.inner(facts.instance)}
    near = {end.instance for connector in connectors for end in connector.ports} | inner
    near.update(facts.composite for facts in chosen)
    components = tuple(
        facts if facts.instance in wanted else _outline(facts, facts.instance in inner)
        for facts in snapshot.components
        if facts.instance in wanted or facts.instance in near
    )
    return replace(snapshot, components=components, connectors=connectors)


def _outline(facts: ComponentFacts, is_inner: bool) -> ComponentFacts:
    outline = ComponentFacts(
        facts.instance, facts.type, facts.process, names=facts.names, zombie=facts.zombie
    )
    # Members and ports state whose ports are shown.
    return replace(outline, ports=facts.ports, members=facts.members) if is_inner else outline
