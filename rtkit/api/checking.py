"""Compares the live system with a profile."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.api import looking
from rtkit.fast_dataclass import dataclass

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.deviations import Deviation
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.system import WantedSystem
    from rtkit.rtc.enums import LifeCycleState


@dataclass(frozen=True, slots=True)
class SystemReport:
    """The deviations of a live system; true when nothing that is required deviates.

    Attributes:
        system: The wanted system.
        live: The live one.
        found: What deviates, as data: kind, path, text, item, wanted, found.
    """

    system: WantedSystem
    live: LiveIndex
    found: tuple[Deviation, ...]

    def __iter__(self) -> Iterator[Deviation]:
        return iter(self.found)

    def __len__(self) -> int:
        return len(self.found)

    def __bool__(self) -> bool:
        return self.holds

    def __str__(self) -> str:
        return "\n".join(each.text for each in self.found) or "everything is as the profile says"

    @property
    def holds(self) -> bool:
        """Return whether nothing that is required deviates."""
        return not any(each.is_required for each in self.found)


def compare(
    session: Session, document: SystemProfile, state: LifeCycleState | None
) -> SystemReport:
    """Compare what lives with a profile; see `rtkit.Tree.check`."""
    from rtkit.api import owning
    from rtkit.api.displaced import remarks, where_they_live
    from rtkit.api.looking import on_this_host, present_code
    from rtkit.api.placing import settled, unmet
    from rtkit.deployment.deviations import deviations
    from rtkit.deployment.live_index import LiveIndex

    stated = settled(session, document)
    session.warn(owning.absent_hosts(stated))
    document = where_they_live(session, stated)
    snapshot = looking.look(session, document, dry_run=False, may_lack=True)
    system = looking.wanted_system(session, document, snapshot)
    live = LiveIndex(snapshot, system)
    present = present_code(on_this_host(snapshot))
    broken = {**remarks(stated, document), **unmet(session, document)}
    return SystemReport(system, live, tuple(deviations(system, live, state, present, broken)))
