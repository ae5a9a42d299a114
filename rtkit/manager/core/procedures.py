"""Procedures of actions: generators that yield each `effects.Effect` they wait for.

A procedure that fails takes its changes back itself.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Iterable, Mapping
from typing import Any

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action, Result
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.health import read_rules
from rtkit.deployment.limits import needs_slave
from rtkit.deployment.message import Message
from rtkit.errors import Malformed, Refused, RtkitError, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.manager.core.deletion import delete, end_slave, end_slaves, grace_s, retire
from rtkit.manager.core.desired_changes import OPERATIONS, note
from rtkit.manager.core.effects import AcquireSlave, Call, Effect, Procedure, Send, Spawn
from rtkit.manager.core.events import OWN_PROCESS
from rtkit.manager.core.fences import check_home
from rtkit.manager.core.limiting import reserve
from rtkit.manager.core.manager_properties import config_files, inherited
from rtkit.manager.core.modules import forget_found, load, share_trial, unload
from rtkit.manager.core.policies import policy_of, set_policy
from rtkit.manager.core.registration import (
    at_rest,
    claim_name,
    late_names,
    names_elsewhere,
    register,
    remember,
    unregister,
)
from rtkit.manager.core.required_devices import note_made
from rtkit.manager.core.state import ManagerState, NameReservation, Process
from rtkit.manager.core.wiring import connect, cut, disconnect, living
from rtkit.rtc.create import FRESH_SLAVE, CreateString, parse_create
from rtkit.rtc.enums import Transition
from rtkit.rtc.manager_address import is_port
from rtkit.rtc.names import MANAGER_SUFFIX, check_instance_name, is_local_host
from rtkit.rtc.profiles import NOTHING
from rtkit.rtc.serde import encode
from rtkit.settings.properties import check
from rtkit.settings.values import DEFAULT_PORT


def procedure_for(action: Action, state: ManagerState) -> Procedure:
    """Do an action, and record what is desired from then on."""
    result = yield from _PROCEDURES[type(action)](state, action)
    if isinstance(action, act.Connect):  # with the ports' own names
        action = act.Connect(state.connectors.get(action.connector.connector_id, action.connector))
    if not isinstance(action, act.Disconnect):  # which has recorded it
        note(state.kept, action)
    return result


def _ask(state: ManagerState, action: Any, instance: str, **more: object) -> Procedure:
    """Have the container of a component do an action."""
    rest = {name: value for name, value in encode(action).items() if name != "owner"}
    message = {"op": OPERATIONS[type(action)], "instance": instance, **rest, **more}
    yield Call(living(state, instance), message)
    return Result()


def _pass_on(state: ManagerState, action: Any) -> Procedure:
    return _ask(state, action, action.instance)


def _share(state: ManagerState, action: act.Attach | act.Detach) -> Procedure:
    """Attach a component to a context of another, or detach it."""
    owner, participant = living(state, action.owner), living(state, action.participant)
    if owner is not participant:
        raise Refused(
            f"{action.participant} is in {participant.name}, {action.owner} in {owner.name}:"
            " an execution context drives components of its own process only"
        )
    return (yield from _ask(state, action, action.owner))


def _set_context(state: ManagerState, action: act.SetContext) -> Procedure:
    """Change settings of a context, and with them the create string that tells them."""
    instance = action.instance
    yield from _ask(state, action, instance)
    facts = state.components[instance]
    if facts.create:
        stated = {f"ec.{action.context}.{key}": text for key, text in action.settings.items()}
        create = str(parse_create(facts.create).with_options(**stated))
        state.update(instance, create=create)
        state.kept.change(instance, create=create)
    return (yield from remember(state, instance))


def _configure(state: ManagerState, action: act.SetParameters | act.ActivateSet) -> Procedure:
    """Change settings; those that a component does not take over in time are as they were."""
    instance, set_id = action.instance, action.set_id
    process, facts = living(state, instance), state.components[instance]
    present = facts.sets.get(set_id, NOTHING)
    values = dict(action.values) if isinstance(action, act.SetParameters) else {}
    try:
        return (yield from _ask(state, action, instance, values=values))
    except Unreachable:
        if process.is_ready:
            before = {name: present[name] for name in values if name in present}
            back = {"op": "set_back", "instance": instance, "set_id": set_id, "values": values}
            was = {"before": before, "active_set": facts.active_set}
            yield Send(process, {**back, **was, "is_added": set_id not in facts.sets})
        raise


# components


def _create(state: ManagerState, action: act.Create) -> Procedure:
    create = parse_create(action.create)
    yield from at_rest(state, create.instance_name)
    known = state.components.get(create.instance_name)
    if known is not None and not known.zombie:
        return Result(value=known.instance, note=_otherwise(state, action, create, known))
    create = _in_language(state, create)
    check_home(state, create.instance_name)
    policy_of(state, str(create))  # a policy that makes no sense is refused before anything is done
    taken = yield from names_elsewhere(state, create)
    instance, claim = claim_name(state, action, create, taken)
    known = state.components.get(instance)
    try:
        reserve(state, instance, str(create))
        process = yield from _place(state, claim, create)
        if process.key == OWN_PROCESS and instance in state.limits:
            raise Refused(needs_slave(instance))
        claim.key = process.key
        named = create.with_options(instance_name=instance)
        made, note = yield from _make(state, process, action, named)
        _check_strict(action, note)
        names = claim.names
        if claim.is_by_template:
            names = (*names, *late_names(state, create, instance))
    except RtkitError as error:
        state.release(instance)
        yield Spawn(_unmake(state, claim, instance, known))
        if isinstance(error, Unreachable):
            raise _consequence(state, claim, instance, error) from error
        raise
    finally:
        state.release(instance)
    process.found.clear()
    state.update(instance, create=str(made), process=process.name, names=names)
    left_out = _enter(state, action, instance, str(made), is_renewed=known is not None)
    if read_rules(made.options):
        state.ruled.add(instance)
    note_made(state, instance, str(made))
    if names != claim.names:
        yield from remember(state, instance)
    return Result(value=instance, note=note, left_out=left_out)


def _enter(
    state: ManagerState, action: act.Create, instance: str, made: str, *, is_renewed: bool
) -> str:
    """Note that a component is desired; return what it lacks of one whose place it takes."""
    before, is_revived = state.watched(instance), instance in state.kept.revived
    note = _lacking(state, instance) if is_renewed and not is_revived else ""
    state.kept.made(instance, made, state.components[instance].names, action.pattern)
    if is_revived and before.pending:
        state.watch(instance, restarts=before.restarts + 1, why=before.pending)
    elif not is_revived and before.restarts:  # by a user: no restart, and all is forgiven
        state.watch(instance, restarts=before.restarts, why=before.why, took_s=before.took_s)
    state.report_restart_status(instance)
    return note


def _lacking(state: ManagerState, instance: str) -> str:
    """Report what depended on a component that has died, and is not restarted with a new one."""
    kept = state.kept
    connectors = list(kept.wires.keys_with(instance))
    desired = kept.components.get(instance)
    lost = [f"connections {', '.join(connectors)}"] if connectors else []
    if desired is not None and (desired.sets or desired.active_set):
        lost.append("values that were set")
    if not lost:
        return ""
    again = "rtapply or rtresurrect of a system makes them again"
    return f"{instance} is new, and without what the one that died had: {'; '.join(lost)} ({again})"


def _otherwise(
    state: ManagerState, action: act.Create, create: CreateString, known: ComponentFacts
) -> str:
    """Report that a component that exists already is not where it was asked for.

    Raises:
        Refused: It is of another type than was asked for.
    """
    pattern = action.pattern
    asked = pattern.type.type_name if pattern else create.implementation_id
    if known.type.type_name != asked:
        raise Refused(f"{known.instance} exists already, as {known.type.type_name}")
    place = create.place or _slave_at(state, create.address)
    if place in ("", known.process):
        return ""
    note = f"{known.instance} exists already, in {known.process}: nothing was made"
    _check_strict(action, note)
    return note


def _check_strict(action: act.Create, note: str) -> None:
    """Refuse what there is a note on, if that is too much."""
    if action.is_strict and note:
        raise Refused(note)


def _in_language(state: ManagerState, create: CreateString) -> CreateString:
    """Return what is asked for in the language of the option ``language``, if it is given.

    Raises:
        Refused: No manager here makes components in it.
    """
    asked = create.options.get("language", "")
    if not asked:
        return create
    supported = state.settings.items("manager.supported_languages")
    found = next((each for each in supported if each.lower() == asked.lower()), None)
    if found is None:
        raise Refused(f"language {asked} is not supported (supported: {', '.join(supported)})")
    return create if create.language else replace(create, language=found)


def _place(
    state: ManagerState, claim: NameReservation, create: CreateString
) -> Generator[AcquireSlave, Any, Process]:
    home = _process_of_members(state, create)
    if home is not None:
        return home
    name = create.place or _slave_at(state, create.address)
    if name in ("", state.name):
        return state.processes[OWN_PROCESS]
    if name != FRESH_SLAVE:
        check_instance_name(name)
    known = None if name == FRESH_SLAVE else state.living_process(name)
    claim.is_in_new_slave = known is None or known.state == "starting"
    process: Process = yield AcquireSlave(name)
    return process


def slaves_of(actions: Iterable[Action]) -> list[str]:
    """Return the named slaves in which these actions make components; none if it is but one."""
    names: dict[str, None] = {}
    for action in actions:
        if isinstance(action, act.Create):
            with contextlib.suppress(Malformed):
                place = parse_create(action.create).place
                if place not in ("", FRESH_SLAVE):
                    names[check_instance_name(place)] = None
    return list(names) if len(names) > 1 else []


def _slave_at(state: ManagerState, address: str) -> str:
    """Return the slave that stands for ``host:port``; port 2810 is the manager itself."""
    if not address:
        return ""
    host, _, port = address.rpartition(":")
    if not host or not is_port(port):
        raise Malformed(f"manager address is not host:port: {address}")
    if not is_local_host(host, state.host):
        raise Unreachable(f"no manager is known on host {host}: {address}")
    return "" if int(port) in (DEFAULT_PORT, state.port) else f"{state.name}_{int(port)}"


def _make(
    state: ManagerState, process: Process, action: act.Create, create: CreateString
) -> Generator[Effect, Any, tuple[CreateString, str]]:
    """Have a process make a component; return the create string for it, and what is odd."""
    instance = create.instance_name
    is_fresh = create.place == FRESH_SLAVE
    again = create.with_options(manager_name=process.name) if is_fresh else create
    message = {
        "op": "create",
        "create": str(create),
        "pattern": encode(action.pattern) if action.pattern is not None else None,
        "modules": _modules_for(state, create),
        "inherited": inherited(state),
        "config_files": config_files(state),
        "given": state.settings.of_components(),
        "kept": {"names": list(state.claims[instance].names), "create": str(again)},
    }
    if process.key == OWN_PROCESS:
        report = yield from _make_here(state, process, message)
    else:
        report = yield Call(process, message)
    facts = state.components.get(instance)
    if facts is None or facts.zombie:
        raise Refused(f"{instance} ended while it was made")
    return again, _oddities(report, instance, process)


def _oddities(report: object, instance: str, process: Process) -> str:
    """Return what is odd in a component that was made: its options, code that was edited since."""
    if not isinstance(report, dict):
        return ""
    found = [str(each) for each in report.get("remarks") or ()]
    path = report.get("changed")
    if path:
        what = f"{instance} is made of {path} as {process.name} had loaded it"
        way_out = f"rtmgr -u {path} lets the next one have the new code"
        found.append(f"{what}, which has changed since ({way_out})")
    return "; ".join(found)


def _make_here(
    state: ManagerState, own: Process, message: Message
) -> Generator[Effect, Any, object]:
    """Have the manager's own process make a component, once others have tried its modules."""
    while True:
        report = yield Call(own, {**message, "tried": dict(state.tried)})
        if not isinstance(report, dict) or "untried" not in report:
            return report
        yield from share_trial(state, str(report["untried"]), str(report["init"]))


