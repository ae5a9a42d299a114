"""Describes configuration sets of a component, and properties of a manager, for ``rtconf``."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from rtkit.api import configuring
from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.errors import InvalidDocument, Malformed, NotFound, Refused

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts
    from rtkit.rtc.names import Path


Sets = Mapping[str, Mapping[str, str]]


class ConfRequest(NamedTuple):
    """The operation, and the set that it is about."""

    verb: str
    arguments: tuple[str, ...]
    set_id: str
    has_hidden: bool
    is_long: bool
    is_json: bool


def values_of(arguments: Sequence[str]) -> dict[str, str]:
    """Read ``PARAM VALUE``, or ``PARAM=VALUE`` several times.

    Raises:
        WrongArguments: One is of neither form.
    """
    if len(arguments) == 2 and "=" not in arguments[0]:
        return {arguments[0]: arguments[1]}
    return pairs_of(arguments)


def pairs_of(arguments: Sequence[str]) -> dict[str, str]:
    """Read ``PARAM=VALUE`` several times.

    Raises:
        WrongArguments: One is of another form.
    """
    values = {}
    for argument in arguments:
        name, equals, value = argument.partition("=")
        if not equals:
            raise WrongArguments(f"not PARAM=VALUE: {argument}")
        values[name] = value
    return values


def of_component(app: App, facts: ComponentFacts, asked: ConfRequest) -> int:
    """Do what was asked with the sets of a component; return the exit status.

    Raises:
        NotFound: No such set, parameter or file.
        InvalidDocument: The file holds no configuration sets.
        RtkitError: The component refused.
    """
    sets, chosen = seen(facts, asked)
    set_id = asked.set_id or facts.active_set
    argument = asked.arguments[0] if asked.arguments else STDIN
    if asked.verb == "list":
        show_sets(facts, chosen, asked)
    elif asked.verb == "get":
        show_value(argument, sets[set_id], asked)
    elif asked.verb == "act":
        configuring.activate(app, facts, set_id)
    elif asked.verb in ("add", "copy"):
        is_copy = asked.verb == "copy"
        source, new, *given = asked.arguments if is_copy else ("", *asked.arguments)
        values = {**(sets[source] if is_copy else {}), **pairs_of(given)}
        configuring.add(app, facts, new, values)
    elif asked.verb == "remove":
        configuring.remove(app, facts, argument)
    elif asked.verb == "export":
        _export(facts, chosen, argument)
    elif asked.verb == "import":
        _import(app, facts, sets, asked, argument)
    elif asked.verb == "diff":
        return _diff(app, list(_differences(facts, sets, asked, argument)), asked)
    else:
        configuring.change(app, facts, {set_id: values_of(asked.arguments)})
    return 0


def seen(facts: ComponentFacts, asked: ConfRequest) -> tuple[Sets, Sets]:
    """Return the visible sets, and those of them that were asked for.

    Raises:
        NotFound: There is no set of the name that was given, or is needed.
    """
    sets = visible(facts.sets, asked)
    is_other = asked.verb in ("copy", "remove")
    set_id = asked.arguments[0] if is_other else asked.set_id or facts.active_set
    is_needed = is_other or asked.verb in ("get", "set", "act") or asked.set_id
    if is_needed and set_id not in sets:
        raise configuring.no_set(set_id, sets)
    return sets, {asked.set_id: sets[asked.set_id]} if asked.set_id else sets


def visible(sets: Sets, asked: ConfRequest) -> Sets:
    """Return the visible sets."""
    return {
        name: sets[name] for name in sets if asked.has_hidden or not configuring.is_hidden(name)
    }


DESCRIPTION = "description"
"""The parameter of a set that tells what the set is for."""


def show_sets(facts: ComponentFacts, sets: Sets, asked: ConfRequest) -> None:
    """List sets of a component, with their parameters if that was asked for."""
    if asked.is_json:
        terminal.write([json_records.line("configuration", record_of(facts, sets))])
        return
    lines = []
    for name in sorted(sets):
        is_active = name == facts.active_set
        style = terminal.STYLES["active-set" if is_active else "name"]
        line = ("-" if asked.is_long else "+") + terminal.styled(name, style)
        line += "*" if is_active else "" if asked.is_long else " "
        description = sets[name].get(DESCRIPTION, "")
        lines.append(f"{line} ({terminal.printable(description)})" if description else line)
        if asked.is_long:
            lines += terminal.pairs(sorted(sets[name].items()))
    terminal.write(lines)


def show_value(name: str, values: Mapping[str, str], asked: ConfRequest) -> None:
    """Print one value.

    Raises:
        NotFound: There is none of that name.
    """
    if name not in values:
        raise configuring.no_parameter(name, values)
    if asked.is_json:
        terminal.write([json_records.line("parameter", {"name": name, "value": values[name]})])
        return
    lines = values[name].split("\n")
    terminal.write(map(terminal.printable, lines) if terminal.is_terminal() else lines)


def record_of(facts: ComponentFacts, sets: Sets) -> dict[str, object]:
    """Return sets of a component for JSON, as a file has them too."""
    return {
        "component": facts.instance,
        "type": facts.type.full_id,
        "active": facts.active_set,
        "sets": {name: dict(values) for name, values in sets.items()},
    }


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


STDIN = "-"


class SetDifference(NamedTuple):
    """A parameter that is not the same on both sides; None where it is not there at all."""

    here: str
    there: str
    value_here: str | None
    value_there: str | None


class SavedSets(NamedTuple):
    """Content of a file: the active set, empty when it names none, and the sets."""

    active: str
    sets: Sets


def _diff(app: App, found: Sequence[SetDifference], asked: ConfRequest) -> int:
    if asked.is_json:
        records = (each._asdict() for each in found)
        terminal.write(json_records.lines("configuration-difference", records))
    else:
        terminal.write(line for each in found for line in _lines(each))
    return app.status(Refused()) if found else 0


def _differences(
    facts: ComponentFacts, sets: Sets, asked: ConfRequest, other: str
) -> Iterator[SetDifference]:
    set_id = asked.set_id or facts.active_set
    if other in sets:
        yield from _compare(set_id, facts.sets[set_id], other, sets[other])
        return
    if other != STDIN and "/" not in other and not _is_file(other):
        raise configuring.no_set(other, sets)
    saved = _read(other)
    if saved.active not in ("", facts.active_set) and not asked.set_id:
        yield SetDifference("", "", facts.active_set, saved.active)
    names = {asked.set_id} if asked.set_id else visible(saved.sets, asked)
    for name in sorted(names):
        yield from _compare(name, sets.get(name, {}), name, saved.sets.get(name, {}))


def _is_file(name: str) -> bool:
    import os

    return os.path.exists(name)


def _compare(
    here: str, ours: Mapping[str, str], there: str, theirs: Mapping[str, str]
) -> Iterator[SetDifference]:
    for name in sorted(ours.keys() | theirs.keys()):
        if ours.get(name) != theirs.get(name):
            yield SetDifference(
                f"{here}.{name}", f"{there}.{name}", ours.get(name), theirs.get(name)
            )


def _lines(each: SetDifference) -> Iterator[str]:
    if each.value_here is not None:
        yield terminal.printable(f"-{each.here or 'active set'}  {each.value_here}")
    if each.value_there is not None:
        yield terminal.printable(f"+{each.there or 'active set'}  {each.value_there}")


def _export(facts: ComponentFacts, chosen: Sets, target: str) -> None:
    from rtkit.link.atomic import write_output

    text = json_records.line("configuration", record_of(facts, chosen), indent=2)
    write_output(f"{text}\n".encode(), target)


def _import(app: App, facts: ComponentFacts, sets: Sets, asked: ConfRequest, source: str) -> None:
    saved = _read(source)
    wanted = saved.sets
    if asked.set_id:
        if asked.set_id not in wanted:
            raise NotFound(f"No configuration set {asked.set_id} in {source}")
        wanted = {asked.set_id: wanted[asked.set_id]}
    active = "" if asked.set_id else saved.active
    for name in (*wanted, *([active] if active else [])):
        if name not in sets and (configuring.is_hidden(name) or not wanted.get(name)):
            raise configuring.no_set(name, sets)
    now = {name: facts.sets.get(name, {}) for name in wanted}
    changed = {
        name: {key: text for key, text in values.items() if now[name].get(key) != text}
        for name, values in wanted.items()
    }
    configuring.change(
        app, facts, {name: values for name, values in changed.items() if values}, active
    )


def _read(source: str) -> SavedSets:
    where = "<stdin>" if source == STDIN else source
    try:
        if source == STDIN:
            data = sys.stdin.buffer.read()
        else:
            with open(source, "rb") as file:
                data = file.read()
    except OSError as error:
        raise NotFound(f"cannot read {source}: {error.strerror}") from error
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InvalidDocument(f"{where}: not JSON: {error}") from error
    return _saved(document, where)


def _saved(document: object, where: str) -> SavedSets:
    if not isinstance(document, dict) or not isinstance(document.get("sets"), dict):
        raise InvalidDocument(f'{where}: no configuration sets: {{"sets": {{NAME: {{…}}}}}}')
    sets = {}
    for name, values in document["sets"].items():
        if not isinstance(values, dict):
            raise InvalidDocument(f"{where}: configuration set {name} is no table")
        sets[name] = {key: _text(value, f"{where}: {name}.{key}") for key, value in values.items()}
    active = document.get("active", "")
    if not isinstance(active, str):
        raise InvalidDocument(f"{where}: active is no name of a set")
    return SavedSets(active, sets)


def _text(value: object, where: str) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str | int | float):
        return str(value)
    raise InvalidDocument(f"{where} is neither text nor number")
