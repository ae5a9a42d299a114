"""Compares, exports and imports configuration sets: ``rtconf diff``, ``export``, ``import``."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

from rtkit.cli.components.conf import ConfRequest, Sets
from rtkit.cli.components.conf.sets import change, seen, visible
from rtkit.cli.components.conf.shown import no_set, record_of
from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.errors import InvalidDocument, NotFound, Refused

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts

STDIN = "-"
VERBS = ("diff", "export", "import")


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


def do(app: App, facts: ComponentFacts, asked: ConfRequest) -> int:
    """Compare, write or take over sets of a component; return the exit status.

    Raises:
        NotFound: No such set, parameter or file.
        InvalidDocument: The file holds no configuration sets.
        RtkitError: The component refused.
    """
    sets, chosen = seen(facts, asked)
    argument = asked.arguments[0] if asked.arguments else STDIN
    if asked.verb == "export":
        _export(facts, chosen, argument)
        return 0
    if asked.verb == "import":
        _import(app, facts, sets, asked, argument)
        return 0
    found = list(_differences(facts, sets, asked, argument))
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
        raise no_set(other, sets)
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
    from rtkit.cli.shared.atomic import write_output

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
        if name not in sets:
            raise no_set(name, sets)
    changed = {
        name: {key: text for key, text in values.items() if facts.sets[name].get(key) != text}
        for name, values in wanted.items()
    }
    change(app, facts, {name: values for name, values in changed.items() if values}, active)


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