def _modules_for(state: ManagerState, create: CreateString) -> list[list[str]]:
    """Return the modules that offer a type, and those that offer none but do something else."""
    return [
        [module.path, module.init]
        for module in state.modules.values()
        if not module.types
        or any(each.type_name == create.implementation_id for each in module.types)
    ]


def _unmake(
    state: ManagerState, claim: NameReservation, instance: str, before: ComponentFacts | None
) -> Procedure:
    """Leave nothing of a component that could not be made; a zombie stays the zombie it was.

    A slave that was started for it ends too, one that was there before does not.
    """
    process = state.processes.get(claim.key)
    if state.components.get(instance) is not before:
        for connector in state.connectors_of(instance):
            yield from cut(state, connector)
        state.forget(instance)
    if process is not None and process.is_ready:
        yield Send(process, {"op": "delete", "instance": instance})
        if claim.is_in_new_slave and not state.is_needed(process.key):
            yield from end_slaves([process], grace_s(state))
        else:
            yield from retire(state, process)
    if process is not None:
        forget_found(state, process)
    return Result()


def _consequence(
    state: ManagerState, claim: NameReservation, instance: str, error: Unreachable
) -> Unreachable:
    """Return an error with what becomes of the process in which a component hangs at its making."""
    process = state.processes.get(claim.key)
    if process is None or not process.is_alive or instance not in process.stuck:
        return error
    if claim.is_in_new_slave and not state.is_needed(process.key):
        return Unreachable(f"{error}; slave {process.name}, started for it, is ended")
    if process.key == OWN_PROCESS:
        whose, end = "the manager's own process", "only rtmgr restart or rtmgr stop ends it"
    else:
        path = f"/{state.names[0]}/{process.name}{MANAGER_SUFFIX}" if state.names else process.name
        whose, end = f"slave {process.name}", f"rtexit --force {path} ends it"
    return Unreachable(f"{error}; {whose} makes and ends nothing else until that returns; {end}")


