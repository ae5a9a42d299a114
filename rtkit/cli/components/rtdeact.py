"""``rtdeact``: deactivate components."""

from __future__ import annotations

from rtkit.cli.components.transitions import state_command
from rtkit.rtc.enums import Transition

main = state_command(
    "rtdeact",
    Transition.DEACTIVATE,
    "Deactivate components: Active to Inactive.",
    "\n\nA dead component that its policy brings back comes back Inactive.",
    examples=(
        ("rtdeact /localhost/Robot0.rtc", "Stop a component from executing."),
        ("rtdeact -e all /localhost/Robot0.rtc", "In all of its execution contexts."),
    ),
    arguments=("active",),
)
