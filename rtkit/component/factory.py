"""Registers component types and creates components of them."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence

from rtkit.component.base import Component
from rtkit.component.contexts.callbacks import CALLBACKS, describe_failure, unfit_kind
from rtkit.component.standin import stand_in
from rtkit.errors import NotFound, Refused, RtkitError
from rtkit.rtc.create import CreateString
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import TypeProfile

Maker = Callable[[str, Mapping[str, str]], Component]


class Factories:
    """Component types by identity; a type registered again replaces the earlier one."""

    def __init__(self) -> None:
        self._makers: dict[TypeProfile, Maker] = {}

    @property
    def types(self) -> tuple[TypeProfile, ...]:
        """The registered types, in the order of registration."""
        return tuple(self._makers)

    def register(self, maker: type[Component] | ComponentPattern) -> TypeProfile:
        """Make a component class, or a pattern, available; return its identity."""
        if isinstance(maker, ComponentPattern):
            pattern = maker
            return self._register(
                pattern.type, lambda instance, options: stand_in(pattern, instance, options)
            )
        return self.register_all([maker])[0]

    def register_all(self, makers: Sequence[type[Component]]) -> tuple[TypeProfile, ...]:
        """Make component classes available, all or none; return their identities.

        Raises:
            Refused: One is no component class, or has a callback that cannot be called.
        """
        profiles = [_identity(maker) for maker in makers]
        return tuple(map(self._register, profiles, makers))

    def register_factory(self, component: type[Component]) -> TypeProfile:
        """Make a component class available; the init function of a module calls this."""
        return self.register(component)

    def unregister(self, profile: TypeProfile) -> None:
        """Forget a type; components already made stay.

        Raises:
            NotFound: No such type.
        """
        if self._makers.pop(profile, None) is None:
            raise NotFound(f"no component type {profile.full_id} is registered")

    def find(
        self,
        type_name: str,
        vendor: str = "",
        category: str = "",
        language: str = "",
        version: str = "",
    ) -> TypeProfile:
        """Return the type registered last that fits; empty fields match anything.

        Raises:
            NotFound: None fits; says what is known.
        """
        wanted = (type_name, vendor, category, language, version)
        for profile in reversed(self._makers):
            identity = (
                profile.type_name,
                profile.vendor,
                profile.category,
                profile.language,
                profile.version,
            )
            if all(want in ("", have) for want, have in zip(wanted, identity, strict=True)):
                return profile
        raise NotFound(self._explain(type_name, wanted[1:]))

    def make(self, wanted: CreateString, taken: Container[str] = ()) -> Component:
        """Make a component, not yet initialised.

        Its name is the option ``instance_name``, else the type name and the lowest free number.

        Raises:
            NotFound: No such type.
            Refused: Its constructor failed; the message has the exception and the line.
        """
        profile = self.find(
            wanted.implementation_id,
            wanted.vendor,
            wanted.category,
            wanted.language,
            wanted.version,
        )
        instance = wanted.instance_name or free_name(profile.type_name, taken)
        maker = self._makers[profile]
        try:
            return maker(instance, wanted.options)
        except RtkitError:
            raise
        except BaseException as error:
            made_by = vars(maker).get("__init__", maker) if isinstance(maker, type) else maker
            failure = describe_failure(error, made_by)
            raise Refused(f"{instance}: its constructor failed: {failure}") from error

    def _register(self, profile: TypeProfile, maker: Maker) -> TypeProfile:
        for known in self.types:
            if known.id == profile.id and known.language == profile.language:
                del self._makers[known]
        self._makers[profile] = maker
        return profile

    def _explain(self, type_name: str, fields: tuple[str, ...]) -> str:
        same = [each.full_id for each in self.types if each.type_name == type_name]
        if same:
            vendor, category, language, version = fields
            given = TypeProfile(type_name, vendor, category, version, language=language).full_id
            return f"component type {type_name} is not known as {given}; there is {', '.join(same)}"
        return f"component type {type_name} is not known"


def _identity(maker: object) -> TypeProfile:
    if not (isinstance(maker, type) and issubclass(maker, Component)):
        raise Refused(f"not a component class: {maker!r}")
    for name in CALLBACKS:
        kind = unfit_kind(getattr(maker, name))
        if kind:
            raise Refused(f"{maker.__name__}.{name} is {kind}")
    return maker.type_profile()


def free_name(type_name: str, taken: Container[str]) -> str:
    """Return the type name with the lowest number that makes a name not taken."""
    number = 0
    while f"{type_name}{number}" in taken:
        number += 1
    return f"{type_name}{number}"
