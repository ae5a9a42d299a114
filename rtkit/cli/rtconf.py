"""``rtconf``: show and change configuration sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import click

from rtkit.cli import _out
from rtkit.cli._app import App, WrongArguments, command
from rtkit.errors import NotFound, Refused

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts, Snapshot
    from rtkit.deployment.listing import Listing
    from rtkit.rtc.names import Path
    from rtkit.tree.view import Node

_GUARD = "\0"


class _NumbersAreArguments(click.Command):
    """Takes ``-1.5`` for an argument, not for an option."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        # A mark that no argument of a process can contain hides the minus from the parser.
        start = args.index("set") if "set" in args else len(args)
        guarded = [_GUARD + arg if _is_negative(arg) else arg for arg in args[start:]]
        return super().parse_args(ctx, args[:start] + guarded)


def _is_negative(argument: str) -> bool:
    return argument[:1] == "-" and (argument[1:2].isdigit() or argument[1:2] == ".")


class _Asked(NamedTuple):
    """What to do with which set."""

    verb: str
    arguments: tuple[str, ...]
    set_id: str
    has_hidden: bool
    is_long: bool
    is_json: bool


@command("rtconf", cls=_NumbersAreArguments)
@click.option("-a", "--all", "has_hidden", is_flag=True, help="Include hidden sets (__name__).")
@click.option("-l", "is_long", is_flag=True, help="List parameters and their values.")
@click.option("-s", "--set", "set_id", default="", metavar="SET", help="Default: the active set.")
@click.option("--json", "is_json", is_flag=True, help="For list and get: one JSON object.")
@click.argument("words", nargs=-1, metavar="PATH [list|set|get|act] [ARGUMENT]...")
def main(
    app: App, words: tuple[str, ...], has_hidden: bool, is_long: bool, set_id: str, is_json: bool
) -> None:
    r"""Show and change the configuration sets of a component.

    \b
    list               the sets; the active one has a * (this is what happens without a word)
    get PARAM          the value of a parameter
    set PARAM VALUE    change one parameter
    set A=1 B=2 ...    change several, all or none
    act                make the set given with -s the active one

    A change of the active set takes effect at once. Of a manager, list and get show its
    properties. A value that begins with a minus and is no number needs -- before the path.
    """
    from rtkit.tree.view import Kind

    typed, asked = _asked(words, has_hidden, is_long, set_id, is_json)
    path = app.path(typed)
    node = _node(app.tree.listing(), path)
    snapshot = app.tree.part([node.instance])
    facts = snapshot.component(node.instance)
    if node.kind is Kind.MANAGER:
        _of_manager(snapshot, path, asked)
    elif facts is None:
        raise NotFound(f"No such object: {path.typed}")
    else:
        _of_component(app, facts, asked)


def _asked(
    words: Sequence[str], has_hidden: bool, is_long: bool, set_id: str, is_json: bool
) -> tuple[str, _Asked]:
    if not words:
        raise WrongArguments
    typed, *rest = [word.removeprefix(_GUARD) for word in words]
    verb, *arguments = rest or ["list"]
    count = len(arguments)
    is_fit = {
        "list": count == 0,
        "get": count == 1,
        "set": count == 2 or bool(count and all("=" in each[1:] for each in arguments)),
        "act": count == 0 and bool(set_id),
    }
    if not is_fit.get(verb, False):
        raise WrongArguments("act needs -s SET" if verb == "act" and not count else "")
    return typed, _Asked(verb, tuple(arguments), set_id, has_hidden, is_long, is_json)


def _node(listing: Listing, path: Path) -> Node:
    from rtkit.tree.resolve import find
    from rtkit.tree.view import Kind, build

    node = find(build(listing), path, listing.host)
    if path.port is not None and node is not None:
        raise Refused(f"Not a component: {path.typed}")
    if node is not None and node.kind is Kind.ZOMBIE and not path.is_directory:
        raise Refused(f"Zombie object: {path.typed}")
    is_known = node is not None and node.kind in (Kind.COMPONENT, Kind.MANAGER)
    if node is None or not is_known or (path.is_directory and not node.is_directory):
        raise NotFound(f"No such object: {path.typed}")
    return node


def _of_component(app: App, facts: ComponentFacts, asked: _Asked) -> None:
    sets = {
        name: values for name, values in facts.sets.items() if asked.has_hidden or not _hidden(name)
    }
    set_id = asked.set_id or facts.active_set
    if (asked.verb != "list" or asked.set_id) and set_id not in sets:
        raise NotFound(f"No such configuration set: {set_id}")
    if asked.verb == "list":
        chosen = {asked.set_id: sets[asked.set_id]} if asked.set_id else sets
        _list(facts, chosen, asked)
    elif asked.verb == "get":
        _get(asked.arguments[0], sets[set_id], asked)
    elif asked.verb == "act":
        _activate(app, facts.instance, set_id)
    else:
        _set(app, facts, set_id, asked.arguments)


def _hidden(name: str) -> bool:
    return len(name) > 4 and name.startswith("__") and name.endswith("__")


def _list(facts: ComponentFacts, sets: Mapping[str, Mapping[str, str]], asked: _Asked) -> None:
    if asked.is_json:
        _print_json({"active": facts.active_set, "sets": {k: dict(v) for k, v in sets.items()}})
        return
    lines = []
    for name in sorted(sets):
        is_active = name == facts.active_set
        style = _out.STYLES["active-set" if is_active else "name"]
        line = ("-" if asked.is_long else "+") + _out.styled(name, style)
        lines.append(line + ("*" if is_active else "" if asked.is_long else " "))
        if asked.is_long:
            lines += _out.pairs(sorted(sets[name].items()))
    _out.write(lines)


def _get(name: str, values: Mapping[str, str], asked: _Asked) -> None:
    if name not in values:
        raise NotFound(f"No such configuration parameter: {name}")
    if asked.is_json:
        _print_json({"name": name, "value": values[name]})
        return
    text = values[name]
    _out.write([_out.printable(text) if _out.is_terminal() else text])


def _set(app: App, facts: ComponentFacts, set_id: str, arguments: Sequence[str]) -> None:
    from rtkit.deployment.actions import Action, ActivateSet, SetParameters

    values = _values(arguments)
    for name in values:
        if name not in facts.sets[set_id]:
            raise NotFound(f"No such configuration parameter: {name}")
    actions: list[Action] = [SetParameters(facts.instance, set_id, values)]
    if set_id == facts.active_set:
        actions.append(ActivateSet(facts.instance, set_id))
    for result in app.tree.apply(actions):
        result.raise_for_error()


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


def _of_manager(snapshot: Snapshot, path: Path, asked: _Asked) -> None:
    properties = snapshot.properties
    if asked.verb not in ("list", "get") or asked.set_id:
        raise Refused(f"a manager's properties can only be listed and read here: {path.typed}")
    if asked.verb == "get":
        _get(asked.arguments[0], properties, asked)
    elif asked.is_json:
        _print_json(dict(properties))
    else:
        _out.write(_out.pairs(sorted(properties.items()), ""))


def _print_json(record: Mapping[str, object]) -> None:
    from json import dumps

    _out.write([dumps({"schema": "rtkit.conf/1", **record})])
