"""Names of a native component: of ports and parameters, of callbacks, and those that collide."""

from __future__ import annotations

import ast
import keyword
from functools import cache

from rtkit.openrtm.convert.component_model import OldComponent, OldParameter, OldPort, is_self
from rtkit.openrtm.convert.draft import ModuleDraft

CALLBACKS = {
    "onInitialize": "on_initialize", "onFinalize": "on_finalize", "onStartup": "on_startup",
    "onShutdown": "on_shutdown", "onActivated": "on_activated", "onDeactivated": "on_deactivated",
    "onAborting": "on_aborting", "onError": "on_error", "onReset": "on_reset",
    "onExecute": "on_execute", "onStateUpdate": "on_state_update",
    "onRateChanged": "on_rate_changed",
}  # fmt: skip
"""The native name of each callback."""
OLD_BASE = frozenset(
    {
        "activate", "addConfigurationParamListener", "addConfigurationSetListener",
        "addConfigurationSetNameListener", "addConsumerPort", "addPort", "addProperties",
        "addProviderPort", "addSdoServiceConsumer", "addSdoServiceProvider", "attach_context",
        "bindContext", "createRef", "deactivate", "deletePort", "exit", "finalizeContexts",
        "getCategory", "getConfigService", "getContextHandle", "getDescription",
        "getExecutionContext", "getExecutionContextService", "getGlobalContext",
        "getInstanceName", "getNamingNames", "getObjRef", "getProperties", "getTypeName",
        "getVendor", "getVersion", "get_component_profile", "get_configuration", "get_context",
        "get_owned_contexts", "get_participating_contexts", "get_ports", "get_sdo_id",
        "initialize", "is_alive", "readAll", "registerPort", "removeInPort", "removeOutPort",
        "removePort", "reset", "setInstanceName", "setObjRef", "shutdown", "writeAll",
        "_configsets", "_default_POA", "_inports", "_manager", "_objref", "_orb", "_outports",
        "_poa", "_portAdmin", "_properties", "_rtcout", "_SdoConfig",
    }
)  # fmt: skip
"""Methods and attributes of the old base class that components use as theirs."""
SIMPLE = {
    "getCategory": "type.category", "getDescription": "type.description",
    "getInstanceName": "instance", "getTypeName": "type.type_name", "getVendor": "type.vendor",
    "getVersion": "type.version",
}  # fmt: skip
"""Getters of the old base class, each with the native attribute."""


@cache
def reserved() -> frozenset[str]:
    """Return the names that every native component has taken."""
    from rtkit.component.base import Component

    names = {name for each in Component.__mro__ for name in vars(each)}
    return frozenset({*names, *Component.own_attributes} - set(CALLBACKS.values()))


def choose_names(draft: ModuleDraft, component: OldComponent) -> None:
    """Choose the native attribute of each port and parameter."""
    gone = {*component.ports, *component.data, *component.parameters}
    own = {
        node.attr
        for node in ast.walk(component.node)
        if isinstance(node, ast.Attribute) and is_self(node) and node.attr not in gone
    }
    own |= {each.name for each in component.methods}
    own |= {
        target.id
        for each in component.node.body
        if isinstance(each, ast.Assign)
        for target in each.targets
        if isinstance(target, ast.Name)
    }
    component.own_names = own | reserved()
    members: list[OldPort | OldParameter] = [*component.ports.values()]
    for each in [*members, *component.parameters.values(), *component.unbound]:
        each.native = _native(draft, each, component.own_names)
        component.own_names.add(each.native)


def _native(draft: ModuleDraft, member: OldPort | OldParameter, taken: set[str]) -> str:
    wanted = "".join(c if c.isalnum() or c == "_" else "_" for c in member.name).lstrip("_")
    if not wanted or wanted[0].isdigit():
        wanted = f"p{wanted}"
    if wanted in taken or keyword.iskeyword(wanted):
        wanted = f"{wanted}_"
    return draft.free(wanted, taken)


def rename_collisions(draft: ModuleDraft, component: OldComponent) -> None:
    """Give attributes and methods other names that a native component has taken."""
    named = {*component.ports, *component.data, *component.parameters}
    own = {method.name for method in component.methods}
    set_here = {
        node.attr
        for node in ast.walk(component.node)
        if isinstance(node, ast.Attribute)
        and is_self(node)
        and isinstance(node.ctx, ast.Store)
        and node.attr not in named
    }
    renamed = {}
    for name in sorted((own | set_here) & reserved()):
        if not (name.startswith("__") and name.endswith("__")):
            renamed[name] = draft.free(f"{name}_", component.own_names)
            component.own_names.add(renamed[name])
    for node in ast.walk(component.node):
        if isinstance(node, ast.Attribute) and is_self(node) and node.attr in renamed:
            draft.source.rename(node, renamed[node.attr])
    for method in component.methods:
        if method.name in renamed:
            draft.source.rename_function(method, renamed[method.name])