def _process_of_members(state: ManagerState, create: CreateString) -> Process | None:
    """Return the process of the members that a create string names, None if it names none.

    Raises:
        NotFound: There is no such component.
        Refused: They are in different processes, or it is to be made in another one.
    """
    names = [name.strip() for name in create.options.get("members", "").split(",")]
    processes = {name: living(state, name) for name in names if name}
    if not processes:
        return None
    first, home = next(iter(processes.items()))
    for name, process in processes.items():
        if process is not home:
            raise Refused(
                f"{first} is in {home.name}, {name} in {process.name}:"
                " members of a composite are in one process"
            )
    if create.place not in ("", home.name):
        raise Refused(f"{first} is in {home.name}: a composite of it cannot be in {create.place}")
    return home


_WORD = {
    Transition.ACTIVATE: "activation",
    Transition.DEACTIVATE: "deactivation",
    Transition.RESET: "reset",
}


def change_state(state: ManagerState, action: act.ChangeState) -> Procedure:
    """Activate, deactivate or reset a component.

    Raises:
        Malformed: A property of the component that bounds it cannot be read.
    """
    process = living(state, action.instance)
    word = _WORD[action.transition]
    is_sync = _option(state, action.instance, f"exec_cxt.sync_{word}", "exec_cxt.sync_transition")
    bound = _option(
        state, action.instance, f"exec_cxt.{word}_timeout", "exec_cxt.transition_timeout"
    )
    message = {
        "op": "change_state",
        "context": action.context,
        "transition": action.transition.value,
        "wait": action.wait and is_sync != "NO",
        "instance": action.instance,
        **({"drains_s": action.drains_s} if action.drains_s else {}),
    }
    _forgive(state, action)
    answer = yield Call(process, message, float(bound or 0))
    return Result(note=answer if isinstance(answer, str) else "")


