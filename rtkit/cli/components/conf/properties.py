"""Presents the properties of a manager to ``rtconf`` as one configuration set."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING

from rtkit.cli.components.conf import ConfRequest, values_of
from rtkit.cli.components.conf.shown import show_value
from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.errors import Malformed, NotFound, Refused

if TYPE_CHECKING:
    from rtkit.rtc.names import Path


def of_manager(app: App, properties: Mapping[str, str], path: Path, asked: ConfRequest) -> None:
    """Do what was asked with the properties of a manager.

    Raises:
        Refused: It has no sets.
        NotFound: No such property.
    """
    if asked.verb not in ("list", "get", "set") or asked.set_id:
        raise Refused(f"a manager has properties, but no configuration sets: {path.typed}")
    if asked.verb == "get":
        name = asked.arguments[0]
        known = properties if name in properties else {name: _asked_for(app, name)}
        show_value(name, known, asked)
    elif asked.verb == "set":
        given = values_of(asked.arguments)
        warn_of_vain(app, given)
        for key, value in given.items():
            app.tree.set(key, value)
    elif asked.is_json:
        terminal.write([json_records.line("properties", {"properties": dict(properties)})])
    else:
        terminal.write(terminal.pairs(sorted(properties.items()), ""))


def _asked_for(app: App, name: str) -> str:
    """Return a manager's report besides its properties, as ``get_slave_managers``.

    Raises:
        NotFound: It has nothing of that name.
    """
    try:
        return app.tree.get(name)
    except NotFound as error:
        raise NotFound(f"No such configuration parameter: {name}") from error


def warn_of_vain(app: App, given: Mapping[str, str]) -> None:
    """Warn of properties of a manager that are to be set and have no effect.

    Raises:
        Malformed: There are any, and warnings are to be taken for errors.
    """
    from rtkit.settings.properties import vain

    found = []
    for key, value in given.items():
        with suppress(Malformed):  # the manager itself refuses values that it does not take
            found.append(vain(key, value))
    app.warn(filter(None, found))
