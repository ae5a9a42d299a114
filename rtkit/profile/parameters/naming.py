"""Renames all that a system profile names, so that systems can live side by side.

Names of a system are those of its components, connectors, groups and slaves, and its own. States,
configuration sets, contexts and ports belong to one of these and keep their names.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from rtkit.errors import Malformed
from rtkit.fast_dataclass import fields, is_record, replace
from rtkit.profile import rts_model as m
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.words import PATH_ID
from rtkit.rtc.create import listed_names, parse_create
from rtkit.rtc.names import COMPONENT_SUFFIX
from rtkit.rtc.naming_properties import CREATE, EVENT, SLAVE_RESTART, STATE

Rename = Callable[[str], str]
Reference = m.ComponentRef | m.TargetComponent | m.TargetPort
_MEMBERS = ("members", "exported_ports")
_OF_PORTS = ("rtkit.health.rate.", "rtkit.stand-in.")
"""Properties of components that end in the name of a port."""


def prefixed(profile: m.RtsProfile, prefix: str) -> m.RtsProfile:
    """Return a profile with a text before all its names; none changes nothing."""
    return renamed(profile, lambda name: prefix + name) if prefix else profile


def renamed(profile: m.RtsProfile, new: Rename) -> m.RtsProfile:
    """Return a profile in which each name is another one; references follow."""
    return _Renaming(profile, new).profile(profile)


def with_references(value: Any, change: Callable[[Reference], Reference | None]) -> Any:
    """Return a model in which each reference to a component is changed.

    What a reference changed to None is needed for is None as well; of several that stand in a
    list it is left out.
    """
    if isinstance(value, Reference):
        return change(value)
    changes: dict[str, Any] = {}
    for each in fields(value):
        old = getattr(value, each.name)
        if isinstance(old, tuple) and old and is_record(type(old[0])):
            made = (with_references(item, change) for item in old)
            changes[each.name] = tuple(item for item in made if item is not None)
        elif is_record(type(old)):
            changes[each.name] = new = with_references(old, change)
            if new is None:
                return None
    return replace(value, **changes) if changes else value


class _Renaming:
    def __init__(self, profile: m.RtsProfile, new: Rename) -> None:
        self._new = new
        self._own = {component.instance_name for component in profile.components}
        names = sorted(self._own, key=len, reverse=True)
        self._name = "|".join(map(re.escape, names)) or "(?!)"
        self._leading = re.compile(rf"({self._name})(?=\.|$)")

    def profile(self, profile: m.RtsProfile) -> m.RtsProfile:
        made: m.RtsProfile = with_references(profile, self._reference)
        return replace(
            made,
            id=self._system(profile.id),
            components=tuple(map(self._component, made.components)),
            groups=tuple(replace(each, group_id=self._new(each.group_id)) for each in made.groups),
            data_port_connectors=tuple(map(self._connector, made.data_port_connectors)),
            service_port_connectors=tuple(map(self._connector, made.service_port_connectors)),
            properties=tuple(map(self._of_system, made.properties)),
        )

    def _reference(self, value: Reference) -> Reference:
        name = self._instance(value.instance_name)
        if not isinstance(value, m.TargetPort):
            return replace(value, instance_name=name)
        port = self._port(value.port_name, value.instance_name)
        properties = tuple(map(self._of_end, value.properties))
        return replace(value, instance_name=name, port_name=port, properties=properties)

    def _instance(self, name: str) -> str:
        return self._new(name) if name in self._own else name

    def _system(self, id: str) -> str:
        parts = id.split(":")
        if len(parts) < 3:
            return self._new(id)
        return ":".join([*parts[:2], self._new(parts[2]), *parts[3:]])

    def _path(self, path: str) -> str:
        folder, slash, name = path.rpartition("/")
        is_name = name.rstrip().endswith(COMPONENT_SUFFIX)
        return f"{folder}{slash}{self._new(name)}" if is_name else path

    def _leading_name(self, text: str) -> str:
        """Return ``INSTANCE`` or ``INSTANCE.REST`` with the new name."""
        found = self._leading.match(text)
        return self._new(found[0]) + text[found.end() :] if found else text

    def _port(self, name: str, instance: str) -> str:
        """Return the name of a port; a composite shows those of members as ``MEMBER.PORT``."""
        own = name.removeprefix(f"{instance}.")
        shown = self._leading_name(own) if "." in own else own
        return shown if own == name else f"{self._instance(instance)}.{shown}"

    def _component(self, each: m.ComponentInstance) -> m.ComponentInstance:
        def ports(listed: tuple[m.InstancePort, ...]) -> tuple[m.InstancePort, ...]:
            return tuple(
                replace(port, name=self._port(port.name, each.instance_name)) for port in listed
            )

        return replace(
            each,
            instance_name=self._new(each.instance_name),
            path_uri=self._path(each.path_uri),
            data_ports=ports(each.data_ports),
            service_ports=ports(each.service_ports),
            configuration_sets=tuple(map(self._set, each.configuration_sets)),
            properties=tuple(map(self._of_component, each.properties)),
        )

    def _set(self, each: m.ConfigurationSet) -> m.ConfigurationSet:
        data = tuple(
            replace(item, data=self._list(item.data or ""))
            if item.name in _MEMBERS and item.data
            else item
            for item in each.data
        )
        return replace(each, data=data)

    def _list(self, text: str) -> str:
        """Return a list of members, or of ports of theirs, with the new names."""
        named = listed_names(text)
        renamed = list(map(self._leading_name, named))
        return text if renamed == list(named) else ",".join(renamed)

    def _connector(self, each: Any) -> Any:
        return replace(
            each,
            connector_id=self._new(each.connector_id),
            name=self._new(each.name) if each.name else each.name,
            properties=tuple(
                replace(item, name=self._leading_name(item.name)) if ".port." in item.name else item
                for item in each.properties
            ),
        )

    def _of_end(self, item: ExtensionProperty) -> ExtensionProperty:
        is_path = item.name == PATH_ID and item.value
        return replace(item, value=self._path(item.value or "")) if is_path else item

    def _of_component(self, item: ExtensionProperty) -> ExtensionProperty:
        if item.name == CREATE and item.value:
            return replace(item, value=self._create(item.value))
        for head in _OF_PORTS:
            if item.name.startswith(head) and "." in item.name[len(head) :]:
                return replace(item, name=head + self._leading_name(item.name[len(head) :]))
        return item

    def _create(self, text: str) -> str:
        try:
            made = parse_create(text)
        except Malformed:
            return text  # refused, with its line, by whoever makes components
        changed = {}
        for key, value in made.options.items():
            if key == "instance_name" or (key == "manager_name" and "%" not in value):
                changed[key] = self._new(value)
            elif key.rpartition(".")[2] in _MEMBERS:
                changed[key] = self._list(value)
        return str(made.with_options(**changed)) if changed else text

    def _of_system(self, item: ExtensionProperty) -> ExtensionProperty:
        if item.name.startswith(SLAVE_RESTART):
            slave = item.name.removeprefix(SLAVE_RESTART)
            return replace(item, name=f"{SLAVE_RESTART}{self._new(slave)}")
        if item.name.startswith((STATE, EVENT)) and item.value:
            named = rf"((?:^|;)\s*(?:lost\s+)?)({self._name})(?=[.\s=<>!;]|$)"
            value = re.sub(named, lambda found: found[1] + self._new(found[2]), item.value)
            return replace(item, value=value)
        return item
