"""What may stand for each kind of word: paths of the tree and names that the manager knows."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterable

from rtkit.cli._app import working_directory
from rtkit.cli.prompt.candidates import Candidate, Files, those
from rtkit.cli.prompt.grammar import Asked
from rtkit.cli.prompt.live import Live, instances_of
from rtkit.cli.prompt.places import Wanted, in_state, living, paths, with_row
from rtkit.rtc.names import parse_path
from rtkit.tree.view import Kind, Node

Found = Iterable[Candidate]
Maker = Callable[[Asked, Live], "Found | Files"]
PROFILES = Files((".xml", ".yaml", ".yml", ".json"))
_IN, _OUT = "DataInPort", "DataOutPort"
_CONNECTOR_PROPERTIES = (
    "dataport.dataflow_type=",
    "dataport.interface_type=",
    "dataport.push_policy=",
    "dataport.push_rate=",
    "dataport.subscription_type=",
)
_COMPOSITES = ("PeriodicECSharedComposite", "PeriodicStateSharedComposite", "GroupingComposite")


def found(asked: Asked, live: Live) -> Found | Files:
    """Return what may stand at the cursor."""
    if asked.kind in ("option", "words"):
        return [each for each in asked.words if each.text.startswith(asked.typed)]
    maker = _MAKERS.get(asked.kind)
    return maker(asked, live) if maker is not None else ()


def _all(wanted: Wanted) -> Maker:
    return lambda asked, live: paths(live, asked.typed, wanted)


def _is_manager(node: Node) -> bool:
    return node.kind is Kind.MANAGER


def _is_slave(node: Node) -> bool:
    return node.is_slave


def _deletable(asked: Asked, live: Live) -> Found:
    if "-z" in asked.options:
        return paths(live, asked.typed, Wanted(lambda node: node.kind is Kind.ZOMBIE))
    return paths(live, asked.typed, Wanted(lambda _: True, takes_folders=True))


def _changeable(state: str) -> Maker:
    """Return components in a state; with a context named, all: the tree tells the merged state."""

    def make(asked: Asked, live: Live) -> Found:
        is_named = "-e" in asked.options
        again = [each for each in asked.arguments if each != asked.typed]
        told = paths(live, asked.typed, Wanted(living if is_named else in_state(state)))
        return [each for each in told if each.text not in again]

    return make


def _in_port(asked: Asked, live: Live) -> Found:
    wanted = Wanted(
        with_row(lambda row: bool(row.ins)),
        has_port=True,
        port_fits=lambda _, port: port["port_type"] == _IN,
    )
    return paths(live, asked.typed, wanted)


def _out_port(asked: Asked, live: Live) -> Found | Files:
    if asked.options.keys() & {"-p", "-d"} and asked.command == "rtlog":
        return _in_port(asked, live)
    wanted = Wanted(
        with_row(lambda row: bool(row.outs)),
        has_port=True,
        port_fits=lambda _, port: port["port_type"] == _OUT,
    )
    return paths(live, asked.typed, wanted)


def _fitting(asked: Asked, live: Live) -> Found:
    from rtkit.cli.prompt.fitting import fits, is_fit

    first = _end(asked.arguments[0], live)
    if first is None:
        return paths(live, asked.typed, _PORT)
    instance, name = first
    port = next((each for each in live.ports(instance) if each["name"] == name), None)
    if port is None:
        return paths(live, asked.typed, _PORT)
    fit = fits(live.snapshot["components"], instance, port)
    wanted = Wanted(
        with_row(lambda row: row.instance in fit),
        has_port=True,
        port_fits=lambda other, each: other in fit and is_fit(port, each),
    )
    return paths(live, asked.typed, wanted)


def _end(typed: str, live: Live) -> tuple[str, str | None] | None:
    """Return the component at a path, and the port that it names."""
    node = live.component(typed)
    if node is None or node.row is None:
        return None
    return node.row.instance, parse_path(typed, working_directory()).port


def _connected_to(asked: Asked, live: Live) -> Found:
    first = _end(asked.arguments[0], live)
    if first is None:
        return ()
    ends = {
        (end["instance"], end["port"])
        for wire in instances_of(live.snapshot["connectors"], *first)
        for end in wire["ports"]
        if end["instance"] != first[0]
    }
    names = {instance for instance, _ in ends}
    wanted = Wanted(
        with_row(lambda row: row.instance in names),
        has_port=True,
        port_fits=lambda instance, port: (instance, port["name"]) in ends,
    )
    return paths(live, asked.typed, wanted)


def _connected(asked: Asked, live: Live) -> Found:
    wanted = Wanted(
        with_row(lambda row: bool(row.ins_connected + row.outs_connected + row.services_connected)),
        has_port=None,
        port_fits=lambda instance, port: bool(
            instances_of(live.part(instance)["connectors"], instance, port["name"])
        ),
    )
    return paths(live, asked.typed, wanted)


def _connectors(asked: Asked, live: Live) -> Found:
    ends = [_end(each, live) for each in asked.arguments[:1]]
    wires = live.snapshot["connectors"]
    for end in filter(None, ends):
        wires = instances_of(wires, *end)
    return [
        Candidate(
            wire["connector_id"], " ".join(f"{p['instance']}.{p['port']}" for p in wire["ports"])
        )
        for wire in wires
        if wire["connector_id"].startswith(asked.typed)
    ]


def _words(asked: Asked, live: Live) -> Found:
    module = importlib.import_module(f"rtkit.cli.{asked.command}")
    return those(getattr(module, "FORMS", None) or module.WORDS, asked.typed)


def _manager_or_word(asked: Asked, live: Live) -> Found:
    words = list(_words(asked, live))
    if words and asked.typed:
        return words
    return [*words, *_or_none(lambda: paths(live, asked.typed, Wanted(_is_manager)))]


def _or_none(look: Callable[[], Found]) -> Found:
    """Return what can be seen: words that need no manager are there without one, too."""
    from rtkit.errors import RtkitError

    try:
        return list(look())
    except RtkitError:
        return ()


def _manager_names(asked: Asked, live: Live) -> Found:
    from rtkit.link.running import managers

    return those(managers(), asked.typed)


def _waited_for(asked: Asked, live: Live) -> Found:
    words = _words(asked, live) if asked.arguments else ()
    wanted = Wanted(living, has_port=None)
    return [*words, *_or_none(lambda: paths(live, asked.typed, wanted))]


def _hosts(asked: Asked, live: Live) -> Found:
    root = live.folder("/")
    return those(root.children if root is not None else (), asked.typed)


def _sets(asked: Asked, live: Live) -> Found:
    sets = _facts(asked, live).get("sets", {})
    return those((each for each in sets if not each.startswith("__")), asked.typed)


def _facts(asked: Asked, live: Live) -> dict[str, dict[str, dict[str, str]]]:
    node = live.component(asked.arguments[0]) if asked.arguments else None
    return live.facts(node.row.instance) if node is not None and node.row is not None else {}


def _conf(asked: Asked, live: Live) -> Found | Files:
    verb, count = asked.arguments[1], len(asked.arguments)
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


def _parameters(asked: Asked, live: Live) -> dict[str, str]:
    node = live.component(asked.arguments[0])
    if node is not None and node.kind is Kind.MANAGER:
        return dict(live.part()["properties"])
    facts = _facts(asked, live)
    name = asked.options.get("-s") or str(facts.get("active_set", ""))
    return facts.get("sets", {}).get(name, {})


def _types(asked: Asked, live: Live) -> Found:
    offered = live.tree().get("get_loadable_modules").splitlines()
    kinds = [line.partition("?")[0].split(":") for line in offered]
    loaded = (each for module in live.part()["modules"] for each in module.get("types", ()))
    names = [*(each[3] for each in kinds if len(each) > 3), *(each["type_name"] for each in loaded)]
    return those(sorted(names), asked.typed)


def _modules(asked: Asked, live: Live) -> Found:
    return those((each["path"] for each in live.part()["modules"]), asked.typed)


def _properties(asked: Asked, live: Live) -> Found:
    return those((f"{key}=" for key in live.part()["properties"]), asked.typed)


def _instances(asked: Asked, live: Live) -> Found:
    return those((row.instance for row in live.tree().listing().rows), asked.typed)


def _live(asked: Asked, live: Live) -> Found:
    from rtkit.cli.prompt.properties import targets

    return targets(asked.typed, live)


def _value(asked: Asked, live: Live) -> Found:
    from rtkit.cli.prompt.properties import values

    return values(asked.arguments[0], asked.typed, live.timeout_s)


def _classes(asked: Asked, _live: Live) -> Found | Files:
    """Return what a file defines of which the name is typed up to the colon, else files."""
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


_PORT = Wanted(with_row(lambda row: bool(row.ins + row.outs + row.services)), has_port=True)
_MAKERS: dict[str, Maker] = {
    "active": _changeable("Active"),
    "anything": _all(Wanted(lambda node: not node.is_directory, takes_folders=True)),
    "anything:": _all(Wanted(lambda node: not node.is_directory, True, None)),
    "class": _classes,
    "component": _all(Wanted(living)),
    "component:": _all(Wanted(living, has_port=None)),
    "component-or-system": lambda asked, _: (
        those(("component", "system"), asked.typed) if not asked.arguments else ()
    ),
    "component|manager": _all(Wanted(lambda node: living(node) or _is_manager(node))),
    "component|slave": _all(Wanted(lambda node: living(node) or _is_slave(node))),
    "composite-type": lambda asked, _: those(_COMPOSITES, asked.typed),
    "conf": _conf,
    "connected": _connected,
    "connected-to": _connected_to,
    "connector": _connectors,
    "connector-property": lambda asked, _: those(_CONNECTOR_PROPERTIES, asked.typed),
    "context": lambda asked, _: those(("all",), asked.typed),
    "deletable": _deletable,
    "directory": _all(Wanted(lambda _: False, takes_folders=True)),
    "faulty": _changeable("Error"),
    "file": lambda _asked, _live: Files(),
    "fitting": _fitting,
    "folder": lambda _asked, _live: Files(is_folder=True),
    "host": _hosts,
    "in-port": _in_port,
    "inactive": _changeable("Inactive"),
    "instance": _instances,
    "live": _live,
    "loaded-module": _modules,
    "manager": _all(Wanted(_is_manager)),
    "manager-name": _manager_names,
    "manager|component": _all(Wanted(lambda node: living(node) or _is_manager(node))),
    "manager|word": _manager_or_word,
    "module": lambda _asked, _live: Files((".py", ".so")),
    "out-port": _out_port,
    "port": _all(_PORT),
    "profile": lambda _asked, _live: PROFILES,
    "property": _properties,
    "set": _sets,
    "type": _types,
    "value": _value,
    "waited-for": _waited_for,
    "word": _words,
}
KINDS = frozenset((*_MAKERS, "option", "words", ""))
