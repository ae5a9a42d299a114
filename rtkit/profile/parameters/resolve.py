"""Resolves a system profile: values of its variables, included files, names behind prefixes.

A pure function: the content of included files comes from a function that the caller supplies.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from rtkit.errors import InvalidDocument, Malformed, RtkitError
from rtkit.fast_dataclass import replace
from rtkit.profile import rts_model as m
from rtkit.profile.common import NO_FOREIGN, Foreign
from rtkit.profile.parameters import GivenValue
from rtkit.profile.parameters.naming import Reference, prefixed, with_references
from rtkit.profile.parameters.texts import NAME, PREFIX, holds, substituted
from rtkit.profile.parse import MAX_BYTES
from rtkit.profile.rts_spec import ORDERS, RTS_PROFILE
from rtkit.profile.spec import TEXT, Attr, ElementSpec
from rtkit.profile.xmlnames import RTKIT, clark, short, split
from rtkit.rtc.naming_properties import SLAVE_RESTART
from rtkit.rtc.nearest import did_you_mean

MOST_PARTS = 100_000
"""A system of more components, connectors and the like is refused."""

MOST_NESTED = 32
MOST_INCLUDES = 1000
"""A system of more profiles than this is refused: two that include two each grow fast."""

_CONDITIONS = (("if", True), ("unless", False))
LISTED = ("components", "groups", "data_port_connectors", "service_port_connectors")
_KEYS = (*LISTED, *(field for field, _ in ORDERS))
_TARGETS = "targets"
_NAMES = ("instance_name", "group_id", "connector_id", "connector_id")
Step = tuple[str, int]


class SourceProfile(NamedTuple):
    """A system profile as it was read.

    Attributes:
        name: For messages.
        path: The real path of its file, by which loops of includes are seen.
    """

    name: str
    path: str
    profile: m.RtsProfile


class ProfileOrigin(NamedTuple):
    """The place that a part of a resolved profile comes from."""

    source: SourceProfile
    steps: tuple[Step, ...]


class ResolvedProfile(NamedTuple):
    """A profile without parameters.

    Attributes:
        origins: By a field of the profile, where each of its parts comes from; for an order each
            of its targets.
    """

    profile: m.RtsProfile
    origins: dict[str, list[ProfileOrigin]]


class UnresolvedPart(Malformed):
    """A part of a profile that cannot be resolved.

    Attributes:
        origin: The part, from the root on.
        name: The name of its attribute, ``rtkit:if``; empty for all of it.
    """

    def __init__(self, origin: ProfileOrigin, name: str, message: str) -> None:
        super().__init__(message)
        self.origin = origin
        self.name = name


class UnknownValue(Malformed):
    """A given value that nothing takes.

    Attributes:
        origin: Where it was given.
    """

    def __init__(self, origin: str, message: str) -> None:
        super().__init__(f"{origin}: {message}" if origin else message)
        self.origin = origin


Load = Callable[[str, SourceProfile], SourceProfile]
"""Reads an included file, by its path and the profile that includes it."""


def nothing_included(file: str, _: SourceProfile) -> SourceProfile:
    """Refuse to read a file.

    Raises:
        Malformed: Always.
    """
    raise Malformed(f"{file} cannot be included here")


def resolve(
    source: SourceProfile,
    given: Sequence[GivenValue] = (),
    prefix: str = "",
    load: Load = nothing_included,
) -> ResolvedProfile:
    """Return what a profile says with these values; of those for one key the last holds.

    Raises:
        UnresolvedPart: A variable has no value or does not exist, a condition or reference makes
            no sense, or an include is a loop; names the part.
        UnknownValue: A value is for nothing that there is, or no name begins as the prefix.
    """
    if not re.fullmatch(PREFIX, prefix):
        raise UnknownValue("--prefix", f"{prefix!r} is no beginning of a name")
    used: set[GivenValue] = set()
    system = _System(source, (), [_Passed(each.key, each) for each in given], used, load, [0, 0])
    system.resolve()
    for each in given:
        if each not in used:
            raise UnknownValue(each.origin, system.unknown(each.key))
    return ResolvedProfile(prefixed(system.profile, prefix), system.origins)


class _Passed(NamedTuple):
    """A given value on its way down, with what is left of its key."""

    key: str
    value: GivenValue


class _System:
    """One profile of the tree of includes, while it is resolved.

    Attributes:
        variables: Names of its variables, and of those that it includes with their prefixes.
        components: Names of all components, also of those that a condition leaves out.
        left_out: Names of the latter.
        left_prefixes: Prefixes of the profiles that a condition leaves out.
    """

    def __init__(
        self,
        source: SourceProfile,
        above: tuple[SourceProfile, ...],
        given: list[_Passed],
        used: set[GivenValue],
        load: Load,
        count: list[int],  # of includes so far, and of characters that variables added
    ) -> None:
        self.profile = source.profile
        self.origins: dict[str, list[ProfileOrigin]] = {}
        self.variables: list[str] = []
        self.components: list[str] = []
        self.left_out: set[str] = set()
        self.left_prefixes: list[str] = []
        self._source, self._above, self._given = source, above, given
        self._used, self._load, self._count = used, load, count
        self._values: dict[str, str] = {}

    def resolve(self) -> None:
        self._set_variables()
        included = self._filled()
        self._set_parameters()
        for number, include in included:
            self._include(number, include)
        self._check_names()
        if self.left_out or self.left_prefixes or included:
            self._settle()

    def unknown(self, key: str) -> str:
        """Return why a key is for nothing, with what may be meant."""
        name, dot, parameter = key.rpartition(".")
        hint = did_you_mean(key, self.variables)
        if not dot or hint:
            there = ", ".join(self.variables) or "none"
            return f"no variable {key}{hint or f'; there are {there}'}"
        near = did_you_mean(name, self.components, shown=lambda each: f"{each}.{parameter}")
        there = ", ".join(self.components[:20]) or "none"
        return f"no component {name}{near or f'; there are {there}'}"

    def _wrong(self, steps: tuple[Step, ...], name: str, text: str) -> UnresolvedPart:
        return UnresolvedPart(ProfileOrigin(self._source, steps), name, text)

    def _set_variables(self) -> None:
        for number, each in enumerate(self.profile.variables):
            steps = (("variables", number),)
            if not re.fullmatch(NAME, each.name):
                raise self._wrong(steps, "rtkit:name", f"not a name of a variable: {each.name!r}")
            if each.name in self._values:
                text = f"variable {each.name} is declared twice"
                raise self._wrong(steps, "rtkit:name", text)
            fits = [passed for passed in self._given if passed.key == each.name]
            self._used.update(passed.value for passed in fits)
            if not fits and each.default is None:
                about = f" ({each.description})" if each.description else ""
                text = f"variable {each.name}{about} has no value, and none is given"
                text += f" (--set {each.name}=VALUE)"
                raise self._wrong(steps, "rtkit:name", text)
            default = self._text(each.default or "", steps, "rtkit:default")
            self._values[each.name] = fits[-1].value.value if fits else default
        self.variables += self._values

    def _text(self, text: str, steps: tuple[Step, ...], name: str) -> str:
        if not self.profile.variables or "$" not in text:
            return text
        try:
            made = substituted(text, self._values)
        except Malformed as error:
            raise self._wrong(steps, name, str(error)) from error
        self._count[1] += max(0, len(made) - len(text))
        if self._count[1] > MAX_BYTES:
            raise self._wrong(steps, name, f"texts become longer than {MAX_BYTES} characters")
        return made

    def _filled(self) -> list[tuple[int, m.IncludedSystem]]:
        """Fill the profile with the values of its variables; return what it includes."""
        self._numbers: dict[str, list[int]] = {}
        every = self.profile
        filled = self._part(replace(every, variables=()), RTS_PROFILE, ())
        numbers = self._numbers
        kept = set(numbers.get("components", ()))
        for number, each in enumerate(every.components):
            name = self._text(each.instance_name, (("components", number),), "rts:instanceName")
            self.components.append(name)
            if number not in kept:
                self.left_out.add(name)
        for number, include in enumerate(every.includes):
            if number not in numbers.get("includes", ()):
                self._leave_out(number, include)
        for key in _KEYS:
            before = () if key in LISTED else ((key, 0),)
            last = _TARGETS if before else key
            self.origins[key] = [
                ProfileOrigin(self._source, (*before, (last, n))) for n in numbers.get(key, ())
            ]
        self.profile = replace(filled, includes=())
        return list(zip(numbers.get("includes", ()), filled.includes, strict=True))

    def _leave_out(self, number: int, include: m.IncludedSystem) -> None:
        prefix = self._text(include.prefix or "", (("includes", number),), "rtkit:prefix")
        if prefix:
            self.left_prefixes.append(prefix)
            self._used.update(each.value for each in self._given if each.key.startswith(prefix))

    def _part(self, value: Any, spec: ElementSpec, steps: tuple[Step, ...]) -> Any:
        changes: dict[str, Any] = {}
        for item in spec.attributes:
            text = getattr(value, item.field)
            if item.kind == TEXT and text is not None:
                made = self._text(text, steps, short(item.name))
                if made != text:
                    changes[item.field] = made
        foreign: Foreign = getattr(value, spec.foreign_field)
        if foreign.attributes:
            self._own_attributes(foreign, spec, steps, changes)
        for child in spec.children:
            below = getattr(value, child.field) if child.spec is not None else None
            if not below or child.field in changes:
                continue
            if not child.is_many:
                made = self._kept(below, child.spec, (*steps, (child.field, 0)))
                if made is not below:
                    changes[child.field] = made
                continue
            kept = []
            for number, each in enumerate(below):
                made = self._kept(each, child.spec, (*steps, (child.field, number)))
                if made is not None:
                    kept.append((number, made))
            if not steps or child.field == _TARGETS:
                key = steps[0][0] if steps else child.field
                self._numbers[key] = [number for number, _ in kept]
            if len(kept) < len(below) or any(made is not below[n] for n, made in kept):
                changes[child.field] = tuple(made for _, made in kept)
        return replace(value, **changes) if changes else value

    def _kept(self, value: Any, spec: Any, steps: tuple[Step, ...]) -> Any:
        """Return a part with its values; None where its condition does not hold."""
        for field in dict.fromkeys((spec.foreign_field, "foreign")):
            foreign: Foreign = getattr(value, field)
            for word, is_wanted in _CONDITIONS:
                text = dict(foreign.attributes).get(clark(f"rtkit:{word}"))
                if text is None:
                    continue
                try:
                    is_met = holds(text, self._values)
                except Malformed as error:
                    raise self._wrong(steps, f"rtkit:{word}", str(error)) from error
                if is_met != is_wanted:
                    return None
        if spec.wraps:
            made = self._part(value, spec.children[0].spec, steps)
            return replace(made, around=_without_own(made.around))
        return self._part(value, spec, steps)

    def _own_attributes(
        self, foreign: Foreign, spec: ElementSpec, steps: tuple[Step, ...], changes: dict[str, Any]
    ) -> None:
        """Have rtkit's attributes take the places of those that other tools read."""
        left = _without_own(foreign)
        if left != foreign:
            changes[spec.foreign_field] = left
        for name, text in foreign.attributes:
            namespace, local = split(name)
            if namespace == RTKIT and local in spec.attribute_by_local:
                item = spec.known[spec.attribute_by_local[local]]
                changes[item.field] = self._value(item, text, steps, f"rtkit:{local}")

    def _value(self, item: Attr, text: str, steps: tuple[Step, ...], name: str) -> Any:
        made = self._text(text, steps, name)
        if item.check is not None and not item.check(made):
            text = f"{short(item.name)} is {made!r}; allowed: {item.allowed}"
            raise self._wrong(steps, name, text)
        return made if item.read is None else item.read(made)

    def _set_parameters(self) -> None:
        """Set given parameters of own components; those left out have no use for theirs."""
        components = list(self.profile.components)
        places = {each.instance_name: number for number, each in enumerate(components)}
        for passed in self._given:
            fits = [name for name in self.components if passed.key.startswith(f"{name}.")]
            if passed.value in self._used or not fits:
                continue
            name = max(fits, key=len)
            self._used.add(passed.value)
            if name in places:
                at, rest = places[name], passed.key[len(name) + 1 :]
                components[at] = _with_parameter(components[at], rest, passed.value.value)
        if self._given:
            self.profile = replace(self.profile, components=tuple(components))

    def _include(self, number: int, include: m.IncludedSystem) -> None:
        steps = (("includes", number),)
        prefix = include.prefix or ""
        if not re.fullmatch(PREFIX, prefix):
            text = f"{prefix!r} is no beginning of a name"
            raise self._wrong(steps, "rtkit:prefix", text)
        source = self._read(include, steps)
        outer = [
            _Passed(each.key[len(prefix) :], each.value)
            for each in self._given
            if each.key.startswith(prefix) and each.value not in self._used
        ]
        # An origin of its own for each value: that nobody takes it is said of its line.
        own = [
            GivenValue(each.name, each.value, f"{len(self._above)} {self._count[0]} {place}")
            for place, each in enumerate(include.values)
        ]
        passed = [*(_Passed(each.key, each) for each in own), *outer]
        above = (*self._above, self._source)
        inner = _System(source, above, passed, self._used, self._load, self._count)
        inner.resolve()
        for place, each in enumerate(own):
            if each not in self._used:
                text = f"{source.name} has {inner.unknown(each.key)}"
                raise self._wrong((*steps, ("values", place)), "rtkit:name", text)
        self._merge(inner, prefix)
        if sum(map(len, self.origins.values())) > MOST_PARTS:
            raise self._wrong(steps, "rtkit:file", f"the system has more than {MOST_PARTS} parts")

    def _read(self, include: m.IncludedSystem, steps: tuple[Step, ...]) -> SourceProfile:
        self._count[0] += 1
        if self._count[0] > MOST_INCLUDES:
            text = f"more than {MOST_INCLUDES} profiles are included"
            raise self._wrong(steps, "rtkit:file", text)
        try:
            source = self._load(include.file, self._source)
        except InvalidDocument:
            raise  # it names its own file and line
        except RtkitError as error:
            raise self._wrong(steps, "rtkit:file", str(error)) from error
        chain = [*self._above, self._source]
        if len(chain) > MOST_NESTED:
            text = f"profiles are included more than {MOST_NESTED} deep"
            raise self._wrong(steps, "rtkit:file", text)
        paths = [each.path for each in chain]
        if source.path in paths:
            loop = [*(each.name for each in chain[paths.index(source.path) :]), source.name]
            text = f"a profile includes itself: {' -> '.join(loop)}"
            raise self._wrong(steps, "rtkit:file", text)
        return source

    def _merge(self, inner: _System, prefix: str) -> None:
        other = prefixed(inner.profile, prefix)
        lists = {key: _listed(self.profile, key) + _listed(other, key) for key in _KEYS}
        # States, events and history are of the included system, which is none of its own here.
        slaves = tuple(p for p in other.properties if p.name.startswith(SLAVE_RESTART))
        mine = replace(self.profile, properties=self.profile.properties + slaves)
        self.profile = _with_lists(mine, lists)
        for field, origins in inner.origins.items():
            self.origins.setdefault(field, []).extend(origins)
        self.variables += (prefix + name for name in inner.variables)
        self.components += (prefix + name for name in inner.components)
        self.left_out.update(prefix + name for name in inner.left_out)
        self.left_prefixes += (prefix + each for each in inner.left_prefixes)

    def _check_names(self) -> None:
        """Refuse names that two parts have, of which a reader saw one only."""
        for field, key in zip(LISTED, _NAMES, strict=True):
            first: dict[str, ProfileOrigin] = {}
            for each, origin in zip(getattr(self.profile, field), self.origins[field], strict=True):
                name = getattr(each, key)
                known = first.setdefault(name, origin)
                if known is not origin and known.source is not origin.source:
                    what = field.rpartition("_")[2].removesuffix("s")
                    text = f"{what} {name} is in {known.source.name}, too; give one a prefix"
                    raise UnresolvedPart(origin, "", text)

    def _settle(self) -> None:
        """Leave out what names a component that is left out; refuse other unknown names."""
        ids: dict[str, list[str]] = {}
        for component in self.profile.components:
            ids.setdefault(component.instance_name, []).append(component.id)
        lists: dict[str, tuple[Any, ...]] = {}
        for key in _KEYS:
            parts = list(zip(_listed(self.profile, key), self.origins[key], strict=True))
            made = [(with_references(e, self._followed(ids, o)), o) for e, o in parts]
            kept = [each for each in made if each[0] is not None and not _is_empty(each[0])]
            lists[key] = tuple(each for each, _ in kept)
            self.origins[key] = [origin for _, origin in kept]
        self.profile = _with_lists(self.profile, lists)

    def _followed(
        self, ids: dict[str, list[str]], origin: ProfileOrigin
    ) -> Callable[[Reference], Reference | None]:
        def followed(value: Reference) -> Reference | None:
            name = value.instance_name
            if name in ids:
                # A name of a component of another file needs no type.
                known = value.component_id in ids[name]
                return value if known else replace(value, component_id=ids[name][0])
            if name in self.left_out or name.startswith(tuple(self.left_prefixes)):
                return None
            raise UnresolvedPart(origin, "", f"no component {name}{did_you_mean(name, ids)}")

        return followed


