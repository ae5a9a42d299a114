"""Applies properties to a process and its components: logs, processors, load paths of modules."""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping

from rtkit.container.context_thread import check
from rtkit.container.processors import use
from rtkit.deployment.message import Message
from rtkit.errors import Refused
from rtkit.logs.logfile import LogFile, LogTarget, Lossy, Terminal
from rtkit.logs.logs import begin_component, level_of
from rtkit.logs.records import Readable
from rtkit.modules.loader import Loader
from rtkit.rtc.create import CreateString
from rtkit.rtc.profiles import TypeProfile
from rtkit.settings.properties import Settings
from rtkit.settings.reading import read_private
from rtkit.settings.rtcconf import parse
from rtkit.settings.values import processors

_STREAMS = {"stdout": 1, "stderr": 2}


def configure(message: Message, loader: Loader) -> None:
    """Apply what `rtkit.manager.core.manager_properties.message` tells, as the manager sent it.

    Raises:
        Refused: A processor is not there.
    """
    if message["processors"]:
        use(processors(message["processors"]))
    set_log_level(message["log_level"])
    loader.configure(
        message["load_path"],
        is_absolute_allowed=message["is_absolute_allowed"],
        is_search_allowed=message["is_search_allowed"],
    )


def complete(
    message: Message, create: CreateString, type: TypeProfile, *, inherits: bool = True
) -> CreateString:
    """Return a create string with all properties; its component's log is as they say from now on.

    Raises:
        RtkitError: A property, or a file of them, cannot be read.
    """
    whole = layered(create, type, message, inherits=inherits)
    check(whole.options)
    begin_component(create.instance_name, whole.options, message.get("inherited") or {})
    return whole


def set_log_level(level: str) -> None:
    """Log what is at least of this level, by its word; "" is nothing."""
    root, number = logging.getLogger(), level_of(level or "SILENT")
    if root.level != number:  # every logger would work out its own anew
        root.setLevel(number)


def add_log_files(settings: Settings, name: str) -> None:
    """Log to the files of ``logger.file_name`` too.

    Raises:
        Refused: A file cannot be written.
    """
    is_coloured = settings.flag("logger.escape_sequence_enable")
    formatter = Readable(name, settings.text("logger.date_format"), is_coloured=is_coloured)
    for item in settings.items("logger.file_name"):
        path = item.replace("%p", str(os.getpid()))
        descriptor = _STREAMS.get(path.lower())
        target: LogTarget
        if descriptor is not None:
            target = Terminal(os.dup(descriptor))
        else:
            target = LogFile(path)
            try:
                target.write(b"")
            except OSError as error:
                raise Refused(f"cannot write log file {path}: {error.strerror}") from error
        logging.getLogger().addHandler(Lossy(target, formatter))


def layered(
    create: CreateString, type: TypeProfile, message: Message, *, inherits: bool = True
) -> CreateString:
    """Return a create string with all properties that the component is to have.

    The strongest first: create string, what the manager was given for the instance, file of the
    instance, the same of the type, what is inherited from the manager. Without any of these, the
    default of the type applies.

    Raises:
        NotFound: A configuration file is not there.
        Refused: It cannot be read, or others may write it.
        Malformed: A line of it cannot be read.
    """
    files: Mapping[str, str] = message.get("config_files") or {}
    given: Mapping[str, Mapping[str, str]] = message.get("given") or {}
    layers = [dict(message.get("inherited") or {}) if inherits else {}]
    for name in (type.type_name, create.instance_name):
        for category in _categories(type):
            path = files.get(f"{category}.{name}")
            if path:
                layers.append(_read(path))
            layers.append(dict(given.get(f"{category}.{name}") or {}))
    own = create.options.get("config_file")
    if own:
        layers.append(_read(own))
    if not any(layers):
        return create
    merged: dict[str, str] = {}
    for layer in (*layers, create.options):
        merged.update(layer)
    return create.with_options(**merged)


def _categories(type: TypeProfile) -> tuple[str, ...]:
    """Return the category of a type; a composite has that of OpenRTM, too, which tells its kind."""
    if type.category != "composite":
        return (type.category,)
    return (type.category, f"composite.{type.type_name.removesuffix('Composite')}")


def _read(path: str) -> dict[str, str]:
    return {key: value for key, value, _ in parse(read_private(path), path)}
