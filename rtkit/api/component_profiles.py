"""Finds RTC profiles of components on this host, and the types that they make known."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from rtkit.errors import NotFound, RtkitError

if TYPE_CHECKING:
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.system import KnownType
    from rtkit.profile.rts_model import RtsProfile

MODULE_PATH = "RTKIT_MODULE_PATH"
SEARCH_PATH = "RTKIT_PROFILE_PATH"
"""Folders of RTC profiles, beside those that ship with rtkit."""
_LOAD_PATHS = ("manager.modules.load_path", "manager.modules.Python.load_paths")
_MODULE = ".py"
_USUAL = "RTC"
_COMPONENTS = "rtc"
_HEAD = 8192
_MOST = 16 * 2**20


def profiles(
    paths: Sequence[str],
    notify: Callable[[str], object],
    *,
    systems: Sequence[str] = (),
    with_shipped: bool = True,
) -> Iterator[tuple[str, bytes]]:
    """Yield name and content of files that may be RTC profiles, each file once.

    Named files and folders, with all below them, come first, shipped ones last. No
    code is run: of a module only a file beside it counts, of the same name or ``RTC.xml``.
    Modules are looked for where a manager that is started here would, in installed packages last.
    Of the repositories in which `systems` lie ``rtc/NAME/RTC.xml`` counts. `notify` receives
    unreadable places.

    Raises:
        NotFound: A file or folder that was named cannot be read.
    """
    from rtkit.profile.forms import may_be_component

    seen: set[str] = set()
    for path, is_named in _candidates(paths, notify, systems, with_shipped):
        real = os.path.realpath(path)
        if real in seen:
            continue
        seen.add(real)
        try:
            with open(path, "rb") as stream:
                head = stream.read(_HEAD)
                if may_be_component(head):
                    yield path, head + stream.read(_MOST)
        except OSError as error:
            if is_named:
                raise NotFound(f"cannot read {path}: {error.strerror}") from error


def _candidates(
    paths: Sequence[str],
    notify: Callable[[str], object],
    systems: Sequence[str],
    with_shipped: bool,
) -> Iterator[tuple[str, bool]]:
    for path in paths:
        if os.path.isdir(path):
            yield from ((file, False) for file in _below(path))
        else:
            yield path, True
    for folder in _listed(SEARCH_PATH):
        yield from ((os.path.join(folder, name), False) for name in _profiles(folder))
    for folder in (os.curdir, *load_path(notify), *_listed(MODULE_PATH)):
        yield from ((file, False) for file in _beside_modules(folder))
    yield from ((file, False) for file, _ in of_packages())
    for folder in dict.fromkeys(each for system in systems for each in _around(system)):
        yield from ((file, False) for file in _of_repository(folder))
    if with_shipped:
        from rtkit.resources import resource

        shipped = resource("profiles")
        yield from ((os.path.join(shipped, name), False) for name in _profiles(shipped))


def load_path(notify: Callable[[str], object]) -> list[str]:
    """Return the folders of modules that the ``rtc.conf`` found here names."""
    from rtkit.settings.configuration import CommandLineSettings, read

    try:
        settings = read(CommandLineSettings()).settings
    except RtkitError as error:
        notify(f"load paths are not known: {error}")
        return []
    return [folder for key in _LOAD_PATHS for folder in settings.items(key)]


def _listed(variable: str) -> list[str]:
    return [folder for folder in os.environ.get(variable, "").split(os.pathsep) if folder]


def _below(folder: str) -> Iterator[str]:
    for place, folders, _ in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        yield from (os.path.join(place, name) for name in _profiles(place))


def _profiles(folder: str) -> list[str]:
    from rtkit.profile.forms import form_of_name

    try:
        return [name for name in sorted(os.listdir(folder)) if form_of_name(name)]
    except OSError:
        return []


def _beside_modules(folder: str) -> Iterator[str]:
    try:
        modules = {name.removesuffix(_MODULE) for name in os.listdir(folder) if _is_module(name)}
    except OSError:
        return
    for name in _profiles(folder) if modules else ():
        if os.path.splitext(name)[0] in (*modules, _USUAL):
            yield os.path.normpath(os.path.join(folder, name))


def of_packages() -> Iterator[tuple[str, Mapping[str, str]]]:
    """Yield the profiles beside modules of installed packages, with the module of each type."""
    from rtkit.modules.search import installed, versions

    modules: dict[str, dict[str, str]] = {}
    found = {**dict(reversed(versions().items())), **installed()}  # the newest is the last
    for key, each in found.items():
        name = key.partition("==")[0]
        stem, usual = os.path.splitext(each.file)[0], os.path.dirname(each.file)
        for path in (f"{stem}.xml", os.path.join(usual, f"{_USUAL}.xml")):
            types = modules.setdefault(path, {})
            types |= dict.fromkeys((name, os.path.basename(stem)), f"{each.name}:{each.init}")
    yield from ((path, types) for path, types in modules.items() if os.path.isfile(path))


def _around(system: str) -> tuple[str, str]:
    """Return the folder of a system, and the one above: most keep theirs in ``system/``."""
    folder = os.path.dirname(system)
    return folder, os.path.normpath(os.path.join(folder, os.pardir))


def _of_repository(folder: str) -> Iterator[str]:
    components = os.path.join(folder, _COMPONENTS)
    try:
        names = sorted(os.listdir(components))
    except OSError:
        return
    paths = (os.path.normpath(os.path.join(components, n, f"{_USUAL}.xml")) for n in names)
    yield from (path for path in paths if os.path.isfile(path))


def _is_module(name: str) -> bool:
    return name.endswith(_MODULE) and not name.startswith(".")


def known_types(profile: RtsProfile, snapshot: Snapshot) -> dict[str, KnownType]:
    """Return the types of components of `profile` whose creation it does not specify itself.

    Profiles are only read for components that do not live, or another one in their place, and that
    no loaded module makes.
    """
    from rtkit.deployment.described import is_same_id
    from rtkit.deployment.extension import CREATE, stated_id

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
    from rtkit.deployment.system import KnownType
    from rtkit.rtc.create import CreateString

    modules = (module for each in (snapshot, *snapshot.others) for module in each.modules)
    for module in modules:
        for kind in module.types:
            create = CreateString(
                kind.type_name, kind.vendor, kind.category, kind.language, kind.version
            )
            path = f"{module.path}:{module.init}" if module.init else module.path
            yield kind.id, KnownType(str(create), path)


def _described() -> Iterator[tuple[str, KnownType]]:
    from rtkit.deployment.extension import MODULE
    from rtkit.deployment.system import KnownType
    from rtkit.profile.read import read_bytes, read_rtc
    from rtkit.profile.words import property_value
    from rtkit.rtc.create import CreateString

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
    from rtkit.resources import resource

    yield from of_packages()
    for folder in (resource("profiles"), *_listed(SEARCH_PATH)):
        yield from ((os.path.join(folder, name), {}) for name in _profiles(folder))
