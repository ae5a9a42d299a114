"""Parameters of an old component: what it binds, and what its specification declares."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from typing import Any

from rtkit.component.configuration.constraint_check import read_constraint
from rtkit.errors import Malformed
from rtkit.openrtm.convert.component_model import OldComponent, OldParameter, is_self, text_of
from rtkit.openrtm.convert.draft import API, ModuleDraft
from rtkit.openrtm.convert.reading import PREPARING, is_call_of_method

_DEFAULT = "conf.default."
_HINTS = {"__widget__": "widget", "__constraints__": "constraint", "__description__": "doc"}
_PLAIN_TYPES: Mapping[str, Callable[[str], Any]] = {
    "bool": lambda text: text.strip().lower() in ("true", "yes", "on", "1"),
    "double": float, "float": float, "int": int, "long": int, "short": int,
}  # fmt: skip


def read_parameters(draft: ModuleDraft, component: OldComponent) -> None:
    """Read the parameters of a component; those that it does not bind are texts, as there."""
    made = _initial_values(component)
    for node in ast.walk(component.node):
        if is_call_of_method(node, "bindParameter"):
            assert isinstance(node, ast.Call)
            parameter = _bound(draft, component, node, made)
            if parameter is not None:
                component.parameters[parameter.attribute] = parameter
    bound = {each.name for each in component.parameters.values()}
    for key, text in component.spec.items():
        name = key.removeprefix(_DEFAULT)
        if name != key and name not in bound:
            kind = component.spec.get(f"conf.__type__.{name}", "")
            default = _read(_PLAIN_TYPES.get(kind, str), text, text)
            component.unbound.append(
                OldParameter("", name, repr(default), _extras(component.spec, name, default))
            )


def _initial_values(component: OldComponent) -> dict[str, ast.expr]:
    return {
        node.targets[0].attr: node.value
        for method in component.methods
        if method.name in PREPARING
        for node in ast.walk(method)
        if isinstance(node, ast.Assign) and is_self(node.targets[0])
    }


def _bound(
    draft: ModuleDraft, component: OldComponent, call: ast.Call, made: Mapping[str, ast.expr]
) -> OldParameter | None:
    """Return the parameter that a call binds; None, and a mark, where it cannot be read."""
    name = text_of(call.args[0]) if call.args else None
    variable = call.args[1] if len(call.args) > 1 else None
    text = text_of(call.args[2]) if len(call.args) > 2 else None
    if name is None or text is None or variable is None or not is_self(variable):
        draft.mark(call, "a parameter whose name, variable or default is computed")
        return None
    if len(call.args) > 3 and draft.qualified(call.args[3]) != f"{API}.stringTo":
        draft.mark(call, "a parameter with a conversion of its own: read the text where it is used")
        return None
    attribute = variable.attr
    initial = made.get(attribute)
    if not isinstance(initial, ast.List) or len(initial.elts) != 1:
        draft.mark(call, f"self.{attribute} is not a list of one value, which gives the type")
        return None
    return _parameter(draft, component, call, attribute, name, text, initial.elts[0])


def _parameter(
    draft: ModuleDraft,
    component: OldComponent,
    call: ast.Call,
    attribute: str,
    name: str,
    text: str,
    value: ast.expr,
) -> OldParameter | None:
    try:
        first = ast.literal_eval(value)
    except ValueError:
        draft.mark(call, f"the first value of self.{attribute} is computed")
        return None
    given = component.spec.get(f"{_DEFAULT}{name}", text) or text
    given = given if text else str(first)  # an empty default was bound to nothing
    if isinstance(first, list):
        kinds = {type(each) for each in first}
        if kinds == {str}:
            extras = _extras(component.spec, name, given)
            return OldParameter(attribute, name, repr(given), extras, is_words=True)
        if not kinds <= {int, float}:
            draft.mark(call, f"parameter {name} is a list of what no parameter can have")
            return None
        kind = int if kinds == {int} else float
        items = _read(lambda each: tuple(map(kind, re.split(r"\s*,\s*", each.strip()))), given, ())
        items = items or _read(lambda each: tuple(map(kind, each.split(","))), text, tuple(first))
        return OldParameter(
            attribute, name, repr(items), _extras(component.spec, name, items), True
        )
    if type(first) not in (int, float, str, bool):
        draft.mark(call, f"parameter {name} is a {type(first).__name__}")
        return None
    fallback = _read(type(first), text, first)
    default = _read(type(first), given, fallback)
    return OldParameter(attribute, name, repr(default), _extras(component.spec, name, default))


def _read(kind: Callable[[str], Any], text: str, otherwise: Any) -> Any:
    try:
        return kind(text)
    except ValueError:
        return otherwise


def _extras(spec: Mapping[str, str], name: str, default: object) -> dict[str, str]:
    """Return the further arguments of a declaration, and the values of further sets."""
    found = {
        argument: repr(spec[f"conf.{hint}.{name}"])
        for hint, argument in _HINTS.items()
        if spec.get(f"conf.{hint}.{name}")
    }
    rule = spec.get(f"conf.__constraints__.{name}", "")
    if rule and not _fits(rule):
        found.pop("constraint")
    sets = {}
    for key, text in spec.items():
        head, _, rest = key.partition(".")
        set_id, _, last = rest.partition(".")
        is_set = head == "conf" and last == name and set_id not in ("default", "")
        if is_set and not set_id.startswith("__"):
            value = (
                _read(type(default), text, None)
                if not isinstance(default, tuple)
                else _read(lambda each: tuple(map(float, each.split(","))), text, None)
            )
            if value is not None:
                sets[set_id] = value
    if sets:
        found["sets"] = repr(sets)
    return found


def _fits(rule: str) -> bool:
    try:
        return read_constraint(rule) is not None
    except Malformed:
        return False
