"""Finds unknown options of a create string, whatever component is made with them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache

from rtkit.component.base import ACTIVE_SET
from rtkit.component.ports.options import remarks
from rtkit.deployment import extension
from rtkit.rtc.nearest import CLOSE, did_you_mean
from rtkit.settings import properties

CONF = "conf."
_OWN = "rtkit."
_OPTIONS = (
    "instance_name", "manager_name", "manager_address", "manager", "language", "config_file",
    "members", "exported_ports", ACTIVE_SET, extension.TRANSMIT,
)  # fmt: skip
_EXTENSIONS = tuple(
    value for value in vars(extension).values() if isinstance(value, str) and value.startswith(_OWN)
)


def unknown_options(options: Mapping[str, str]) -> Iterator[str]:
    """Yield findings about options that resemble known ones, a line each."""
    connector = {key: value for key, value in options.items() if key.startswith("dataport.")}
    if connector:
        yield from remarks(connector)
    for key in options:
        if key.startswith(CONF):
            set_id, _, name = key.removeprefix(CONF).partition(".")
            if not set_id or not name:
                yield f"not conf.SET.PARAMETER: {key}"
        elif key not in connector and not key.startswith("port.") and (warning := _warning_of(key)):
            yield warning


@lru_cache(maxsize=256)  # the components of a system have the same few options
def _warning_of(key: str) -> str:
    if _is_known(key):
        return ""
    known = [*_OPTIONS, *_EXTENSIONS, *properties.KNOWN]
    hint = did_you_mean(key, known, 1, least=CLOSE)
    return f"unknown option: {key}{hint}" if hint or key.startswith(_OWN) else ""


def _is_known(key: str) -> bool:
    is_own = any(key == each or key.startswith(f"{each.rstrip('.')}.") for each in _EXTENSIONS)
    return key in _OPTIONS or is_own or properties.find(key) is not None
