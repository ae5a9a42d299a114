"""Configuration of a manager: the command line over ``rtc.conf`` over the environment."""

from __future__ import annotations

import json
import os
from typing import NamedTuple

from rtkit.errors import Malformed, NotFound
from rtkit.settings import rtcconf, values
from rtkit.settings.properties import STRICT, Settings
from rtkit.settings.reading import read_private

PORT_VARIABLE = "RTKIT_PORT"


class CommandLineSettings(NamedTuple):
    """Settings of the command line.

    Attributes:
        file: Configuration file, empty for the first that is found.
        overrides: ``KEY:VALUE`` each, which take precedence over the file.
        may_lack_file: Go on without a file that was named and is not there.
    """

    file: str = ""
    overrides: tuple[str, ...] = ()
    may_lack_file: bool = False

    def to_text(self) -> str:
        """Return it as one argument of a process."""
        return json.dumps(self)


class ManagerConfiguration(NamedTuple):
    """Properties that were given, their file, and warnings about it."""

    settings: Settings
    file: str = ""
    warnings: tuple[str, ...] = ()


class TcpEndpointSettings(NamedTuple):
    """Address of the TCP endpoint, None for none; `is_asked` when the port was given."""

    port: int | None
    is_asked: bool


def wanted_from_text(text: str) -> CommandLineSettings:
    """Rebuild what `CommandLineSettings.to_text` returned."""
    file, overrides, may_lack_file = json.loads(text)
    return CommandLineSettings(file, tuple(overrides), may_lack_file)


def read(wanted: CommandLineSettings) -> ManagerConfiguration:
    """Read the configuration file, if there is one, and lay the overrides over it.

    Raises:
        NotFound: A file that was named is not there.
        Refused: It cannot be read, or strangers can have written it.
        Malformed: A line or an override cannot be read, or has a warning and the start is strict.
    """
    settings = Settings()
    file, entries = _read_file(wanted)
    warnings = rtcconf.warnings(entries, file)
    overrides = [rtcconf.parse_override(text) for text in wanted.overrides]
    warnings += rtcconf.warnings(overrides, file)
    for entry in (*entries, *overrides):
        settings.take(entry.key, entry.value)
    if warnings and settings.flag(STRICT):
        raise Malformed("; ".join(warnings))
    return ManagerConfiguration(settings, file, tuple(warnings))


def _read_file(wanted: CommandLineSettings) -> tuple[str, list[rtcconf.RtcConfEntry]]:
    if wanted.file:
        places = iter([(wanted.file, True)])
    else:
        places = rtcconf.candidates(os.environ, os.getcwd())
    for path, is_named in places:
        try:
            data = read_private(path, must_be_ours=not is_named)
        except NotFound:
            if is_named and not wanted.may_lack_file:
                raise NotFound(f"no such configuration file: {path}") from None
        else:
            return path, rtcconf.parse(data, path)
    return "", []


def tcp_endpoint_settings(settings: Settings) -> TcpEndpointSettings:
    """Return the address of the TCP endpoint of a manager with these properties.

    Raises:
        Malformed: The environment names no port.
    """
    if not settings.flag("manager.net_servant"):
        return TcpEndpointSettings(None, True)
    text = settings.text("net.endpoints") if settings.is_given("net.endpoints") else ""
    if text.lower() not in ("", "all"):
        return TcpEndpointSettings(values.endpoint(text), True)
    usual = os.environ.get(PORT_VARIABLE, "").strip()
    if not usual or text:
        return TcpEndpointSettings(values.DEFAULT_PORT, False)
    try:
        return TcpEndpointSettings(values.endpoint(usual), True)
    except Malformed as error:
        raise Malformed(f"{PORT_VARIABLE}: {error}") from None


def name(word: str, settings: Settings) -> str:
    """Return the name of the manager: as typed, of the environment, or of its properties."""
    chosen = word or os.environ.get("RTKIT_MANAGER") or settings.text("manager.instance_name")
    return chosen or settings.text("manager.name")
