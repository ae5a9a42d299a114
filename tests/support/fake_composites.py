"""Composites of the fake manager: changes of the facts when one is created, edited or deleted."""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.component.composite import TYPES
from rtkit.deployment.facts import ComponentFacts
from rtkit.errors import NotFound, Refused
from rtkit.fast_dataclass import replace
from rtkit.rtc.create import CreateString
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import PortProfile, TypeProfile

MEMBERS = "members"
EXPORTED = "exported_ports"
_DEFAULT = "default"

Components = Mapping[str, ComponentFacts]


def pattern_of(type_name: str) -> ComponentPattern | None:
    """Return the pattern of a composite type, None for other types."""
    known = TYPES.get(type_name)
    if known is None:
        return None
    kind = TypeProfile(type_name, known.vendor, known.category, known.version)
    return ComponentPattern(kind, sets={_DEFAULT: {MEMBERS: "", EXPORTED: ""}})


def made(facts: ComponentFacts, create: CreateString) -> ComponentFacts:
    """Return a component just made, as a composite with its members if it is one.

    Nothing is arranged yet.
    """
    kind = TYPES.get(facts.type.type_name)
    if kind is None or facts.is_stand_in:
        return facts
    given = {key: create.options[key] for key in (MEMBERS, EXPORTED) if key in create.options}
    sets = {**facts.sets, _DEFAULT: {**facts.sets[_DEFAULT], **given}}
    return replace(facts, composite_type=kind.composite_type, sets=sets)


def arranged(components: Components, whole: ComponentFacts) -> dict[str, ComponentFacts]:
    """Return the facts that change when a composite becomes what its active set states.

    Raises:
        NotFound: There is no such component in its process, or no such port.
        Refused: A component is a member of another composite.
    """
    if not whole.composite_type:
        return {}
    said = whole.sets[whole.active_set]
    changes: dict[str, ComponentFacts] = parted(components, whole.instance)
    wanted = {name: _joining(components, whole, name) for name in _names(said)}
    changes.update((name, replace(each, composite=whole.instance)) for name, each in wanted.items())
    ports = [_shown(name, wanted) for name in _names(said, EXPORTED)]
    changes[whole.instance] = replace(whole, members=tuple(wanted), ports=tuple(ports))
    return changes


def parted(components: Components, instance: str) -> dict[str, ComponentFacts]:
    """Return the facts that change when a component leaves its composite and frees its members."""
    changes = {}
    for name, each in components.items():
        if each.composite == instance:
            changes[name] = replace(each, composite="")
        elif instance in each.members:
            ports = (port for port in each.ports if not port.name.startswith(f"{instance}."))
            left = tuple(member for member in each.members if member != instance)
            changes[name] = replace(each, members=left, ports=tuple(ports))
    return changes


def _member(components: Components, name: str) -> ComponentFacts:
    facts = components.get(name)
    if facts is None or facts.zombie:
        raise NotFound(f"no component named {name}")
    return facts


def _joining(components: Components, whole: ComponentFacts, name: str) -> ComponentFacts:
    facts = _member(components, name)
    if facts.process != whole.process:
        raise NotFound(f"no component named {name}")
    if name == whole.instance:
        raise Refused(f"{name} cannot be a member of itself: {name}")
    if facts.composite not in ("", whole.instance):
        raise Refused(f"{name} is a member of {facts.composite} already")
    return facts


def _shown(name: str, members: Components) -> PortProfile:
    for instance, facts in members.items():
        port = facts.port(name.removeprefix(f"{instance}."))
        if port is not None and port.name != name:
            return replace(port, name=name)
    raise NotFound(f"Port not found: {name}")


def _names(values: Mapping[str, str], key: str = MEMBERS) -> list[str]:
    parts = (name.strip() for name in values.get(key, "").split(","))
    return list(dict.fromkeys(name for name in parts if name))
