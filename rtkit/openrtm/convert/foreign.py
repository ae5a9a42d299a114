"""Finds what is left of the old API, and says why it needs a hand."""

from __future__ import annotations

import ast
from collections.abc import Mapping

from rtkit.openrtm.convert.component_model import OldComponent, is_self
from rtkit.openrtm.convert.draft import API, FOREIGN, ModuleDraft
from rtkit.openrtm.convert.naming import OLD_BASE

LISTENER = (
    "a listener of a connector: use self.PORT.add_listener(ConnectorEvent.RECEIVED, self.METHOD)"
)
_SERVICE = "a service port: declare it in the class with ServicePort.provided or .required"
_REASONS = (
    (
        ("CorbaPort", "CorbaConsumer"),
        _SERVICE,
    ),
    (
        ("ConnectorDataListener", "ConnectorListener", "ConnectorDataListenerT"),
        LISTENER,
    ),
    (
        ("InPort", "OutPort"),
        "a port with a computed name or type, under a condition or in a loop: use self.add_in_port "
        "or self.add_out_port",
    ),
    (("CSP",), "a CSP port: native ports have no rendezvous"),
    (("StaticFSM", "EventPort"), "a state machine: derive from FsmComponent"),
    (
        ("ConfigurationParamListener", "ConfigurationSetListener"),
        "a listener of configuration: compare the parameter in on_execute",
    ),
    (("Manager",), "the manager of OpenRTM: use rtkit.connect() outside of the component"),
    (("PeriodicECSharedComposite", "PeriodicECOrganization"), "a composite of its own kind"),
)
_MEMBERS = {
    "addInPort": "a port that could not be read: use self.add_in_port",
    "addOutPort": "a port that could not be read: use self.add_out_port",
    "registerInPort": "a port that could not be read: use self.add_in_port",
    "registerOutPort": "a port that could not be read: use self.add_out_port",
    "addPort": _SERVICE,
    "bindParameter": "a parameter that could not be read",
    "_rtcout": "a logger: use self.logger",
    "_properties": "properties of the old manager: use self.options",
    "getProperties": "properties of the old manager: use self.options",
    "_objref": "a CORBA reference of the component",
    "exit": "a component ends by its manager: return ReturnCode.ERROR, or raise",
}


def mark_foreign(draft: ModuleDraft, components: list[OldComponent]) -> None:
    """Mark each place at which something of the old API is left."""
    source = draft.source
    own = {id(each.node): each for each in components}
    derived = _foreign_classes(draft, own)
    for node in ast.walk(source.tree):
        if not isinstance(node, (ast.Name, ast.Attribute)) or source.is_removed(node):
            continue
        if any(id(each) in derived for each in source.ancestors(node)):
            continue
        if source.is_edited(node) or isinstance(source.parent(node), (ast.Import, ast.ImportFrom)):
            continue
        if isinstance(node, ast.Attribute) and is_self(node):
            around = next((own[id(e)] for e in source.ancestors(node) if id(e) in own), None)
            if around is not None and _is_old_member(around, node.attr):
                reason = _MEMBERS.get(node.attr, f"self.{node.attr} of OpenRTM has no counterpart")
                draft.mark(node, reason)
            continue
        if isinstance(node, ast.Attribute) and node.attr == "isNew" and not source.is_renamed(node):
            draft.mark(node, "isNew() of what is no port of this component: is_new()")
        outer = source.parent(node)
        if isinstance(outer, ast.Attribute) and outer.value is node:
            continue
        name = draft.qualified(node)
        if name.partition(".")[0] in FOREIGN | draft.stubs:
            draft.mark(node, reason_for(name))


def _foreign_classes(draft: ModuleDraft, own: Mapping[int, OldComponent]) -> set[int]:
    """Return the classes that derive from one of the old API, each marked once."""
    found = set()
    for node in ast.walk(draft.source.tree):
        if isinstance(node, ast.ClassDef) and id(node) not in own:
            for base in node.bases:
                name = draft.qualified(base)
                if name.partition(".")[0] in FOREIGN | draft.stubs:
                    draft.mark(node, reason_for(name))
                    found.add(id(node))
    return found


def _is_old_member(component: OldComponent, name: str) -> bool:
    is_own = any(each.name == name for each in component.methods)
    declares = ("addInPort", "addOutPort", "registerInPort", "registerOutPort", "bindParameter")
    return (name in OLD_BASE or name in declares) and not is_own


def reason_for(name: str) -> str:
    """Return why a name of the old API needs a hand."""
    scope, _, last = name.partition(".")
    if scope == API:
        for beginnings, reason in _REASONS:
            if last.startswith(beginnings):
                return reason
        return f"{name} has no counterpart"
    if scope == "RTC":
        return f"{name} has no counterpart"
    if scope in ("omniORB", "CORBA", "SDOPackage", "RTM", "OpenRTM"):
        return f"{name}: native components have no CORBA"
    return f"{name} is of an IDL file: rtbuild makes a module of it"
