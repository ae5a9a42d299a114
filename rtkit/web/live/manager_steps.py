"""Steps that manage managers: modules, slaves, components made and ended, start and stop."""

from __future__ import annotations

from collections.abc import Sequence

from rtkit.api.live_records import Record, SystemRecords
from rtkit.errors import NotFound, Refused
from rtkit.rtc.manager_address import is_address
from rtkit.web.fields import text_in
from rtkit.web.live.steps import Action, CommandStep, component_in, found_in, listed, wires_of

_HERE = "localhost"


def load(action: Action, records: SystemRecords) -> CommandStep:
    """Load a module."""
    manager = _manager(action, records)
    path, init = text_in(action, "path"), text_in(action, "init", "")
    module = f"{path}:{init}" if init else path
    line = ("rtmgr", f"--load={module}", "--", manager)
    undo = {"do": "unload", "manager": manager, "path": path, "init": init}
    return CommandStep(f"Load {module} into {manager}", line, (undo,))


def unload(action: Action, records: SystemRecords) -> CommandStep:
    """Have a manager forget a module; what was made of it lives on."""
    manager = _manager(action, records)
    path = text_in(action, "path")
    line = ("rtmgr", f"--unload={path}", "--", manager)
    undo = {"do": "load", "manager": manager, "path": path, "init": text_in(action, "init", "")}
    return CommandStep(f"Forget the module {path} in {manager}", line, (undo,))


def create(action: Action, records: SystemRecords) -> CommandStep:
    """Create a component."""
    manager = _manager(action, records)
    wished = text_in(action, "create")
    line = ("rtmgr", f"--create={wished}", "--", manager)
    reason = "what was made is ended by its own action"
    return CommandStep(f"Create {wished} in {manager}", line, None, reason)


def delete(action: Action, records: SystemRecords) -> CommandStep:
    """End a component, or forget a zombie."""
    component = component_in(action, records)
    id = component["id"]
    if component["look"] == "zombie":
        line = ("rtdel", "-z", "--", id)
        return CommandStep(f"Forget the zombie {id}", line, None, "it was dead")
    goes = _with_wires(wires_of([id], records))
    reason = f"{component['name']} has ended"
    return CommandStep(f"End {id}{goes}", ("rtexit", "--", id), None, reason)


def forget_zombies(_action: Action, records: SystemRecords) -> CommandStep:
    """Forget all zombies of all managers."""
    dead = [id for id, each in records.components.items() if each["look"] == "zombie"]
    if not dead:
        raise NotFound("There is no zombie")
    return CommandStep(f"Forget {listed('zombie', dead)}", ("rtdel", "-z"), None, "they were dead")


def fork(action: Action, records: SystemRecords) -> CommandStep:
    """Start a slave without components."""
    manager = _manager(action, records)
    line = ("rtmgr", "--fork", "--", manager)
    reason = "the slave is ended by its own action"
    return CommandStep(f"Start a slave of {manager}", line, None, reason)


def end_slave(action: Action, records: SystemRecords) -> CommandStep:
    """End a slave with the components in it."""
    process = found_in(action, "process", records.processes, "slave")
    if not process["is_slave"]:
        raise Refused(f"{process['id']} is no slave: stop the manager")
    held = [id for id, each in records.components.items() if each["process"] == process["id"]]
    line = ("rtexit", "--", process["id"])
    text = f"End the slave {process['id']}{_goes(held, records)}"
    return CommandStep(text, line, None, "the slave has ended")


def start_manager(action: Action, _records: SystemRecords) -> CommandStep:
    """Start a manager, on this host or on a host of ``rthost list``; by default the usual one."""
    name, host = text_in(action, "name", ""), text_in(action, "host", "")
    text = f"Start the manager {name or 'of the usual name'}{f' on {host}' if host else ''}"
    undo = {"do": "stop_manager", "manager": f"/{host or _HERE}/{name}.mgr", "keep": True}
    line = ("rtmgr", *_at(host), "start", *_last(name))
    return CommandStep(text, line, (undo,) if name else None, "its name is not known before")


def stop_manager(action: Action, records: SystemRecords) -> CommandStep:
    """Stop a manager with all that it holds, which it keeps for its next start if that is asked."""
    manager = found_in(action, "manager", records.managers, "manager")
    held = [id for id, each in records.components.items() if each["manager"] == manager["id"]]
    is_kept = action.get("keep") is True
    host = _host(manager)
    kept = ("--keep",) if is_kept else ()
    line = ("rtmgr", *kept, *_command_at(host, "stop", manager["name"]))
    text = f"Stop the manager {manager['id']}{_goes(held, records)}"
    if not is_kept:
        return CommandStep(text, line, None, "it forgets what it held")
    if is_address(host):
        return CommandStep(text, line, None, "it is started on its own host only")
    undo = {"do": "start_manager", "name": manager["name"], "host": host}
    return CommandStep(f"{text}; all comes again at its next start", line, (undo,))


def restart_manager(action: Action, records: SystemRecords) -> CommandStep:
    """End all that a manager holds in order, and have it make all again."""
    manager = found_in(action, "manager", records.managers, "manager")
    host = _host(manager)
    if host and not is_address(host):
        raise Refused(f"{manager['id']} is on another host: restart it there")
    held = [id for id, each in records.components.items() if each["manager"] == manager["id"]]
    text = f"Restart the manager {manager['id']}{_goes(held, records)}; all comes again"
    line = ("rtmgr", *_command_at(host, "restart", manager["name"]))
    return CommandStep(text, line, None, "what was in work has ended")


def set_property(action: Action, records: SystemRecords) -> CommandStep:
    """Set a property of a manager."""
    manager = _manager(action, records)
    key, value = text_in(action, "key"), text_in(action, "value")
    line = ("rtmgr", f"--setconfig={key}={value}", "--", manager)
    before = action.get("before")
    again = {"do": "set_property", "manager": manager, "key": key}
    old = before if isinstance(before, str) else None
    undo = None if old is None else ({**again, "value": old, "before": value},)
    why = "its value was not known"
    text = f"Set {key} of {manager} to {value}"
    return CommandStep(text, line, undo, why, old=old, new=value)


def _manager(action: Action, records: SystemRecords) -> str:
    return str(found_in(action, "manager", records.managers, "manager")["id"])


def _last(name: str) -> tuple[str, ...]:
    return ("--", name) if name else ()


def _host(manager: Record) -> str:
    """Return the host of a manager as ``rthost`` knows it; empty for this one."""
    place = str(manager["id"]).split("/")[1]
    return "" if place == _HERE else place


def _at(host: str) -> tuple[str, ...]:
    return (f"--host={host}",) if host else ()


def _command_at(host: str, word: str, name: str) -> tuple[str, ...]:
    """Return how a command names a manager: one reached by a certificate has an address only."""
    return (word, "--", host) if is_address(host) else (*_at(host), word, *_last(name))


def _goes(held: Sequence[str], records: SystemRecords) -> str:
    """Return what goes with these components, as the end of a sentence."""
    if not held:
        return ""
    return f", and with it {listed('component', held)}{_with_wires(wires_of(held, records))}"


def _with_wires(wires: Sequence[str]) -> str:
    return f", and with it the connector from {' and that from '.join(wires)}" if wires else ""
