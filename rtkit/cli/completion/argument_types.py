"""Candidates for each type of argument: paths of the tree and names that the manager knows."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from typing import Any

from rtkit.cli.completion.candidates import Candidate, Files, those
from rtkit.cli.completion.grammar import CursorMeaning
from rtkit.cli.completion.live import (
    CompletionSource,
    WantedPath,
    in_state,
    instances_of,
    living,
    paths,
    with_row,
)
from rtkit.cli.shared.app import working_directory
from rtkit.deployment.listing import ListingRow
from rtkit.rtc.names import parse_path
from rtkit.tree.view import NodeKind, TreeNode

Found = Iterable[Candidate]
Maker = Callable[[CursorMeaning, CompletionSource], "Found | Files"]
PROFILES = Files((".xml", ".yaml", ".yml", ".json"))
_CONNECTOR_PROPERTIES = (
    "dataport.dataflow_type=",
    "dataport.interface_type=",
    "dataport.push_policy=",
    "dataport.push_rate=",
    "dataport.subscription_type=",
)
_COMPOSITES = ("PeriodicECSharedComposite", "PeriodicStateSharedComposite", "GroupingComposite")


def found(asked: CursorMeaning, live: CompletionSource) -> Found | Files:
    """Return the candidates at the cursor."""
    maker = _MAKERS.get(asked.kind)
    return maker(asked, live) if maker is not None else ()


def _all(wanted: WantedPath) -> Maker:
    return lambda asked, live: paths(live, asked.typed, wanted)


def _is_manager(node: TreeNode) -> bool:
    return node.kind is NodeKind.MANAGER


def _installed_packages(asked: CursorMeaning, _live: CompletionSource) -> Found:
    from rtkit.modules.package_folders import folders

    return those((f"{each.name}=={each.version}" for each in folders()), asked.typed)


def _known_hosts(asked: CursorMeaning, _live: CompletionSource) -> Found:
    from rtkit.hosts import inventory

    return those(inventory.read(), asked.typed)


def _deletable(asked: CursorMeaning, live: CompletionSource) -> Found:
    if "-z" in asked.options:
        return paths(live, asked.typed, WantedPath(lambda node: node.kind is NodeKind.ZOMBIE))
    return paths(live, asked.typed, WantedPath(lambda _: True, takes_folders=True))


def _changeable(state: str) -> Maker:
    """Return components in a state; with a context named, all: the tree tells the merged state."""

    def make(asked: CursorMeaning, live: CompletionSource) -> Found:
        is_named = "-e" in asked.options
        again = [each for each in asked.arguments if each != asked.typed]
        candidates = paths(live, asked.typed, WantedPath(living if is_named else in_state(state)))
        return [each for each in candidates if each.text not in again]

    return make


def _ports(direction: str, count: Callable[[ListingRow], int]) -> Maker:
    """Return components that have ports of a direction, and these ports."""
    wanted = WantedPath(
        with_row(lambda row: bool(count(row))),
        has_port=True,
        port_fits=lambda _, port: port["port_type"] == direction,
    )
    return _all(wanted)


def _recorded(asked: CursorMeaning, live: CompletionSource) -> Found | Files:
    is_played = asked.options.keys() & {"-p", "-d"} and asked.command == "rtlog"
    return (_IN_PORTS if is_played else _OUT_PORTS)(asked, live)


def _operation(asked: CursorMeaning, live: CompletionSource) -> Found:
    """Return components with service ports, or the operations of the one that stands there."""
    head, colon, typed = asked.typed.rpartition(":")
    if not colon:
        found = paths(
            live, asked.typed, WantedPath(with_row(lambda row: bool(row.services)), has_port=True)
        )
        head, typed = found[0].text.rpartition(":")[0] if found else "", ""
        if not all(each.text.startswith(f"{head}:") and each.text[-1] != ":" for each in found):
            return found
    from rtkit.rtc.profiles import DEFINITION, operations_in

    node = live.component(head) if head else None
    return [
        candidate
        for port in (live.ports(node.row.instance) if node is not None and node.row else ())
        if any(each["polarity"] == "Provided" for each in port.get("interfaces", ()))
        for name, text in operations_in(port.get("properties", {}).get(DEFINITION, ""))
        for candidate in those([f"{head}:{port['name']}.{name}"], f"{head}:{typed}", text)
    ]


def _fitting(asked: CursorMeaning, live: CompletionSource) -> Found:
    from rtkit.cli.completion.fitting import fits, is_fit

    first = _end(asked.arguments[0], live)
    if first is None:
        return paths(live, asked.typed, _PORT)
    instance, name = first
    port = next((each for each in live.ports(instance) if each["name"] == name), None)
    if port is None:
        return paths(live, asked.typed, _PORT)
    fit = fits(live.snapshot["components"], instance, port)
    wanted = WantedPath(
        with_row(lambda row: row.instance in fit),
        has_port=True,
        port_fits=lambda other, each: other in fit and is_fit(port, each),
    )
    return paths(live, asked.typed, wanted)


def _end(typed: str, live: CompletionSource) -> tuple[str, str | None] | None:
    """Return the component at a path, and the port that it names."""
    node = live.component(typed)
    if node is None or node.row is None:
        return None
    return node.row.instance, parse_path(typed, working_directory()).port


def _connected_to(asked: CursorMeaning, live: CompletionSource) -> Found:
    first = _end(asked.arguments[0], live)
    if first is None:
        return ()
    ends = {
        (end["instance"], end["port"])
        for connector in instances_of(live.snapshot["connectors"], *first)
        for end in connector["ports"]
        if end["instance"] != first[0]
    }
    names = {instance for instance, _ in ends}
    wanted = WantedPath(
        with_row(lambda row: row.instance in names),
        has_port=True,
        port_fits=lambda instance, port: (instance, port["name"]) in ends,
    )
    return paths(live, asked.typed, wanted)


def _connected(asked: CursorMeaning, live: CompletionSource) -> Found:
    wanted = WantedPath(
        with_row(lambda row: bool(row.ins_connected + row.outs_connected + row.services_connected)),
        has_port=None,
        port_fits=lambda instance, port: bool(
            instances_of(live.part(instance)["connectors"], instance, port["name"])
        ),
    )
    return paths(live, asked.typed, wanted)


def _connectors(asked: CursorMeaning, live: CompletionSource) -> Found:
    ends = [_end(each, live) for each in asked.arguments[:1]]
    connectors = live.snapshot["connectors"]
    for end in filter(None, ends):
        connectors = instances_of(connectors, *end)
    return [
        Candidate(
            connector["connector_id"],
            " ".join(f"{p['instance']}.{p['port']}" for p in connector["ports"]),
        )
        for connector in connectors
        if connector["connector_id"].startswith(asked.typed)
    ]


def _words(asked: CursorMeaning, _live: CompletionSource) -> list[Candidate]:
    return [each for each in asked.words if each.text.startswith(asked.typed)]


def _manager_or_word(asked: CursorMeaning, live: CompletionSource) -> Found:
    words = _words(asked, live)
    if words and asked.typed:
        return words
    return [*words, *_or_none(lambda: paths(live, asked.typed, WantedPath(_is_manager)))]


def _or_none(look: Callable[[], Found]) -> Found:
    """Return the candidates of `look`, or none where the manager does not answer."""
    from rtkit.errors import RtkitError

    try:
        return list(look())
    except RtkitError:
        return ()


def _manager_names(asked: CursorMeaning, live: CompletionSource) -> Found | Files:
    from rtkit.link.running import managers

    if asked.arguments[:1] == ("replay",):
        return Files((".dump",))
    return those(managers(), asked.typed)


def _waited_for(asked: CursorMeaning, live: CompletionSource) -> Found:
    words = _words(asked, live) if asked.arguments else ()
    wanted = WantedPath(living, has_port=None)
    return [*words, *_or_none(lambda: paths(live, asked.typed, wanted))]


def _hosts(asked: CursorMeaning, live: CompletionSource) -> Found:
    root = live.folder("/")
    return those(root.children if root is not None else (), asked.typed)


def _sets(asked: CursorMeaning, live: CompletionSource) -> Found:
    sets = _facts(asked, live).get("sets", {})
    return those((each for each in sets if not each.startswith("__")), asked.typed)


def _facts(asked: CursorMeaning, live: CompletionSource) -> dict[str, dict[str, dict[str, str]]]:
    node = live.component(asked.arguments[0]) if asked.arguments else None
    return live.facts(node.row.instance) if node is not None and node.row is not None else {}


def _conf(asked: CursorMeaning, live: CompletionSource) -> Found | Files:
    verb, count = asked.arguments[1], len(asked.arguments)
    if verb in ("copy", "remove") and count == 2:
        return _sets(asked, live)
    if (verb == "add" and count > 2) or (verb == "copy" and count > 3):
        verb, count = "set", 2  # what follows is as for set: PARAM=VALUE
    if verb == "diff" and count == 2:
        return [*_sets(asked, live)] or Files((".json",))
    if verb in ("import", "export") and count == 2:
        return Files((".json",))
    if verb not in ("get", "set") or (verb == "get" and count > 2):
        return ()
    values = _parameters(asked, live)
    name, equals, start = asked.typed.partition("=")
    if verb == "set" and equals:
        return those([f"{name}={values.get(name, '')}"], f"{name}={start}", "as it is")
    if verb == "set" and count == 3 and "=" not in asked.arguments[2]:
        return those([values.get(asked.arguments[2], "")], asked.typed, "as it is")
    end = "=" if verb == "set" else ""
    return [Candidate(f"{each}{end}", values[each]) for each in values if each.startswith(name)]


def _parameters(asked: CursorMeaning, live: CompletionSource) -> dict[str, str]:
    node = live.component(asked.arguments[0])
    if node is not None and node.kind is NodeKind.MANAGER:
        return dict(live.part()["properties"])
    facts = _facts(asked, live)
    name = asked.options.get("-s") or str(facts.get("active_set", ""))
    return facts.get("sets", {}).get(name, {})


def _types(asked: CursorMeaning, live: CompletionSource) -> Found:
    offered = live.tree().get("get_loadable_modules").splitlines()
    kinds = [line.partition("?")[0].split(":") for line in offered]
    loaded = (each for module in live.part()["modules"] for each in module.get("types", ()))
    names = [*(each[3] for each in kinds if len(each) > 3), *(each["type_name"] for each in loaded)]
    return those(sorted(names), asked.typed)


def _data_types(asked: CursorMeaning, live: CompletionSource) -> Found:
    """Return names of data types; without their module where one begins as typed only so."""
    from rtkit.component.standard import SCOPES, names_of
    from rtkit.rtc.data_types import scoped_name

    names = [f"{scope}::{name}" for scope in SCOPES for name in names_of(scope)]
    ports = (port for each in _components(live) for port in each.get("ports", ()))
    live_names = (
        scoped_name(port.get("properties", {}).get("dataport.data_type", "")) for port in ports
    )
    names = [*dict.fromkeys([*filter(None, live_names), *names])]
    return those(names, asked.typed) or those(
        (name.rpartition("::")[2] for name in names), asked.typed
    )


def _components(live: CompletionSource) -> list[dict[str, Any]]:
    """Return the components that live, none where the manager does not answer."""
    from rtkit.errors import RtkitError

    try:
        return list(live.snapshot["components"])
    except RtkitError:
        return []


def _settings(asked: CursorMeaning, _live: CompletionSource) -> Found:
    from rtkit.settings.layer_file import SETTINGS

    return those((each.key for each in SETTINGS), asked.typed)


def _live(asked: CursorMeaning, live: CompletionSource) -> Found:
    from rtkit.cli.completion.properties import targets

    return targets(asked.typed, live)


def _value(asked: CursorMeaning, live: CompletionSource) -> Found:
    from rtkit.cli.completion.properties import values

    return values(asked.arguments[0], asked.typed, live.timeout_s)


def _loadable(asked: CursorMeaning, _live: CompletionSource) -> Found | Files:
    """Return the modules of installed packages that are meant, else files."""
    from rtkit.modules.search import installed

    known = installed().values() if asked.typed and "/" not in asked.typed else ()
    names = dict.fromkeys(f"{each.name}:{each.init}" for each in known)
    return [*those(names, asked.typed)] or Files((".py", ".so"))


def _classes(asked: CursorMeaning, _live: CompletionSource) -> Found | Files:
    """Return the definitions of a file whose name is typed up to the colon, else files."""
    path, colon, _ = asked.typed.rpartition(":")
    if not colon and os.path.isfile(os.path.expanduser(asked.typed)):
        path = asked.typed
    elif not colon:
        return Files((".py",))
    import ast

    try:
        with open(os.path.expanduser(path), encoding="utf-8") as file:
            tree = ast.parse(file.read())
    except (OSError, ValueError, SyntaxError):
        return ()
    kinds = (ast.ClassDef, ast.FunctionDef)
    names = (each.name for each in tree.body if isinstance(each, kinds))
    return those((f"{path}:{each}" for each in names if each[0] != "_"), asked.typed)


def _profile_values(asked: CursorMeaning, _live: CompletionSource) -> Found:
    """Return variables and parameters of the system profile before the cursor."""
    from rtkit.errors import RtkitError
    from rtkit.profile.parameters.reading import read_system
    from rtkit.profile.read import read_bytes, read_rts

    found: list[str] = []
    for file in filter(os.path.isfile, asked.arguments):
        try:
            data = read_bytes(file)
            plain = read_rts(data, file).profile
            found += (f"{each.name}=" for each in plain.variables)
            components = read_system(data, file).profile.components
        except RtkitError:
            continue  # the command itself tells what is wrong with it
        for each in components:
            sets = (s for s in each.configuration_sets if not s.id.startswith("__"))
            found += (f"{each.instance_name}.{d.name}=" for s in sets for d in s.data)
    return those(found, asked.typed)


def _keys(file: str) -> Maker:
    """Return what offers the keys of a file of the example of Bug navigation."""

    def make(asked: CursorMeaning, _live: CompletionSource) -> Found:
        import json

        from rtkit.resources import resource

        with open(resource("examples", "bug", file), encoding="utf-8") as stream:
            return those(json.load(stream), asked.typed)

    return make


_PORT = WantedPath(with_row(lambda row: bool(row.ins + row.outs + row.services)), has_port=True)
_IN_PORTS = _ports("DataInPort", lambda row: row.ins)
_OUT_PORTS = _ports("DataOutPort", lambda row: row.outs)
_MAKERS: dict[str, Maker] = {
    "active": _changeable("Active"),
    "anything": _all(WantedPath(lambda node: not node.is_directory, takes_folders=True)),
    "anything:": _all(WantedPath(lambda node: not node.is_directory, True, None)),
    "bug-sensors": lambda asked, _: those(("laser", "ir", "laser+ir", "bumper"), asked.typed),
    "bug-side": lambda asked, _: those(("left", "right"), asked.typed),
    "bug-variant": _keys("variants.json"),
    "bug-world": _keys("worlds.json"),
    "class": _classes,
    "component": _all(WantedPath(living)),
    "component:": _all(WantedPath(living, has_port=None)),
    "component-or-system": lambda asked, _: (
        those(("component", "system"), asked.typed) if not asked.arguments else ()
    ),
    "component|manager": _all(WantedPath(lambda node: living(node) or _is_manager(node))),
    "component|slave": _all(WantedPath(lambda node: living(node) or node.is_slave)),
    "composite-type": lambda asked, _: those(_COMPOSITES, asked.typed),
    "conf": _conf,
    "connected": _connected,
    "connected-to": _connected_to,
    "connector": _connectors,
    "connector-property": lambda asked, _: those(_CONNECTOR_PROPERTIES, asked.typed),
    "context": lambda asked, _: those(("all",), asked.typed),
    "data-type": _data_types,
    "deletable": _deletable,
    "directory": _all(WantedPath(lambda _: False, takes_folders=True)),
    "faulty": _changeable("Error"),
    "file": lambda _asked, _live: Files(),
    "fitting": _fitting,
    "folder": lambda _asked, _live: Files(is_folder=True),
    "host": _hosts,
    "in-port": _IN_PORTS,
    "inactive": _changeable("Inactive"),
    "instance": lambda asked, live: those(
        (row.instance for row in live.tree().listing().rows), asked.typed
    ),
    "installed-package": _installed_packages,
    "known-host": _known_hosts,
    "live": _live,
    "loaded-module": lambda asked, live: those(
        (each["path"] for each in live.part()["modules"]), asked.typed
    ),
    "manager|slave": _all(WantedPath(lambda node: _is_manager(node) or node.is_slave)),
    "manager": _all(WantedPath(_is_manager)),
    "manager-name": _manager_names,
    "manager|component": _all(WantedPath(lambda node: living(node) or _is_manager(node))),
    "manager|word": _manager_or_word,
    "module": _loadable,
    "operation": _operation,
    "out-port": _recorded,
    "port": _all(_PORT),
    "parameter": _profile_values,
    "profile": lambda _asked, _live: PROFILES,
    "property": lambda asked, live: those(
        (f"{key}=" for key in live.part()["properties"]), asked.typed
    ),
    "set": _sets,
    "setting": _settings,
    "type": _types,
    "value": _value,
    "waited-for": _waited_for,
}
KINDS = frozenset((*_MAKERS, "option", "words", ""))
