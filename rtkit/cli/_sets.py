"""The words of ``rtconf``: what is done with the configuration sets of one component."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit.cli import _out
from rtkit.cli._app import App, WrongArguments
from rtkit.errors import Malformed, NotFound, Partial, Refused, RtkitError

if TYPE_CHECKING:
    from rtkit.deployment.actions import Action
    from rtkit.deployment.facts import ComponentFacts
    from rtkit.rtc.names import Path
    from rtkit.statics.blueprint import ParameterType

Sets = Mapping[str, Mapping[str, str]]
DESCRIPTION = "description"
"""The parameter of a set that tells what the set is for."""


class Asked(NamedTuple):
    """What to do with which set."""

    verb: str
    arguments: tuple[str, ...]
    set_id: str
    has_hidden: bool
    is_long: bool
    is_json: bool


def of_component(app: App, facts: ComponentFacts, asked: Asked) -> None:
    """List, get, set or activate what was asked of a component.

    Raises:
        NotFound: No such set or parameter.
        RtkitError: It refused.
    """
    sets, chosen = seen(facts, asked)
    set_id = asked.set_id or facts.active_set
    if asked.verb == "list":
        _list(facts, chosen, asked)
    elif asked.verb == "get":
        _get(asked.arguments[0], sets[set_id], asked)
    elif asked.verb == "act":
        _activate(app, facts.instance, set_id)
    else:
        change(app, facts, {set_id: _values(asked.arguments)})


def seen(facts: ComponentFacts, asked: Asked) -> tuple[Sets, Sets]:
    """Return the sets that are to be seen, and those of them that were asked for.

    Raises:
        NotFound: There is no set of the name that was given, or is needed.
    """
    sets = visible(facts.sets, asked)
    set_id = asked.set_id or facts.active_set
    if (asked.verb in ("get", "set", "act") or asked.set_id) and set_id not in sets:
        raise NotFound(f"No such configuration set: {set_id}")
    return sets, {asked.set_id: sets[asked.set_id]} if asked.set_id else sets


def visible(sets: Sets, asked: Asked) -> Sets:
    """Return those sets that are to be seen."""
    return {name: sets[name] for name in sets if asked.has_hidden or not _hidden(name)}


def _hidden(name: str) -> bool:
    return len(name) > 4 and name.startswith("__") and name.endswith("__")


def _list(facts: ComponentFacts, sets: Sets, asked: Asked) -> None:
    if asked.is_json:
        print_json({"active": facts.active_set, "sets": {k: dict(v) for k, v in sets.items()}})
        return
    lines = []
    for name in sorted(sets):
        is_active = name == facts.active_set
        style = _out.STYLES["active-set" if is_active else "name"]
        line = ("-" if asked.is_long else "+") + _out.styled(name, style)
        line += "*" if is_active else "" if asked.is_long else " "
        told = sets[name].get(DESCRIPTION, "")
        lines.append(f"{line} ({_out.printable(told)})" if told else line)
        if asked.is_long:
            lines += _out.pairs(sorted(sets[name].items()))
    _out.write(lines)


def _get(name: str, values: Mapping[str, str], asked: Asked) -> None:
    if name not in values:
        raise NotFound(f"No such configuration parameter: {name}")
    if asked.is_json:
        print_json({"name": name, "value": values[name]})
        return
    lines = values[name].split("\n")
    _out.write(map(_out.printable, lines) if _out.is_terminal() else lines)


def change(app: App, facts: ComponentFacts, wanted: Sets, active_set: str = "") -> None:
    """Write parameters of sets, and make a set the active one; all is checked before anything.

    Raises:
        NotFound: No such parameter.
        Malformed: A text that the parameter cannot have.
        RtkitError: The component refused.
    """
    from rtkit.deployment.actions import ActivateSet, SetParameters

    check(facts, wanted, app.tell)
    actions: list[Action] = [
        SetParameters(facts.instance, set_id, values) for set_id, values in wanted.items()
    ]
    target = active_set or facts.active_set
    if target in wanted or target != facts.active_set:
        actions.append(ActivateSet(facts.instance, target))
    for result in app.tree.apply(actions) if actions else ():
        result.raise_for_error()


def check(facts: ComponentFacts, wanted: Sets, tell: Callable[[str], object]) -> None:
    """Refuse parameters that do not exist, and texts that do not fit.

    What the component says of its parameters counts, and what an RTC profile found here says of
    those of which the component says nothing. `tell` hears of places that cannot be looked at.

    Raises:
        NotFound: No such parameter.
        Malformed: A text that the parameter cannot have.
    """
    from rtkit.component.fit import misfit, misfit_of

    declared = _declared(facts, wanted, tell)
    bad: list[tuple[str, RtkitError]] = []
    for set_id, values in wanted.items():
        for name, text in values.items():
            if name not in facts.sets[set_id]:
                raise NotFound(f"No such configuration parameter: {name}")
            # What a hidden set holds are hints, not values of the parameters.
            if _hidden(set_id):
                continue
            why = misfit(facts.sets, name, text)
            known = declared.get(name)
            if known is not None and not why and text != known.default:
                why = misfit_of(known.declared, text)
            if why:
                bad.append((name, Malformed(f"{name} cannot be {text!r}: {why}")))
    if len(bad) == 1:
        raise bad[0][1]
    if bad:
        raise Partial("nothing was changed", bad)


def _declared(
    facts: ComponentFacts, wanted: Sets, tell: Callable[[str], object]
) -> Mapping[str, ParameterType]:
    """Return what an RTC profile says of parameters for which the component gives no constraint."""
    from rtkit.component.fit import CONSTRAINT_SET

    told = facts.sets.get(CONSTRAINT_SET, {})
    if all(name in told for values in wanted.values() for name in values):
        return {}
    from rtkit.cli._components import profiles

    found = list(profiles((), tell, with_shipped=False))
    if not found:
        return {}
    from rtkit.statics.stock import Document, stocked

    catalogue, _ = stocked((Document(*each) for each in found), {facts.type.type_name})
    match = catalogue.find(facts.type.id)
    return match.blueprint.parameters if match is not None else {}


def _values(arguments: Sequence[str]) -> dict[str, str]:
    if len(arguments) == 2 and "=" not in arguments[0]:
        return {arguments[0]: arguments[1]}
    values = {}
    for argument in arguments:
        name, equals, value = argument.partition("=")
        if not equals:
            raise WrongArguments(f"not PARAM=VALUE: {argument}")
        values[name] = value
    return values


def _activate(app: App, instance: str, set_id: str) -> None:
    from rtkit.deployment.actions import ActivateSet

    app.tree.perform(ActivateSet(instance, set_id))


def of_manager(app: App, properties: Mapping[str, str], path: Path, asked: Asked) -> None:
    """Do what was asked with the properties of a manager.

    Raises:
        Refused: It has no sets.
        NotFound: No such property.
    """
    if asked.verb not in ("list", "get", "set") or asked.set_id:
        raise Refused(f"a manager has properties, but no configuration sets: {path.typed}")
    if asked.verb == "get":
        name = asked.arguments[0]
        _get(name, properties if name in properties else {name: _asked_for(app, name)}, asked)
    elif asked.verb == "set":
        for key, value in _values(asked.arguments).items():
            app.tree.set(key, value)
            tell_vain(app, key, value)
    elif asked.is_json:
        print_json(dict(properties))
    else:
        _out.write(_out.pairs(sorted(properties.items()), ""))


def _asked_for(app: App, name: str) -> str:
    """Return what a manager tells besides its properties, as ``get_slave_managers``.

    Raises:
        NotFound: It has nothing of that name.
    """
    try:
        return app.tree.get(name)
    except NotFound as error:
        raise NotFound(f"No such configuration parameter: {name}") from error


def tell_vain(app: App, key: str, value: str) -> None:
    """Say so if a property of a manager was set that has no effect."""
    from rtkit.manager.settings.properties import vain

    if why := vain(key, value):
        app.fail(f"note: {why}")


def print_json(*records: Mapping[str, object], indent: int | None = None) -> None:
    """Print records as JSON, one a line unless they are indented."""
    _out.write(to_json(records, indent))


def to_json(records: Iterable[Mapping[str, object]], indent: int | None = None) -> list[str]:
    """Return records as JSON."""
    from json import dumps

    return [dumps({"schema": "rtkit.conf/1", **record}, indent=indent) for record in records]
