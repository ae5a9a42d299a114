"""``rtreset``: reset components."""

from __future__ import annotations

from rtkit.cli.components.transitions import state_command
from rtkit.rtc.enums import Transition

main = state_command(
    "rtreset",
    Transition.RESET,
    "Reset components: Error to Inactive.",
    "\n\nA dead component that waits for its restart, or was given up, is made again at once,"
    " Inactive; its earlier ends are forgiven.",
    examples=(
        ("rtreset /localhost/Robot0.rtc", "Bring a component out of Error."),
        ("rtreset --no-wait /localhost/Robot0.rtc", "Without waiting for it."),
    ),
    arguments=("faulty",),
)
