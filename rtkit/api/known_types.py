"""Collects component types that are known here: from loaded modules and RTC profiles."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from rtkit.api.component_profiles import SEARCH_PATH, of_packages
from rtkit.deployment.described import is_same_id
from rtkit.deployment.extension import CREATE, MODULE, stated_id
from rtkit.deployment.system import KnownType
from rtkit.errors import RtkitError
from rtkit.rtc.create import CreateString

if TYPE_CHECKING:
    from rtkit.deployment.facts import Snapshot
    from rtkit.profile.rts_model import RtsProfile


def known_types(profile: RtsProfile, snapshot: Snapshot) -> dict[str, KnownType]:
    """Return the types of components of `profile` whose creation it does not specify itself.

    Profiles are only read for components that do not live, or another one in their place, and that
    no loaded module makes.
    """
    alive = {c.instance: stated_id(c) for c in snapshot.components if not c.zombie}
    unknown = {
        component.id
        for component in profile.components
        if not is_same_id(alive.get(component.instance_name, ""), component.id)
        and all(each.name != CREATE for each in component.properties)
    }
    found = {id: known for id, known in _loaded(snapshot) if id in unknown}
    missing = unknown - found.keys()
    if missing:
        found.update((id, known) for id, known in _described() if id in missing)
    return found


def _loaded(snapshot: Snapshot) -> Iterator[tuple[str, KnownType]]:
    modules = (module for each in (snapshot, *snapshot.others) for module in each.modules)
    for module in modules:
        for kind in module.types:
            create = CreateString(
                kind.type_name, kind.vendor, kind.category, kind.language, kind.version
            )
            path = f"{module.path}:{module.init}" if module.init else module.path
            yield kind.id, KnownType(str(create), path)


def _described() -> Iterator[tuple[str, KnownType]]:
    from rtkit.profile.read import read_bytes, read_rtc
    from rtkit.profile.words import property_value

    for path, modules in _files():
        try:
            profile = read_rtc(read_bytes(path), path).profile
        except RtkitError:
            # A folder of profiles may hold documents of another kind.
            continue
        info = profile.basic_info
        if info is None:
            continue
        language = profile.language.kind if profile.language is not None else ""
        create = CreateString(info.name, info.vendor, info.category, language, info.version)
        module = modules.get(info.name) or property_value(info.properties, MODULE) or ""
        id = f"RTC:{info.vendor}:{info.category}:{info.name}:{info.version}"
        yield id, KnownType(str(create), module)


def _files() -> Iterator[tuple[str, Mapping[str, str]]]:
    """Yield profiles, each with the modules of types where an installed package has it."""
    from rtkit.profile.forms import form_of_name
    from rtkit.resources import resource

    yield from of_packages()
    folders = [f for f in os.environ.get(SEARCH_PATH, "").split(os.pathsep) if f]
    for folder in (resource("profiles"), *folders):
        try:
            names = sorted(os.listdir(folder))
        except OSError:
            continue
        yield from ((os.path.join(folder, name), {}) for name in names if form_of_name(name))
