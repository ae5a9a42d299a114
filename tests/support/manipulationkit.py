"""Dialogues about a simulated table, in one process and without waiting."""

from __future__ import annotations

import json

from manipulation import store
from manipulation.dialogue import Dialogue
from manipulation.sites import sites
from manipulation.table import Table, table_of

SITES = sites()
SWITCH = (
    "designate object at (3 4) A",
    "designate object at (7 4) B",
    "designate region at (4 5) (5 5) (6 5) X",
    "designate region at (4 4) (6 4) Y",
    "define switch A B X Y = take A to X; go to Y; take B to where A was; take A to where B was",
)
DOORWAY = (
    "designate object at (3 3) (3 4) A",
    "designate object at (6 4) B1",
    "designate object at (6 3) B2",
    "designate region at (5 1) (5 6) (4 1) (4 6) aside",
)


class Bench:
    """A dialogue at a table; orders are done at once.

    Attributes:
        ordered: What was ordered, kind by kind.
    """

    def __init__(self, site: str, *sentences: str, seed: int = 1) -> None:
        self.table: Table = table_of(SITES[site], seed=seed)
        self.table.speed = 2.0
        self.dialogue: Dialogue = Dialogue(store.site_of(SITES[site]))
        self.ordered: list[str] = []
        self.dialogue.see(self.table.report)
        self.say(*sentences)

    def say(self, *sentences: str) -> str:
        for sentence in sentences:
            self.dialogue.hear(sentence)
        return self.dialogue.said

    def answer(self, text: str, id: str = "") -> str:
        self.dialogue.answer(id or next(iter(self.dialogue.asked)), text)
        return self.dialogue.said

    def step(self, *, is_seen: bool = True) -> bool:
        """Have one order done; return whether there was one."""
        order = self.dialogue.order
        if order is None:
            return False
        self.ordered.append(order.kind)
        self.table.take(order)
        while self.table.order is not None:
            self.table.tick(0.02)
        if is_seen:
            self.dialogue.see(self.table.report)
        return True

    def run(self) -> str:
        """Have orders done until none is left; return what was said last."""
        while self.step():
            pass
        return self.dialogue.said

    def restart(self) -> None:
        """Have the dialogue killed, and begun again from what it had kept."""
        kept = json.loads(json.dumps(store.saved(self.dialogue)))
        self.dialogue = store.restored(kept)
        self.dialogue.see(self.table.report)

    @property
    def costs(self) -> list[float]:
        return [each.way.cost for each in self.dialogue.shown]

    def lies(self, thing: str) -> tuple[float, float]:
        """Return where a thing really is [places]."""
        x, y = self.table.things[thing].at
        return round(x * 10, 3), round(y * 10, 3)
