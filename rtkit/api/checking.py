"""Compares the live system with a profile."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rtkit.api import looking

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rtkit.api.document import SystemDocument
    from rtkit.api.session import Session
    from rtkit.deployment.deviations import Deviation
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.system import WantedSystem
    from rtkit.rtc.enums import LifeCycleState


class SystemReport(NamedTuple):
    """The wanted system, the live one, and what deviates."""

    system: WantedSystem
    live: LiveIndex
    found: Sequence[Deviation]

    @property
    def holds(self) -> bool:
        """Return whether nothing that is required deviates."""
        return not any(each.is_required for each in self.found)


def compare(
    session: Session,
    document: SystemDocument,
    state: LifeCycleState | None,
    mapped: tuple[str, ...] = (),
) -> SystemReport:
    """Compare what lives with a profile whose components are to be in a state.

    Raises:
        InvalidDocument: The profile makes no sense.
        Unreachable: A manager does not answer.
    """
    from rtkit.api.present_code import present_code
    from rtkit.deployment.deviations import deviations
    from rtkit.deployment.live_index import LiveIndex

    snapshot = looking.look(session, document.profile, dry_run=False)
    system = looking.wanted_system(session, document, snapshot, mapped=mapped)
    live = LiveIndex(snapshot, system)
    present = present_code(snapshot.components)
    return SystemReport(system, live, tuple(deviations(system, live, state, present)))
