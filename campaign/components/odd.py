"""An object whose code goes wrong when it is read, set or called."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))
from campaign.components.misdeeds import MISDEEDS


class Odd:
    """Code of a user behind live properties."""

    well = "well"

    def __init__(self) -> None:
        self.misdeed = "prints"

    def get_mood(self) -> str:
        """Go wrong in a getter."""
        return self.act()

    def set_mood(self, value: str) -> None:
        """Go wrong in a setter."""
        self.act()

    def get_stuck(self) -> str:
        """Go wrong in a getter of its own: requests of one property wait for each other."""
        return self.act()

    def act(self) -> str:
        """Go wrong in an action."""
        return str(MISDEEDS[self.misdeed]())
