"""``rtact``: activate components."""

from __future__ import annotations

from rtkit.cli.components.transitions import state_command
from rtkit.rtc.enums import Transition

main = state_command("rtact", Transition.ACTIVATE, "Activate components: Inactive to Active.")
