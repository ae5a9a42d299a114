"""Finds the installed packages that offer the component types of a system profile.

The id of a component chooses the version. What a profile says of a module counts where that offers
the very type; a package stands in for a module of another version, or for none.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping, Sequence

from rtkit.deployment.described import properties_of
from rtkit.deployment.extension import CREATE, MODULE, STAND_IN
from rtkit.errors import Malformed
from rtkit.fast_dataclass import replace
from rtkit.modules.describing import describe
from rtkit.modules.search import versions
from rtkit.packages.installed import installed
from rtkit.packages.records import Offering
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import ComponentInstance, RtsProfile
from rtkit.rtc.create import CreateString, readable_create
from rtkit.rtc.profiles import split_module

Offers = Callable[[str, str, str], bool]
"""Tells of a component whether a module, ``PATH:INIT``, offers the type of a create string."""


def offerings(ids: Collection[str]) -> dict[str, list[Offering]]:
    """Return the installed packages that offer types, by id, the newest first; nothing is run."""
    found: dict[str, list[Offering]] = {}
    packages = [each for each in installed() if not set(ids).isdisjoint(each.types)]
    modules = versions() if packages else {}
    for package in packages:
        for pinned, place in modules.items():
            if not place.file.startswith(f"{package.path}/"):
                continue
            try:
                with open(place.file, "rb") as stream:
                    offered = describe(stream.read(), place.file, place.init, place.package)
            except (OSError, Malformed):
                continue  # removed meanwhile, or not plain what it offers
            for each in offered or ():
                if each.type.id in ids:
                    module = f"{pinned}:{place.init}"
                    found.setdefault(each.type.id, []).append(Offering(package, each.type, module))
    return found


def chosen(
    profile: RtsProfile,
    found: Mapping[str, Sequence[Offering]],
    offers: Offers,
    stated: Collection[str] = (),
) -> RtsProfile:
    """Return a profile whose components name the versions that their ids choose.

    Args:
        profile: The system profile.
        found: Packages by name of the component, the preferred one first.
        offers: Asked of modules that a profile names.
        stated: Components of which the profile is to say how they are made, if it does not.
    """

    def made(each: ComponentInstance) -> ComponentInstance:
        name = each.instance_name
        if name not in found:
            return each
        is_bare = name in stated and not {CREATE, MODULE} & properties_of(each.properties).keys()
        return _stated(each, found[name][0]) if is_bare else _chosen(each, found[name], offers)

    return replace(profile, components=tuple(map(made, profile.components)))


def _stated(component: ComponentInstance, offering: Offering) -> ComponentInstance:
    making = {CREATE: offering.type.full_id, MODULE: offering.module}
    more = (ExtensionProperty(name, value) for name, value in making.items())
    return replace(component, properties=(*component.properties, *more))


def _chosen(
    component: ComponentInstance, found: Sequence[Offering], offers: Offers
) -> ComponentInstance:
    own = properties_of(component.properties)
    create = readable_create(own.get(CREATE, ""))
    path, _ = split_module(own.get(MODULE, ""))
    type = found[0].type
    if STAND_IN in own or create.implementation_id != type.type_name or os.path.isabs(path):
        return component  # it is made from its profile, or by no package
    fields = (type.vendor, type.category, type.language, type.version, create.options)
    full = CreateString(type.type_name, *fields)
    module = own.get(MODULE, "")
    if (
        module
        and module not in [e.module for e in found]
        and not offers(component.instance_name, module, type.full_id)
    ):
        module = found[0].module
    values = {CREATE: str(full), **({MODULE: module} if module else {})}
    return replace(
        component,
        properties=tuple(
            ExtensionProperty(each.name, values.get(each.name, each.value))
            for each in component.properties
        ),
    )
