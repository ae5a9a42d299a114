"""Class Property Service: exports any object as properties, without a change to its class.

Attributes, properties, getters and setters become properties, other public methods actions, nested
objects sub-properties. Source: `property-service` reference, section 8.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import is_dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple

from rtkit.guard import guarded
from rtkit.property.annotations import Concurrent, Returns, bare, extra_of, returned, spec_of
from rtkit.property.arguments import Taken, accepted, arguments_of, declared_of, given_to
from rtkit.property.codes import PropertyError
from rtkit.property.conversion import is_builtin, to_value
from rtkit.property.fitting import SCALARS, from_value
from rtkit.property.functional import FunctionalProperty
from rtkit.property.members import Member, is_data, is_nested, members
from rtkit.property.mounting import MountPoint
from rtkit.property.names import METHODS, NameListing, Names, NameSource, NameTable
from rtkit.property.naming import check_registrable, segment_of
from rtkit.property.node import PropertyNode
from rtkit.property.presenting import Choices, presented
from rtkit.property.property_spec import EMPTY_PLACE, PropertySpec
from rtkit.property.returning import TIMEOUT, Returning
from rtkit.property.service import Service
from rtkit.property.standard import TYPE
from rtkit.property.types import Content, parse_type
from rtkit.property.user_code import Unfolded, is_coroutine, result_of
from rtkit.property.values import Value
from rtkit.property.writing import worded

_PLAIN_SETS: tuple[object, ...] = (object.__setattr__, dict.__setattr__)
DEEPEST = 4
"""Levels of nested objects that are shown."""

_UNSET = object()
_NONE = Member("", "method")
_EMPTY = Member("", "empty")
_NAMED = Member("", "accessors", getter="get")
_NOTHING: Mapping[str, Any] = MappingProxyType({})


class _Found(NamedTuple):
    """Member of the object, or of one that it holds.

    Attributes:
        holder: Returns the object whose member it is.
        present: Its value, `_UNSET` where that takes user code.
        is_plain: Neither it nor what holds it takes user code to read.
        method: The bound method, of a method.
        takes: Returns arguments of getter and setter, with their hints, by their names.
        names: Names found to come and go below it, in place of all else.
    """

    holder: Callable[[], Any]
    member: Member
    present: object = _UNSET
    is_plain: bool = False
    method: object = None
    takes: Callable[[], Taken] = dict
    names: tuple[NameTable, NameListing | None] | None = None


class Exported:
    """Exports an object as properties of a service.

    Names are listed without a call of its getters: members of an object that only a getter returns
    are known after the first GET of it.

    Args:
        service: Gets the properties, calls user code.
        thing: The object; it is never changed but by a SET.
        hidden: Names that are not to be seen, at any depth.

    Raises:
        PropertyError: ``internal``: it cannot be looked at.
    """

    def __init__(self, service: Service, thing: object, hidden: Iterable[str] = ()) -> None:
        self._service = service
        self._thing = thing
        self._hidden = frozenset(hidden)
        self._names: dict[str, object] = {}
        self._mounts: dict[str, MountPoint] = {}
        self._unfolded: dict[str, object] = {}
        self._tables: dict[str, NameTable] = {}
        self._looks = self._seen = 0
        self.refresh()
        service.values.on_names = self.refresh
        service.values.on_new = self._new
        if isinstance(thing, Names):
            service.values.may_differ = thing.has_changed

    def refresh(self) -> None:
        """Compare with the members that there are now; report those that came and went.

        Raises:
            PropertyError: ``internal``: it cannot be looked at.
        """
        self._looks += 1
        look = self._looks
        found: dict[str, _Found] = {}
        scan = lambda: self._scan(lambda: self._thing, self._thing, "", (), found, is_plain=True)  # noqa: E731
        result_of(self._service.values.user_code.call(scan))
        if look < self._seen:
            return  # a later look was ready sooner
        self._seen = look
        with self._service.listeners.together():
            self._apply(found)

    def _apply(self, found: dict[str, _Found]) -> None:
        looked = {prefix: each.names for prefix, each in found.items() if each.names}
        for prefix in looked:
            del found[prefix]
        for name in [each for each in self._names if not self._is_still(each, found.get(each))]:
            del self._names[name]
            self._unmount(name)
            if name in self._service.registry.nodes:
                self._service.remove(name)
        for name, each in found.items():
            if name not in self._names:
                if name in self._service.registry.nodes:
                    self._service.remove(name, only=True)  # one that came: members win
                self._names[name] = each.member
                self._add(name, each)
        for prefix in self._tables.keys() - looked.keys():
            self._put_names(self._tables.pop(prefix), NameListing())
        for prefix, (table, listing) in looked.items():
            self._tables[prefix] = table
            if listing is not None:
                self._put_names(table, listing)

    def _is_still(self, name: str, found: _Found | None) -> bool:
        """Return whether a member is there as before: the same mount, if it is one."""
        if found is None:
            return False
        if (found.member is _EMPTY) is not (self._names[name] is _EMPTY):
            return False  # a place that is no longer empty, or is now
        mount = found.present if isinstance(found.present, MountPoint) else None
        return self._mounts.get(name) is mount

    def _mount(self, name: str, mount: MountPoint, found: _Found) -> None:
        """Have what is below a name be that of another owner."""
        holder, member = found.holder, found.member

        def is_there() -> bool:
            if not found.is_plain:
                return True  # to look would take user code
            return guarded(lambda: _present(holder(), member)).result is mount

        def read(_given: dict[str, Value]) -> Content:
            if is_there():
                raise PropertyError("unknown", f"no such property: {name}")
            raise Unfolded(name)

        doc = f"What {mount.target} has"
        self._service.add(name, spec=PropertySpec(parse_type("list"), "r", doc=doc), read=read)
        self._add_mount(name, mount, is_there)

    def _add_mount(self, name: str, mount: MountPoint, is_there: Callable[[], bool]) -> None:
        self._mounts[name] = mount
        if self._service.mounts is None:
            self._service.mounts = mount.table_for(self._service)
        self._service.mounts.add(name, mount, is_there)

    def _unmount(self, name: str) -> None:
        if self._mounts.pop(name, None) is not None and self._service.mounts is not None:
            self._service.mounts.remove(name)

    def _put_names(self, table: NameTable, listing: NameListing) -> None:
        nodes = self._service.registry.nodes
        gone, added = table.put(listing)
        for name in gone:
            node = nodes.get(table.prefix + name)
            if node is not None and node.source is not None:
                self._service.remove(node.name, only=True)
                self._unmount(node.name)
        for name, hint in added.items():
            if table.prefix + name not in self._names:
                spec, accessors = self._named(table, name, hint)
                node = self._service.add(table.prefix + name, spec=spec, **accessors)
                node.source = NameSource(table, name)
                mount = table.owner().mount(name)
                if mount is not None:
                    self._add_mount(node.name, mount, lambda: True)

    def _new(self, name: str) -> PropertyNode | None:
        """Return a property that is not there yet, None if nobody makes such."""
        for table in sorted(self._tables.values(), key=lambda each: -len(each.prefix)):
            owner, own = table.owner(), name.removeprefix(table.prefix)
            if name.startswith(table.prefix) and hasattr(owner, "set"):
                hint = result_of(self._service.values.user_code.call(lambda: owner.hint(own)))  # noqa: B023
                spec, accessors = self._named(table, own, hint)
                node = PropertyNode(check_registrable(name), spec, None, 0.0)
                node.reader, node.writer = accessors["read"], accessors["write"]
                node.source = NameSource(table, own)
                return node
        return None

    def _scan(
        self,
        holder: Callable[[], Any],
        thing: object,
        prefix: str,
        seen: tuple[int, ...],
        found: dict[str, _Found],
        *,
        is_plain: bool,
    ) -> None:
        """Note all members below an object; no deeper than `DEEPEST`, so this may call itself."""
        seen, hidden = (*seen, id(thing)), self._hidden
        if isinstance(thing, Names):
            hidden |= METHODS
            table = self._tables.get(prefix) or NameTable(prefix, holder)
            found[prefix] = _Found(holder, _NONE, names=(table, table.looked()))
        for member in members(thing, hidden):
            name = prefix + segment_of(member.name)
            if member.kind == "gui":
                whose = prefix + segment_of(member.name[4:]) if member.name[4:] else prefix[:-1]
                self._service.values.widgets[whose] = partial(presented, holder, member.name)
                continue
            if member.kind == "method":
                found[name] = _Found(holder, member, method=getattr(thing, member.name))
                continue
            is_known = is_plain and member.is_plain
            present = self._unfolded.get(name, _UNSET)
            if is_known:
                present = _present(thing, member)
            if isinstance(present, MountPoint):
                found[name] = _Found(holder, member, present, is_known)
                continue
            held = self._nested(holder, member, name, is_known=is_known)
            look = partial(self._below, held, present, name, seen, is_plain=is_known)
            below = guarded(look)
            if below.error is not None:
                found[name] = _Found(holder, member)  # a GET of it tells why
            elif below.result is not None:
                found |= below.result
                if _is_empty(present):
                    found[name] = _Found(held, _EMPTY)
            elif present is _UNSET or is_data(present):
                takes = partial(accepted, thing, member)  # dear, and wanted of a new one only
                found[name] = _Found(holder, member, present, is_known, takes=takes)

    def _below(
        self,
        held: Callable[[], Any],
        present: object,
        name: str,
        seen: tuple[int, ...],
        *,
        is_plain: bool,
    ) -> dict[str, _Found] | None:
        """Return the members below an object, None of what has none."""
        if present is _UNSET or not is_nested(present):
            return None
        found: dict[str, _Found] = {}
        if len(seen) < DEEPEST + 1 and id(present) not in seen:
            self._scan(held, present, f"{name}.", seen, found, is_plain=is_plain)
        return found

    def _nested(
        self, holder: Callable[[], Any], member: Member, name: str, *, is_known: bool
    ) -> Callable[[], Any]:
        def held() -> Any:
            present = self._read(holder(), member)
            if not is_known:
                self._unfolded[name] = present
            return present

        return held

    def _read(self, thing: Any, member: Member, named: Mapping[str, Any] = _NOTHING) -> Any:
        """Return the value of a member now; awaited where its getter is a coroutine function.

        Raises:
            BaseException: As the code of the user did.
        """
        present = _present(thing, member, named)
        if is_coroutine(present):
            return self._service.values.user_code.awaited(present, lambda cancel: None)
        return present

    def _add(self, name: str, found: _Found) -> None:
        holder, member = found.holder, found.member
        if isinstance(found.present, MountPoint):
            self._mount(name, found.present, found)
            return
        if member.kind == "method":
            function = self._function(found)
            spec = PropertySpec(parse_type("element"), doc=member.doc, is_functional=True)
            self._service.add(name, spec=spec, function=function)
            return
        if member is _EMPTY:
            self._service.add(
                name, spec=EMPTY_PLACE, read=lambda _given: _nothing_in(holder(), name)
            )
            return
        spec = _spec(member, found.present)
        if takes := found.takes():
            spec = replace(spec, parameters=declared_of(takes))
        is_unknown = member.hint is None and found.present is _UNSET
        if name == "type" and spec.type.name in ("list", "list<string>"):
            spec = replace(spec, type=TYPE)
        in_words = spec.type == TYPE
        is_plain = member.kind == "attribute" and found.is_plain
        choices = extra_of(member.hint, Choices)
        is_alone = member.access == "w" or bare(member.hint) in SCALARS
        is_record = not is_plain and member.access == "rw" and is_dataclass(bare(member.hint))

        def read(given: dict[str, Value]) -> Content:
            named = given_to(member.getter, takes, given) if given else {}
            present = self._read(holder(), member, named)
            if present is _UNSET:
                raise PropertyError("unknown", f"not set yet: {name}")
            if not is_plain and not is_record and is_nested(present):
                self._unfold(name, present)
            if is_unknown and not named:
                self._learn(name, member, present)
            value = to_value(present)
            return value if isinstance(value, bytes) or not in_words else worded(value)

        def write(value: Content, given: dict[str, Value]) -> Any:
            thing = holder()
            named = given_to(member.setter, takes, given) if given else {}
            before = None if is_alone else self._read(thing, member)
            if is_unknown and self._learn(name, member, before):
                raise Unfolded(name)  # the value is to be read as what it is now known to be
            wanted = from_value(value, member.hint, None if before is _UNSET else before)
            if choices is not None:
                choices.check(thing, wanted)
            return _assign(thing, member, wanted, named)

        node = self._service.add(name, spec=spec, read=read, write=write)
        node.is_concurrent = extra_of(member.hint, Concurrent) is not None
        if is_plain:
            node.is_quick = _quickness(holder, member, type(holder()))
        if choices is not None and not choices.is_fixed:
            node.choices, node.is_quick = lambda: choices.of(holder()), None
        returns = extra_of(member.hint, Returns)
        if returns is not None and "w" in member.access:
            self._return(node, returns)

    def _return(self, node: PropertyNode, returns: Returns) -> None:
        """Have a property return by itself, and its time-out set."""
        to = None if returns.to is None else to_value(returns.to)
        values = self._service.values
        read, apply = partial(values.value_of, node), partial(values.apply, node)
        made = Returning(node.name, read, apply, values.user_code, returns.after, to)
        node.returning = made
        timeout = self._service.add(
            f"{node.name}.timeout", spec=TIMEOUT, read=made.read_timeout, write=made.write_timeout
        )
        timeout.is_quick = lambda: True

    def _named(self, table: NameTable, name: str, hint: Any) -> tuple[PropertySpec, dict[str, Any]]:
        """Return what is declared of a property that came with a name, its reader and writer."""
        can_set = hasattr(table.owner(), "set")
        if hint not in table.specs:
            known = returned(type(table.owner()).get) if hint is None else hint
            takes = accepted(table.owner(), _NAMED._replace(setter="set" * can_set), own=(1, 2))
            spec = spec_of(known, None, "rw" if can_set else "r", "")
            table.specs[hint] = replace(spec, parameters=declared_of(takes)), known, takes
        spec, kind, takes = table.specs[hint]

        def read(given: dict[str, Value]) -> Content:
            named = given_to("get", takes, given) if given else {}
            value = table.owner().get(name, **named)
            if is_coroutine(value):
                value = self._service.values.user_code.awaited(value, lambda cancel: None)
            return to_value(value)

        def write(value: Content, given: dict[str, Value]) -> Any:
            named = given_to("set", takes, given) if given else {}
            outcome = table.owner().set(name, from_value(value, kind, None), **named)  # type: ignore[attr-defined]
            return outcome if is_coroutine(outcome) else None

        return spec, {"read": read, "write": write if can_set else None}

    def _unfold(self, name: str, present: object) -> None:
        """Show the object that a getter has returned by its members, from the next refresh on."""
        self._unfolded[name] = present
        raise Unfolded(name)

    def _learn(self, name: str, member: Member, present: object) -> bool:
        """Take the type of the first value for that of a property that declares none.

        Returns:
            Whether the property has another type now.
        """
        node = self._service.registry.nodes.get(name)
        if node is None or node.spec.type.base != "any":
            return False
        node.spec = replace(_spec(member, present), parameters=node.spec.parameters)
        return node.spec.type.base != "any"

    def _function(self, found: _Found) -> FunctionalProperty:
        declared, hints = arguments_of(found.method)  # type: ignore[arg-type]
        name, holder = found.member.name, found.holder
        choices = {key: extra_of(hint, Choices) for key, hint in hints.items()}

        def fit(key: str, value: Value) -> None:
            wanted = from_value(value, hints.get(key), None)
            chosen = choices.get(key)
            if chosen is not None and not chosen.is_fixed:
                chosen.check(holder(), wanted)

        def call(*args: Value, **named: Value) -> object:
            given = {key: from_value(each, hints.get(key), None) for key, each in named.items()}
            return getattr(holder(), name)(*map(_positional, args), **given)

        return FunctionalProperty(
            call,
            declared or (),
            to_value,
            is_open=declared is None,
            is_behavior=getattr(found.method, "is_behavior", False),
            fit=fit,
        )


def _nothing_in(held: object, name: str) -> Content:
    """Return what a place tells that had nothing in it when names were looked for."""
    if not _is_empty(held):
        raise Unfolded(name)
    return ()


def _is_empty(held: object) -> bool:
    """Return whether a place has no names just now, and may come to have some."""
    return not (held.names() if isinstance(held, Names) else held or not isinstance(held, Mapping))


def _spec(member: Member, present: object) -> PropertySpec:
    """Return what is declared of a property by its annotation, else by its value."""
    known = None if present is _UNSET else present
    spec = spec_of(member.hint, known, member.access, member.doc)
    if isinstance(known, bytes | bytearray):
        return replace(spec, type=parse_type("bytes"))
    return replace(spec, type=parse_type("any")) if known is None and not member.hint else spec


def _quickness(holder: Callable[[], Any], member: Member, cls: type) -> Callable[[], bool]:
    """Return a test that a plain attribute can still be read and set without user code."""
    if not (member.access == "r" or cls.__setattr__ in _PLAIN_SETS):
        return lambda: False
    name, of_mapping = member.name, issubclass(cls, Mapping)

    def is_quick() -> bool:
        thing = holder()
        if type(thing) is not cls:
            return False
        present = _present(thing, member) if of_mapping else getattr(thing, name, _UNSET)
        return present is not _UNSET and is_builtin(present)

    return is_quick


def _positional(value: Value) -> object:
    return from_value(value, None, None)


def _present(thing: Any, member: Member, named: Mapping[str, Any] = _NOTHING) -> object:
    """Return what a member holds now, `_UNSET` of an attribute that has not been set yet."""
    if isinstance(thing, Mapping):
        return thing.get(member.name, _UNSET)
    if member.kind == "accessors":
        return getattr(thing, member.getter)(**named)
    if not member.is_plain:
        return getattr(thing, member.name)
    return getattr(thing, member.name, _UNSET)


def _assign(thing: Any, member: Member, value: object, named: dict[str, Any]) -> object:
    """Put a value in force; return what is to be awaited, if anything."""
    if member.kind == "accessors" and not isinstance(thing, Mapping):
        outcome: object = getattr(thing, member.setter)(value, **named)
        return outcome if is_coroutine(outcome) else None
    try:
        if isinstance(thing, Mapping):
            thing[member.name] = value  # type: ignore[index]
        else:
            setattr(thing, member.name, value)
    except AttributeError as error:
        raise PropertyError("read-only", f"cannot be set: {member.name}") from error
    return None
