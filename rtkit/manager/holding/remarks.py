"""Options of a create string that mean nothing to the component that is made with them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtkit.component.base import ACTIVE_SET, Component
from rtkit.component.options import remarks
from rtkit.component.standin import TRANSMIT
from rtkit.deployment import extension
from rtkit.manager.settings import properties
from rtkit.rtc.nearest import CLOSE, did_you_mean

_CONF = "conf."
_OWN = "rtkit."
_OPTIONS = (
    "instance_name",
    "manager_name",
    "manager_address",
    "manager",
    "language",
    "config_file",
    "members",
    "exported_ports",
    ACTIVE_SET,
    TRANSMIT,
)
_EXTENSIONS = tuple(
    value for value in vars(extension).values() if isinstance(value, str) and value.startswith(_OWN)
)


def odd_options(component: Component, options: Mapping[str, str]) -> list[str]:
    """Return what to tell of options that look like others that are known, a line each.

    Others are properties of the component, which may ask for them.
    """
    connector = {key: value for key, value in options.items() if key.startswith("dataport.")}
    found = [*_parameters(component, options), *remarks(connector)]
    known = [*_OPTIONS, *_EXTENSIONS, *properties.KNOWN]
    for key in options:
        if key in connector or key.startswith((_CONF, "port.")) or _is_known(key):
            continue
        hint = did_you_mean(key, known, 1, least=CLOSE)
        found += [f"unknown option: {key}{hint}"] if hint else []
    return found


def _is_known(key: str) -> bool:
    is_own = any(key == each or key.startswith(f"{each.rstrip('.')}.") for each in _EXTENSIONS)
    return key in _OPTIONS or is_own or properties.find(key) is not None


def _parameters(component: Component, options: Mapping[str, str]) -> Iterator[str]:
    """Yield options for parameters that the component does not have."""
    if component.is_stand_in or component.composite_type:
        return
    known = component.configuration.values
    for key in options:
        if not key.startswith(_CONF):
            continue
        set_id, _, name = key.removeprefix(_CONF).partition(".")
        if not set_id or not name:
            yield f"not conf.SET.PARAMETER: {key}"
        elif name not in known and not set_id.startswith("_"):
            hint = did_you_mean(name, known, 1)
            yield f"{component.instance} has no parameter {name}{hint}: {key}"
