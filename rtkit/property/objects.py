"""Class Property Service: any object as properties, its class as it is.

Attributes, properties, getters and setters become properties, other public methods actions, nested
objects sub-properties. Source: `property-service` reference, section 8.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

from rtkit.property.annotations import bare, choices_of, spec_of, type_of
from rtkit.property.codes import PropertyError
from rtkit.property.conversion import from_value, to_value
from rtkit.property.functional import Function, Run, run_at_once
from rtkit.property.members import Member, is_data, is_nested, members
from rtkit.property.naming import segment_of
from rtkit.property.service import Service
from rtkit.property.spec import Parameter, Spec
from rtkit.property.types import Content, parse_type
from rtkit.property.values import Value

DEEPEST = 4
"""Levels of nested objects that are shown."""

_UNSET = object()


class Exported:
    """An object as properties of a service.

    Args:
        service: Gets the properties.
        thing: The object; it is never changed but by a SET.
        hidden: Names that are not to be seen, at any depth.
        run: Runs the calls of methods.
    """

    def __init__(
        self, service: Service, thing: object, hidden: Iterable[str] = (), run: Run = run_at_once
    ) -> None:
        self._service = service
        self._thing = thing
        self._hidden = frozenset(hidden)
        self._run = run
        self._names: dict[str, object] = {}
        self.refresh()
        service.on_names = self.refresh

    def refresh(self) -> None:
        """Look which members there are now; tell what came and what went."""
        found: dict[str, tuple[Callable[[], Any], Member, object]] = {}
        self._scan(lambda: self._thing, "", (), found)
        for name in [each for each in self._names if each not in found]:
            del self._names[name]
            if name in self._service.registry.nodes:
                self._service.remove(name)
        for name, (holder, member, present) in found.items():
            if name not in self._names:
                self._names[name] = member
                self._add(name, holder, member, present)

    def _scan(
        self,
        holder: Callable[[], Any],
        prefix: str,
        seen: tuple[int, ...],
        found: dict[str, tuple[Callable[[], Any], Member, object]],
    ) -> None:
        """Note all members below an object; no deeper than `DEEPEST`, so this may call itself."""
        thing = holder()
        seen = (*seen, id(thing))
        for member in members(thing, self._hidden):
            name = prefix + segment_of(member.name)
            if member.kind == "method":
                found[name] = (holder, member, _UNSET)
                continue
            present = _UNSET if member.access == "w" else _tried(thing, member)
            if is_nested(present) and present is not _UNSET:
                if len(seen) < DEEPEST + 1 and id(present) not in seen:
                    self._scan(_nested(holder, member), f"{name}.", seen, found)
            elif present is _UNSET or is_data(present):
                found[name] = (holder, member, present)

    def _add(self, name: str, holder: Callable[[], Any], member: Member, present: object) -> None:
        if member.kind == "method":
            function = self._function(holder, member)
            spec = Spec(parse_type("element"), doc=member.doc, is_functional=True)
            self._service.add(name, spec=spec, function=function)
            return
        known = None if present is _UNSET else present
        spec = spec_of(member.hint, known, member.access, member.doc)
        if known is None or spec.type.base == "bytes" or isinstance(known, bytes | bytearray):
            base = "bytes" if isinstance(known, bytes | bytearray) else spec.type.name
            kind = parse_type("any" if known is None and not member.hint else base)
            spec = _retyped(spec, kind)

        takes = _taken(holder(), member)
        if takes:
            declared = {each.key: each for of in takes.values() for each in of[0]}
            spec = replace(spec, parameters=tuple(declared.values()))

        def given_to(accessor: str, given: dict[str, Value]) -> dict[str, Any]:
            known, hints = takes.get(accessor, ((), {}))
            for key in given:
                if all(each.key != key for each in known):
                    raise PropertyError("bad-parameter", f"{accessor} has no parameter {key}")
            return {key: from_value(each, hints.get(key), None) for key, each in given.items()}

        def read(given: dict[str, Value]) -> Content:
            if given:
                named = given_to(member.getter, given)
                return to_value(getattr(holder(), member.getter)(**named))
            value = _present(holder(), member)
            if value is _UNSET:
                raise PropertyError("unknown", f"not set yet: {name}")
            return to_value(value)

        def write(value: Content, given: dict[str, Value]) -> None:
            thing = holder()
            named = given_to(member.setter, given) if given else {}
            before = None if member.access == "w" else _present(thing, member)
            wanted = from_value(value, bare(member.hint), None if before is _UNSET else before)
            _assign(thing, member, wanted, named)

        self._service.add(name, spec=spec, read=read, write=write)

    def _function(self, holder: Callable[[], Any], member: Member) -> Function:
        method = getattr(holder(), member.name)
        declared, hints = _parameters(method)

        def call(*args: Value, **named: Value) -> object:
            given = {key: from_value(each, hints.get(key), None) for key, each in named.items()}
            return getattr(holder(), member.name)(*map(_positional, args), **given)

        return Function(call, declared or (), to_value, self._run, is_open=declared is None)


def _positional(value: Value) -> object:
    return from_value(value, None, None)


def _retyped(spec: Spec, kind: Any) -> Spec:
    return replace(spec, type=kind)


def _nested(holder: Callable[[], Any], member: Member) -> Callable[[], Any]:
    return lambda: _present(holder(), member)


def _present(thing: Any, member: Member) -> object:
    """Return what a member holds now, `_UNSET` if that cannot be had."""
    try:
        if isinstance(thing, Mapping):
            return thing[member.name]
        if member.kind == "accessors":
            return getattr(thing, member.getter)()
        return getattr(thing, member.name)
    except (AttributeError, KeyError):
        return _UNSET


def _tried(thing: Any, member: Member) -> object:
    """Return what a member holds now; what cannot be read now may be another time."""
    try:
        return _present(thing, member)
    except Exception:
        return _UNSET


def _taken(
    thing: object, member: Member
) -> dict[str, tuple[tuple[Parameter, ...], dict[str, Any]]]:
    """Return what getter and setter take beside the value, with the hints, by their names."""
    found = {}
    for accessor, own in ((member.getter, 0), (member.setter, 1)):
        declared, hints = _parameters(getattr(thing, accessor)) if accessor else (None, {})
        if declared is not None and declared[own:]:
            found[accessor] = (declared[own:], hints)
    return found


def _assign(thing: Any, member: Member, value: object, named: dict[str, Any]) -> None:
    if isinstance(thing, Mapping):
        thing[member.name] = value  # type: ignore[index]
    elif member.kind == "accessors":
        getattr(thing, member.setter)(value, **named)
    else:
        try:
            setattr(thing, member.name, value)
        except AttributeError as error:
            raise PropertyError("read-only", f"cannot be set: {member.name}") from error


def _parameters(
    method: Callable[..., object],
) -> tuple[tuple[Parameter, ...] | None, dict[str, Any]]:
    """Return the arguments of a method, None if it does not tell them or takes any number."""
    import typing

    try:
        parameters = inspect.signature(method).parameters.values()
    except (ValueError, TypeError):
        return None, {}
    try:
        hints = typing.get_type_hints(method, include_extras=True)
    except (NameError, TypeError, AttributeError):
        hints = {}
    if any(each.kind in (each.VAR_POSITIONAL, each.POSITIONAL_ONLY) for each in parameters):
        return None, {}
    named = [each for each in parameters if each.kind != each.VAR_KEYWORD]
    declared = tuple(_parameter(each, bare(hints.get(each.name))) for each in named)
    return declared, {name: bare(hint) for name, hint in hints.items()}


def _parameter(parameter: inspect.Parameter, hint: Any) -> Parameter:
    default = None
    if parameter.default is not parameter.empty:
        value = to_value(parameter.default) if is_data(parameter.default) else ()
        default = () if isinstance(value, bytes) else value
    kind = type_of(hint) if hint is not None else parse_type("any")
    return Parameter(parameter.name, kind, default, choices_of(hint))
