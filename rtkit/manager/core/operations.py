"""The operations of a manager, as properties: some are read, some are set with an argument.

Lists are lines; a record is ``ID?key=value&key=value``, tables are lines of ``key: value``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.extension import FOLLOW
from rtkit.deployment.facts import ComponentFacts
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.manager.core import fences, follows, manager_properties
from rtkit.manager.core.deletion import retire_unused
from rtkit.manager.core.effects import AcquireSlave, Procedure, Spawn
from rtkit.manager.core.halves import expect
from rtkit.manager.core.procedures import procedure_for
from rtkit.manager.core.state import ManagerState
from rtkit.rtc.create import FRESH_SLAVE
from rtkit.rtc.names import check_host_name, check_instance_name, is_local_host
from rtkit.rtc.profiles import ConnectorProfile, TypeProfile
from rtkit.rtc.serde import decode_text, parse_table

TIMEOUT_S = 10.0
"""How long an operation may take that is not part of a batch [s]."""

_PROFILE = (
    "manager.instance_name", "manager.name", "manager.pid", "manager.naming_formats",
    "manager.components.precreate", "manager.modules.load_path", "manager.modules.preload",
)  # fmt: skip
_ESCAPED = "%&=?\n"


def record(name: str, values: Mapping[str, str]) -> str:
    """Return ``NAME?key=value&…``, values with escapes, empty ones left out."""
    query = "&".join(f"{key}={_escape(value)}" for key, value in values.items() if value)
    return f"{name}?{query}" if query else name


def type_record(profile: TypeProfile) -> str:
    """Return a component type as ``RTC:vendor:category:type:language:version?description=…``."""
    return record(profile.full_id, {"description": profile.description})


def lines(table: Mapping[str, str]) -> str:
    """Return a table as ``rtc.conf`` would have it."""
    return "\n".join(f"{key}: {value}" for key, value in sorted(table.items()))


def _loaded_modules(state: ManagerState) -> str:
    return "\n".join(record(each.path, {"init": each.init}) for each in state.modules.values())


def _factory_profiles(state: ManagerState) -> str:
    types = {type_ for module in state.modules.values() for type_ in module.types}
    types.update(facts.type for facts in _living(state) if not facts.is_stand_in)
    return "\n".join(sorted(map(type_record, types)))


def _component_record(facts: ComponentFacts) -> str:
    names = ("type_name", "description", "version", "vendor", "category", "language")
    own = {"manager": facts.process, "naming.names": ",".join(facts.names)}
    return record(facts.instance, {name: getattr(facts.type, name) for name in names} | own)


def _profile(state: ManagerState) -> str:
    table = manager_properties.table(state)
    return lines({key: table[key] for key in table if key in _PROFILE or key.startswith("os.")})


def _slaves(state: ManagerState) -> str:
    own = [p.name for p in state.processes.values() if p.is_slave and p.is_ready and not p.is_trial]
    return "\n".join([*own, *state.slaves])


READ: Mapping[str, Callable[[ManagerState], str]] = {
    FOLLOW: lambda state: follows.as_json(state.kept),
    "get_loaded_modules": _loaded_modules,
    "get_factory_profiles": _factory_profiles,
    "get_components": lambda state: "\n".join(each.instance for each in _living(state)),
    "get_component_profiles": lambda state: "\n".join(map(_component_record, _living(state))),
    "get_profile": _profile,
    "get_configuration": lambda state: lines(manager_properties.table(state)),
    "is_master": lambda state: manager_properties.lookup(state, "manager.is_master") or "",
    "get_master_managers": lambda state: "\n".join(state.masters),
    "get_slave_managers": _slaves,
    "get_hosts": lambda state: "\n".join(state.kept.hosts),
    "get_fences": fences.lines,
}


def _load(state: ManagerState, argument: str) -> Procedure:
    path, _, option = argument.partition("?")
    key, _, init = option.partition("=")
    if option and key != "init":
        raise Malformed(f"not PATH?init=FUNCTION: {argument}")
    return (yield from procedure_for(act.Load(path, init), state))


def _by_name(state: ManagerState, argument: str) -> Procedure:
    """Find components by ``INSTANCE``, ``*/INSTANCE`` or ``CATEGORY/INSTANCE``."""
    yield from ()
    category, slash, instance = argument.rpartition("/")
    found = [
        each.instance
        for each in _living(state)
        if each.instance == instance and (not slash or category in ("*", each.type.category))
    ]
    return Result(value="\n".join(found))


def _fork(state: ManagerState, argument: str) -> Procedure:
    """Start another slave of equal configuration, without components."""
    if argument:
        check_instance_name(argument)
        if state.living_process(argument) is not None:
            raise Refused(f"there is a slave named {argument} already")
    process = yield AcquireSlave(argument or FRESH_SLAVE)
    yield Spawn(retire_unused(state, process))
    return Result(value=process.name)


def action(name: str, argument: str) -> act.Action:
    """Return the action that an operation is; a tick for one that is none."""
    if name == "create_component":
        return act.Create(argument)
    if name == "load_module":
        return act.Load(argument.partition("?")[0])
    return act.Tick("", "")


def _add(managers: list[str], argument: str) -> Procedure:
    yield from ()
    if argument.strip() != argument or not argument or not argument.isprintable():
        raise Malformed(f"not a manager: {argument!r}")
    if argument not in managers:
        managers.append(argument)
    return Result()


def _remove(managers: list[str], argument: str) -> Procedure:
    yield from ()
    if argument not in managers:
        raise NotFound(f"no such manager is registered: {argument}")
    managers.remove(argument)
    return Result()


def _link_host(state: ManagerState, argument: str) -> Procedure:
    """Have a link to another host, which is given as JSON.

    A host that bore the name of this one could answer for it: its link lets its own keys pass.
    """
    yield from ()
    name = check_host_name(str(parse_table(argument).get("name") or ""))
    if is_local_host(name, state.host):
        raise Refused(f"{name} is the name of this host")
    state.kept.put("host", name, argument)
    return Result(value=name)


def _unlink_host(state: ManagerState, argument: str) -> Procedure:
    yield from ()
    if argument not in state.kept.hosts:
        raise NotFound(f"no link to host {argument}")
    state.kept.drop("host", argument)
    return Result()


def _expect(state: ManagerState, argument: str) -> Procedure:
    """Let a manager of another host make a connector, which is given as JSON."""
    return (yield from expect(state, decode_text(ConnectorProfile, argument)))


def _expect_no_more(state: ManagerState, argument: str) -> Procedure:
    yield from ()
    state.expected.pop(argument, None)
    return Result()


def _own(_state: ManagerState, _argument: str) -> Procedure:
    """Have the shell look at the records of owned systems, of which one has changed."""
    yield from ()
    return Result()


def _service(_state: ManagerState, argument: str) -> Procedure:
    yield from ()
    raise NotFound(f"the manager has no service {argument}")


DO: Mapping[str, Callable[[ManagerState, str], Procedure]] = {
    "load_module": _load,
    "unload_module": lambda state, path: procedure_for(act.Unload(path), state),
    "create_component": lambda state, text: procedure_for(act.Create(text), state),
    "delete_component": lambda state, name: procedure_for(act.Delete(name), state),
    "get_components_by_name": _by_name,
    "set_configuration": manager_properties.change,
    "fork": _fork,
    "add_master_manager": lambda state, name: _add(state.masters, name),
    "remove_master_manager": lambda state, name: _remove(state.masters, name),
    "add_slave_manager": lambda state, name: _add(state.slaves, name),
    "remove_slave_manager": lambda state, name: _remove(state.slaves, name),
    "get_service": _service,
    "link_host": _link_host,
    "unlink_host": _unlink_host,
    "expect": _expect,
    "expect_no_more": _expect_no_more,
    "fence": fences.fence,
    "own": _own,
}


def _living(state: ManagerState) -> Iterable[ComponentFacts]:
    return [facts for facts in state.components.values() if not facts.zombie]


def _escape(value: str) -> str:
    return "".join(f"%{ord(c):02X}" if c in _ESCAPED else c for c in value)
