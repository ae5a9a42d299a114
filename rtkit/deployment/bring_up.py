"""Plans how a system is brought up, for dry runs and real ones: creations, then all the rest."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from rtkit.deployment.creation import NOTHING_LACKS, creation_plan
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.layered_plan import LayeredPlan
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.system import WantedSystem
from rtkit.deployment.wiring import wiring_plan


def bring_up_plans(
    system: WantedSystem,
    before: Snapshot,
    look: Callable[[], LiveIndex] | None = None,
    *,
    may_create: bool = True,
    lacks: Mapping[str, str] = NOTHING_LACKS,
) -> Iterator[LayeredPlan]:
    """Yield the plan that creates components, then the plan of all the rest.

    `look` returns what lives once the first plan is carried out. Without it, in a dry run, the
    second plan takes for granted that everything was created. `lacks` states why some cannot be.

    Raises:
        RtkitError: A component cannot be made as it is wanted.
    """
    live = LiveIndex(before, system)
    creation = creation_plan(system, live, may_create=may_create, lacks=lacks)
    yield creation
    if look is None:
        yield wiring_plan(system, live, creation.made)
    else:
        yield wiring_plan(system, live if creation.is_done else look())
