"""Has the ids of a system profile choose among packages: installed ones, else of repositories."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit.api.system_profiles import BUNDLE
from rtkit.deployment.packages import NO_PACKAGES, Packages
from rtkit.errors import Unreachable
from rtkit.fast_dataclass import replace
from rtkit.modules.package_folders import folders, root

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.system import KnownType
    from rtkit.packages.installed import Installed
    from rtkit.packages.offering import Offering
    from rtkit.profile.rts_model import ComponentInstance


class Packaged(NamedTuple):
    """A profile whose components name their versions, and the packages that they need.

    Attributes:
        types: How types are made that packages offer which are not installed yet.
        lacks: By component, why a package that offers its type cannot be installed.
    """

    document: SystemProfile
    packages: Packages
    types: dict[str, KnownType]
    lacks: Mapping[str, str]


def by_id(
    session: Session, document: SystemProfile, snapshot: Snapshot, *, installs: bool = False
) -> SystemProfile:
    """Return a profile whose components name the versions that their ids choose.

    Of a bundle what is missing is installed before, where that is allowed.

    Raises:
        Unreachable: The manager does not answer.
        Refused: The bundle has changed.
    """
    if installs and document.source.endswith(BUNDLE):
        from rtkit.packages.installed import install_bundle

        for each in install_bundle(document.source):
            session.verbose(f"{each.text} is installed")
    return _chosen(_Asking(session, snapshot), document, _installed(document))


def supplied(
    session: Session, document: SystemProfile, snapshot: Snapshot, *, is_dry: bool = True
) -> Packaged:
    """Return a profile, and which packages are to be installed for it; nothing is installed.

    What neither lives nor can be made is looked for in the bundle that the profile is of, else in
    the repositories of the settings.

    Raises:
        Unreachable: The manager does not answer.
        NotFound: There is no such repository.
        Refused: The bundle has changed.
    """
    asking = _Asking(session, snapshot)
    found = _installed(document)
    places = _repositories(document)
    pending = asking.pending(document, found) if places else {}
    gone = _surplus(session, document, snapshot, found, is_dry=is_dry)
    if not pending and not gone:
        return Packaged(_chosen(asking, document, found), NO_PACKAGES, {}, {})
    from rtkit.deployment.planning.model import HERE
    from rtkit.packages.supply import LocalInstaller, Supply, here, supply

    chosen, lacks = (
        supply(list(pending.values()), places, lambda text: session.warn([text]))
        if pending
        else Supply({}, {})
    )
    absent = sorted({*pending.values()} - {*chosen})
    looked = ", ".join(places)
    session.warn(f"no installed package has {each}, and none of {looked}" for each in absent)
    all = found | {id: [each] for id, each in chosen.items()}
    sound = {id: each for id, each in chosen.items() if id not in lacks}
    of = {name: chosen[id].package.text for name, id in pending.items() if id in sound}
    digests = {each.package.text: each.package.wheels for each in sound.values()}
    installer = LocalInstaller(places, digests, session.timeout_s, document.profile.id)
    there = here([*digests]) | {each.text for each in gone}
    packages = Packages(
        of,
        frozenset(f"{HERE}/{each}" for each in there),
        digests,
        {f"{HERE}/{each.text}": os.path.realpath(each.path) for each in gone},
        installer,
    )
    types = _known_types(document, chosen)
    why = {name: lacks[id] for name, id in pending.items() if id in lacks}
    return Packaged(_chosen(asking, document, all), packages, types, why)


def unpackaged(session: Session, document: SystemProfile, snapshot: Snapshot) -> Packaged:
    """Return a profile for which nothing is to be installed; see `by_id`."""
    return Packaged(by_id(session, document, snapshot), NO_PACKAGES, {}, {})


def _installed(document: SystemProfile) -> dict[str, list[Offering]]:
    if next(folders(), None) is None:
        return {}
    from rtkit.deployment.described import type_of
    from rtkit.packages.offering import offerings

    return offerings({type_of(each.id).id for each in document.profile.components})


def _surplus(
    session: Session,
    document: SystemProfile,
    snapshot: Snapshot,
    found: Mapping[str, Sequence[Offering]],
    *,
    is_dry: bool,
) -> list[Installed]:
    """Return what was installed for a system that needs it no longer; note what it needs.

    What a manager beside those of the system uses, or may use, is none of it.
    """
    if next(folders(), None) is None:
        return []
    from rtkit.packages.needing import note_needed, surplus
    from rtkit.packages.usage import users

    needed = {each[0].package.text for each in found.values()}
    if not is_dry:
        note_needed(document.profile.id, needed)
    own = {each.manager for each in (snapshot, *snapshot.others)}
    gone = surplus(document.profile.id, needed)
    try:
        return [each for each in gone if own.issuperset(users(each, session.timeout_s))]
    except Unreachable as error:
        session.verbose(f"packages that nothing uses are not removed: {error}")
        return []


def _repositories(document: SystemProfile) -> Sequence[str]:
    from rtkit.packages.repository import known_repositories

    is_bundle = document.source.endswith(BUNDLE)
    return [document.source] if is_bundle else known_repositories()


def _chosen(
    asking: _Asking, document: SystemProfile, found: Mapping[str, Sequence[Offering]]
) -> SystemProfile:
    if not found:
        return document
    from rtkit.packages.offering import chosen

    return replace(document, profile=chosen(document.profile, found, asking.offers))


def _known_types(document: SystemProfile, chosen: Mapping[str, Offering]) -> dict[str, KnownType]:
    from rtkit.deployment.described import type_of
    from rtkit.deployment.system import KnownType
    from rtkit.rtc.create import CreateString

    found = {}
    for id in {each.id for each in document.profile.components}:
        offering = chosen.get(type_of(id).id)
        if offering is not None:
            kind = offering.type
            create = CreateString(
                kind.type_name, kind.vendor, kind.category, kind.language, kind.version
            )
            found[id] = KnownType(str(create), offering.module)
    return found


class _Asking:
    """Asks a manager what it can make; one that does not run is as one started here."""

    def __init__(self, session: Session, snapshot: Snapshot) -> None:
        self._session = session
        self._snapshot = snapshot
        self._managers = (snapshot, *snapshot.others)
        self._known: dict[tuple[str, str], bool] = {}

    def offers(self, module: str, create: str) -> bool:
        """Return whether a module makes a type."""
        asked = (module, create)
        if asked not in self._known:
            self._known[asked] = not self._lacks([asked])[0]
        return self._known[asked]

    def pending(self, document: SystemProfile, found: Iterable[str]) -> dict[str, str]:
        """Return the types of components that do not live and cannot be made, by their names."""
        from rtkit.api.component_profiles import known_types
        from rtkit.deployment.described import is_same_id, type_of
        from rtkit.deployment.extension import STAND_IN, stated_id

        alive = {c.instance: stated_id(c) for c in self._snapshot.components if not c.zombie}
        known = known_types(document.profile, self._snapshot)
        known_ids, removed = {*found}, {*self._removed()}
        asked: dict[str, tuple[str, str]] = {}
        pending: dict[str, str] = {}
        for each in document.profile.components:
            id, name = type_of(each.id).id, each.instance_name
            is_stand_in = any(item.name == STAND_IN for item in each.properties)
            if is_stand_in or id in known_ids or is_same_id(alive.get(name, ""), each.id):
                continue
            making = _making(each, known)
            pending[name] = id
            if making is not None and id not in removed:
                asked[name] = making
        for name, why in zip(asked, self._lacks([*asked.values()]), strict=True):
            if not why:
                del pending[name]
        return pending

    def _removed(self) -> Iterator[str]:
        """Yield the types of loaded modules whose package was removed: no slave finds them."""
        for each in (each for one in self._managers for each in one.modules):
            if each.file.startswith(f"{root()}/") and not os.path.exists(each.file):
                yield from (type.id for type in each.types)

    def _lacks(self, asked: Sequence[tuple[str, str]]) -> Sequence[str]:
        """Return for each module and type why it is not made; empty where it is."""
        if not asked:
            return ()
        if self._snapshot.pid:
            return self._session.tree.at(self._snapshot.manager).lacking(asked)
        import json

        from rtkit.api.component_profiles import load_path
        from rtkit.modules.creatable import lacking
        from rtkit.modules.search import Search

        search = Search([os.curdir, *load_path(self._session.verbose)])
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
