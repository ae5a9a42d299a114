"""Has the ids of a system profile choose among packages: installed ones, else of repositories."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit.api.package_hosts import PackageHosts
from rtkit.api.system_profiles import BUNDLE
from rtkit.deployment.packages import NO_PACKAGES, Installer, Packages
from rtkit.fast_dataclass import replace
from rtkit.modules.package_folders import folders, root
from rtkit.rtc.names import LOCAL

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.system import KnownType
    from rtkit.packages.records import Installed, Offering, Survey
    from rtkit.packages.wheel_target import WheelTarget
    from rtkit.profile.rts_model import ComponentInstance


class Packaged(NamedTuple):
    """A profile whose components name their versions, and the packages that they need.

    Attributes:
        types: How types are made, by their ids, where the profile does not say it.
        lacks: By component, why a package that offers its type cannot be installed.
    """

    document: SystemProfile
    packages: Packages
    types: dict[str, KnownType]
    lacks: Mapping[str, str]


def bundled(
    session: Session, document: SystemProfile, snapshot: Snapshot, *, installs: bool
) -> Packaged:
    """Return a profile as `unpackaged`; of a bundle what its hosts lack is installed before.

    Raises:
        RtkitError: See `supplied`; a package cannot be installed.
    """
    if not document.source.endswith(BUNDLE):
        return unpackaged(session, document, snapshot)
    found = supplied(session, document, snapshot, is_dry=not installs)
    hosts = PackageHosts(session, document, snapshot)
    needed = (f"{hosts.host_of(name)}/{text}" for name, text in found.packages.of.items())
    for each in dict.fromkeys(needed) if installs else ():
        found.packages.installer.install(each)
        session.verbose(f"{each} is installed")
    return found


def unpackaged(session: Session, document: SystemProfile, snapshot: Snapshot) -> Packaged:
    """Return a profile whose components on this host name the versions that their ids choose.

    Nothing is to be installed for it.

    Raises:
        Unreachable: The manager does not answer.
    """
    from rtkit.api.component_profiles import known_types

    if next(folders(), None) is not None:
        from rtkit.packages.offering import offerings

        hosts = PackageHosts(session, document, snapshot)
        types = hosts.types_on(LOCAL)
        found = offerings({*types.values()})
        chosen = {name: found[id] for name, id in types.items() if id in found}
        document = _chosen(_Asking(hosts), document, chosen)
    return Packaged(document, NO_PACKAGES, known_types(document.profile, snapshot), {})


def supplied(
    session: Session, document: SystemProfile, snapshot: Snapshot, *, is_dry: bool = True
) -> Packaged:
    """Return a profile, and which packages are to be installed for it; nothing is installed.

    What neither lives nor can be made is looked for in the bundle that the profile is of, else in
    the repositories of the settings; for another host also among what is installed here.

    Raises:
        Unreachable: The manager does not answer.
        NotFound: There is no such repository.
        Refused: The bundle has changed.
    """
    from rtkit.api.component_profiles import known_types

    hosts = PackageHosts(session, document, snapshot)
    asking = _Asking(hosts)
    places = _repositories(document)
    types = known_types(document.profile, snapshot)
    surveys = {host: hosts.survey(host, notes=not is_dry) for host in hosts.names}
    found: dict[str, Sequence[Offering]] = {}
    pending: dict[str, str] = {}
    for host, survey in surveys.items():
        there = hosts.types_on(host)
        found |= {n: survey.offers[id] for n, id in there.items() if id in survey.offers}
        if places or host != LOCAL:
            pending |= asking.pending(types, host, survey)
    near, far = ({n for n in (*found, *pending) if (n in hosts.far) is x} for x in (False, True))
    types = _known_types(document, {n: found[n][0] for n in near & {*found}}) | types
    chosen, lacks = _supply(pending, hosts, places)
    found |= {name: [each] for name, each in chosen.items()}
    types |= _known_types(document, {n: chosen[n] for n in near & {*chosen}})
    document = _chosen(asking, document, found, far)
    sound = {name: each.package for name, each in chosen.items() if name not in lacks}
    if not sound and not any(each.surplus for each in surveys.values()):
        return Packaged(document, NO_PACKAGES, types, lacks)
    digests = {f"{hosts.host_of(n)}/{each.text}": each.wheels for n, each in sound.items()}
    for package, wheels in digests.items():
        session.verbose(f"{package}: {', '.join(wheels)}")
    installer = _installer(places, digests, hosts)
    of = {name: each.text for name, each in sound.items()}
    return Packaged(document, _packages(surveys, of, digests, installer), types, lacks)


def _packages(
    surveys: Mapping[str, Survey],
    of: Mapping[str, str],
    digests: Mapping[str, Mapping[str, str]],
    installer: Installer,
) -> Packages:
    surplus = {
        f"{host}/{text}": folder
        for host, survey in surveys.items()
        for text, folder in survey.surplus.items()
    }
    needed = {each.partition("/")[2] for each in digests}
    there = {
        f"{host}/{text}"
        for host, survey in surveys.items()
        for text in survey.installed
        if text in needed or text in survey.surplus
    }
    return Packages(of, frozenset(there), digests, surplus, installer)


def leftover(session: Session, document: SystemProfile, snapshot: Snapshot) -> Packages:
    """Return the packages that plans installed for a system alone, as it needs them no longer.

    Raises:
        RtkitError: A host cannot be asked.
    """
    hosts = PackageHosts(session, document, snapshot)
    surveys = {host: hosts.leftovers(host) for host in hosts.names}
    return _packages(surveys, {}, {}, _installer((), {}, hosts))


def _supply(
    pending: Mapping[str, str], hosts: PackageHosts, places: Sequence[str]
) -> tuple[dict[str, Offering], dict[str, str]]:
    """Return an offering for each pending component that has one, and why some cannot be had."""
    if not pending:
        return {}, {}
    from rtkit.packages.offering import offerings
    from rtkit.packages.supply import Supply, supply

    wanted = {name: (hosts.host_of(name), id) for name, id in pending.items()}
    # A type of which a package is installed here is pending on other hosts only.
    here = offerings({*pending.values()})
    own = {each: here[each[1]][0] for each in wanted.values() if each[1] in here}
    cannot = {each: _unpushable(own[each].package, hosts.targets.get(each[0])) for each in own}
    asked = [each for each in wanted.values() if cannot.get(each, "none")]
    found = Supply({}, {})
    if asked and places:
        found = supply(asked, hosts.targets, places, hosts.session.warn)
    absent = sorted({id for _, id in {*asked} - {*found.found, *own}}) if places else ()
    looked = ", ".join(places)
    hosts.session.warn(f"no installed package has {each}, and none of {looked}" for each in absent)
    all = own | found.found
    lacks = {e: why for e, why in cannot.items() if why and e not in found.found} | found.lacks
    chosen = {name: all[each] for name, each in wanted.items() if each in all}
    return chosen, {name: lacks[each] for name, each in wanted.items() if each in lacks}


def _unpushable(package: Installed, target: WheelTarget | None) -> str:
    """Return why a package that is installed here cannot be brought to another host."""
    from rtkit.errors import RtkitError
    from rtkit.packages.bundling import pushable

    if target is not None and not target.kind.fits(package.wheels):
        return f"{package.text} is installed here by wheels that do not fit {target.kind.name}"
    try:
        pushable(package.text, (), package.wheels, "")
    except RtkitError as error:
        return str(error)
    return ""


def _installer(
    places: Sequence[str], digests: Mapping[str, Mapping[str, str]], hosts: PackageHosts
) -> Installer:
    from rtkit.packages.supply import LocalInstaller

    near = LocalInstaller(places, digests, hosts.session.timeout_s, hosts.document.profile.id)
    if hosts.names == (LOCAL,):
        return near
    from rtkit.hosts.package_installer import HostsInstaller
    from rtkit.hosts.progress import by_lines
    from rtkit.packages.bundling import pushable

    def wheels(package: str, folder: str, target: WheelTarget) -> Mapping[str, Sequence[str]]:
        name = package.partition("/")[2]
        return pushable(name, places, digests[package], folder, target)

    bare = {host for host in hosts.names if not hosts.is_up(host)}
    return HostsInstaller(near, wheels, bare, by_lines(hosts.session.verbose))


def _repositories(document: SystemProfile) -> Sequence[str]:
    from rtkit.packages.precheck import known_repositories

    is_bundle = document.source.endswith(BUNDLE)
    return [document.source] if is_bundle else known_repositories()


def _chosen(
    asking: _Asking,
    document: SystemProfile,
    found: Mapping[str, Sequence[Offering]],
    stated: Collection[str] = (),
) -> SystemProfile:
    if not found:
        return document
    from rtkit.packages.offering import chosen

    return replace(document, profile=chosen(document.profile, found, asking.offers, stated))


def _known_types(document: SystemProfile, chosen: Mapping[str, Offering]) -> dict[str, KnownType]:
    from rtkit.deployment.system import KnownType
    from rtkit.rtc.create import CreateString

    found = {}
    for each in document.profile.components:
        offering = chosen.get(each.instance_name)
        if offering is not None:
            kind = offering.type
            create = CreateString(
                kind.type_name, kind.vendor, kind.category, kind.language, kind.version
            )
            found[each.id] = KnownType(str(create), offering.module)
    return found


class _Asking:
    """Asks managers what they can make; one that does not run is as one started there."""

    def __init__(self, hosts: PackageHosts) -> None:
        self._hosts = hosts
        self._known: dict[tuple[str, str, str], bool] = {}

    def offers(self, component: str, module: str, create: str) -> bool:
        """Return whether a module makes a type where a component is to be."""
        asked = (self._hosts.host_of(component), module, create)
        if asked not in self._known:
            ((_, why),) = self._lacking(asked[0], {component: (module, create)})
            self._known[asked] = not why
        return self._known[asked]

    def pending(self, known: Mapping[str, KnownType], host: str, survey: Survey) -> dict[str, str]:
        """Return the types of components that do not live and cannot be made, by their names."""
        from rtkit.deployment.described import type_of
        from rtkit.packages.precheck import is_built_in

        removed = {*self._removed()} if host == LOCAL else set()
        asked: dict[str, tuple[str, str]] = {}
        pending: dict[str, str] = {}
        for each in filter(self._hosts.is_fresh, self._hosts.components_on(host)):
            id, name = type_of(each.id).id, each.instance_name
            if id in survey.offers or (host != LOCAL and is_built_in(each)):
                continue
            making = _making(each, known)
            pending[name] = id
            if making is not None and id not in removed:
                asked[name] = making
        for name, why in self._lacking(host, asked):
            if not why:
                del pending[name]
        return pending

    def _removed(self) -> Iterator[str]:
        """Yield the types of loaded modules whose package was removed: no slave finds them."""
        here = self._hosts.snapshot
        for each in (each for one in (here, *here.others) for each in one.modules):
            if each.file.startswith(f"{root()}/") and not os.path.exists(each.file):
                yield from (type.id for type in each.types)

    def _lacking(
        self, host: str, asked: Mapping[str, tuple[str, str]]
    ) -> Iterator[tuple[str, str]]:
        """Yield components with why they cannot be made as is asked; empty where they can."""
        here = self._hosts.snapshot
        managers = {n: here if host == LOCAL else self._hosts.managers[n] for n in asked}
        for manager in {each.manager: each for each in managers.values()}.values():
            mine = [name for name in asked if managers[name].manager == manager.manager]
            yield from zip(mine, self._lacks(host, manager, [asked[n] for n in mine]), strict=True)

    def _lacks(
        self, host: str, manager: Snapshot, asked: Sequence[tuple[str, str]]
    ) -> Sequence[str]:
        """Return for each module and type why a manager does not make it; empty where it does."""
        if manager.pid:
            return self._hosts.session.tree.at(manager.manager).lacking(asked)
        if host != LOCAL:
            return ["not known"] * len(asked)
        import json

        from rtkit.api.component_profiles import load_path
        from rtkit.modules.creatable import lacking
        from rtkit.modules.search import Search

        search = Search([os.curdir, *load_path(self._hosts.session.verbose)])
        found = json.loads(lacking(json.dumps(asked), (), search, is_search_allowed=True))
        return [str(each) for each in found]


def _making(component: ComponentInstance, known: Mapping[str, KnownType]) -> tuple[str, str] | None:
    """Return module and create string of a component; None where nothing tells how it is made."""
    from rtkit.deployment.described import properties_of
    from rtkit.deployment.extension import CREATE, MODULE

    own = properties_of(component.properties)
    if CREATE in own:
        return own.get(MODULE, ""), own[CREATE].partition("?")[0]
    type = known.get(component.id)
    return (type.module, type.create) if type is not None else None