def _forgive(state: ManagerState, action: act.ChangeState) -> None:
    """Begin anew with a component that its user resets, or activates after it was stopped."""
    watched = state.kept.watched.get(action.instance)
    if watched is None:
        return
    if action.transition is Transition.RESET:
        state.kept.put("watched", action.instance, watched.record)
    elif action.transition is Transition.ACTIVATE:
        state.kept.watch(action.instance, rested="", halted="")
    state.report_restart_status(action.instance)


def _option(state: ManagerState, instance: str, *keys: str) -> str:
    """Return the first of these properties that component or manager was given."""
    create = state.components[instance].create
    own = parse_create(create).options if create else {}
    for key in keys:
        value = check(key, own.get(key, "")) or (
            state.settings.text(key) if state.settings.is_given(key) else ""
        )
        if value:
            return value
    return ""


_PROCEDURES: Mapping[type[Action], Callable[[ManagerState, Any], Procedure]] = {
    act.Load: load,
    act.Unload: unload,
    act.Create: _create,
    act.Delete: delete,
    act.EndSlave: end_slave,
    act.Unregister: unregister,
    act.Register: register,
    act.Connect: connect,
    act.Disconnect: disconnect,
    act.SetParameters: _configure,
    act.ActivateSet: _configure,
    act.RemoveSet: _pass_on,
    act.ChangeState: change_state,
    act.SetRate: _pass_on,
    act.SetContext: _set_context,
    act.Tick: _pass_on,
    act.SetStructure: _pass_on,
    act.SetEventProfiles: _pass_on,
    act.SetPolicy: set_policy,
    act.Attach: _share,
    act.Detach: _share,
}
