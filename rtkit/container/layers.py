"""Merges the properties of a component from these sources, strongest first.

Create string, file of the instance, file of the type, what is inherited from the manager.
Without any of these, the default of the type applies.
"""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.deployment.message import Message
from rtkit.rtc.create import CreateString
from rtkit.rtc.profiles import TypeProfile
from rtkit.settings.reading import read_private
from rtkit.settings.rtcconf import parse


def layered(
    create: CreateString, type: TypeProfile, message: Message, *, inherits: bool = True
) -> CreateString:
    """Return a create string with all properties that the component is to have.

    Raises:
        NotFound: A configuration file is not there.
        Refused: It cannot be read, or others may write it.
        Malformed: A line of it cannot be read.
    """
    files: Mapping[str, str] = message.get("config_files") or {}
    layers = [dict(message.get("inherited") or {}) if inherits else {}]
    for name in (type.type_name, create.instance_name):
        path = files.get(f"{type.category}.{name}")
        if path:
            layers.append(_read(path))
    own = create.options.get("config_file")
    if own:
        layers.append(_read(own))
    if not any(layers):
        return create
    merged: dict[str, str] = {}
    for layer in (*layers, create.options):
        merged.update(layer)
    return create.with_options(**merged)


def _read(path: str) -> dict[str, str]:
    return {key: value for key, value, _ in parse(read_private(path), path)}
