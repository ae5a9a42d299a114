"""Has the ids of a system profile choose among the versions of installed packages."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rtkit.api.system_profiles import BUNDLE
from rtkit.fast_dataclass import replace
from rtkit.modules.package_folders import folders

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.facts import Snapshot


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
    if next(folders(), None) is None:
        return document
    from rtkit.deployment.described import type_of
    from rtkit.packages.offering import chosen, offerings

    found = offerings({type_of(each.id).id for each in document.profile.components})
    if not found:
        return document
    known: dict[tuple[str, str], bool] = {}

    def offers(module: str, create: str) -> bool:
        asked = (module, create)
        if asked not in known:
            known[asked] = not _lack(session, snapshot, module, create)
        return known[asked]

    return replace(document, profile=chosen(document.profile, found, offers))


def _lack(session: Session, snapshot: Snapshot, module: str, create: str) -> str:
    """Return why a module does not make a type; one that does not run is as one started here."""
    if snapshot.pid:
        return session.tree.at(snapshot.manager).lacking([(module, create)])[0]
    import json

    from rtkit.api.component_profiles import load_path
    from rtkit.modules.creatable import lacking
    from rtkit.modules.search import Search

    search = Search([os.curdir, *load_path(session.verbose)])
    question = json.dumps([(module, create)])
    (why,) = json.loads(lacking(question, (), search, is_search_allowed=True))
    return str(why)