def _listed(profile: m.RtsProfile, key: str) -> tuple[Any, ...]:
    """Return the parts of a profile of one kind; of an order its targets."""
    value = getattr(profile, key)
    if key in LISTED:
        return tuple(value)
    return value.targets if value is not None else ()


def _with_lists(profile: m.RtsProfile, lists: dict[str, tuple[Any, ...]]) -> m.RtsProfile:
    changes: dict[str, Any] = {key: lists[key] for key in LISTED}
    for key, _ in ORDERS:
        order = getattr(profile, key)
        if order is not None or lists[key]:
            changes[key] = replace(order or m.Order(), targets=lists[key])
    return replace(profile, **changes)


def _is_empty(part: Any) -> bool:
    return isinstance(part, m.ComponentGroup) and not part.members


def _without_own(foreign: Foreign) -> Foreign:
    left = tuple(each for each in foreign.attributes if split(each[0])[0] != RTKIT)
    if left == foreign.attributes:
        return foreign
    return replace(foreign, attributes=left) if left or foreign.elements else NO_FOREIGN


def _with_parameter(component: m.ComponentInstance, name: str, value: str) -> m.ComponentInstance:
    """Return a component with a parameter in the set that is named, else in the active one."""
    sets = list(component.configuration_sets)
    ids = [each.id for each in sets]
    set_id, _, parameter = name.partition(".")
    if not (parameter and set_id in ids):
        set_id, parameter = component.active_configuration_set or "default", name
    if set_id not in ids:
        ids.append(set_id)
        sets.append(m.ConfigurationSet(set_id))
    at = ids.index(set_id)
    data = list(sets[at].data)
    names = [each.name for each in data]
    if parameter in names:
        place = names.index(parameter)
        data[place] = replace(data[place], data=value)
    else:
        data.append(m.ConfigurationData(parameter, value))
    sets[at] = replace(sets[at], data=tuple(data))
    return replace(component, configuration_sets=tuple(sets))
