"""``rtreset``: reset components."""

from __future__ import annotations

from rtkit.cli._transitions import state_command
from rtkit.rtc.enums import Transition

main = state_command("rtreset", Transition.RESET, "Reset components: Error to Inactive.")
