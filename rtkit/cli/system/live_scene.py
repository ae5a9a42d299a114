"""Draws the live system: the scene of a saved system, with states, zombies and processes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.api import looking
from rtkit.cli.shared.app import App

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts
    from rtkit.drawing.scene import Box, Scene

_FILLS = {"Active": "palegreen", "Inactive": "lightblue", "Error": "tomato", "zombie": "lightgrey"}


def live_scene(app: App, title: str) -> Scene:
    """Return the scene of the live components of the manager, or managers.

    Raises:
        Unreachable: The manager does not answer.
    """
    from rtkit.deployment.capture import SystemHeading, capture
    from rtkit.fast_dataclass import replace
    from rtkit.profile_tools.system_scene import system_scene

    snapshot = looking.snapshot(app)
    # A saved system has no zombies; a drawing shows them.
    shown = tuple(replace(each, zombie="") for each in snapshot.components)
    heading = SystemHeading("1970-01-01T00:00:00", title, "0", "rtkit", "")
    profile = capture(replace(snapshot, components=shown), heading, takes_all=True)
    scene = system_scene(profile)
    facts = {each.instance: each for each in snapshot.components}
    return scene._replace(boxes=tuple(_box(box, facts[box.title]) for box in scene.boxes))


def _box(box: Box, facts: ComponentFacts) -> Box:
    state = "zombie" if facts.zombie else facts.state
    where = " · ".join(filter(None, (box.subtitle, state, facts.process)))
    why = f"zombie ({facts.zombie})" if facts.zombie else facts.trouble or facts.cause
    tip = "\n".join(filter(None, (box.tip, why)))
    return box._replace(
        subtitle=where, tip=tip, fill=_FILLS.get(state, ""), is_dashed=bool(facts.zombie)
    )
