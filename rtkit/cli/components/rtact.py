"""``rtact``: activate components."""

from __future__ import annotations

from rtkit.cli.components.transitions import state_command
from rtkit.rtc.enums import Transition

main = state_command(
    "rtact",
    Transition.ACTIVATE,
    "Activate components: Inactive to Active.",
    examples=(
        ("rtact /localhost/Robot0.rtc", "Activate one component and wait until it is active."),
        ("rtact -e all /localhost/Robot0.rtc", "In all of its execution contexts."),
        ("rtact A.rtc B.rtc C.rtc", "Several at once, below the working directory of the tree."),
    ),
    arguments=("inactive",),
)
