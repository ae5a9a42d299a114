"""Pictures of four tasks, planned and done in one process: ``python -m manipulation.pictures DIR``.

They are the same each time: no clock, no process, one seed.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from manipulation import drawing, store
from manipulation.dialogue import Dialogue
from manipulation.sites import site_named
from manipulation.table import Table, table_of

SCENES: Mapping[str, tuple[str, Sequence[str]]] = {
    "switch": (
        "switch",
        (
            "designate object at (3 4) A",
            "designate object at (7 4) B",
            "designate region at (4 5) (5 5) (6 5) X",
            "designate region at (4 4) (6 4) Y",
            "define switch A B X Y = take A to X; go to Y; take B to where A was;"
            " take A to where B was",
            "switch A B X Y",
        ),
    ),
    "doorway": (
        "doorway",
        (
            "designate object at (3 3) (3 4) A",
            "designate object at (6 4) B1",
            "designate object at (6 3) B2",
            "designate region at (5 1) (5 6) (4 1) (4 6) aside",
            "take A to (9 3) clearing into aside",
        ),
    ),
    "light-switch": (
        "room",
        (
            "designate object at (3 3) red block",
            "designate object at (8 5) cup",
            "designate bar at (2 6) (3 6) rod",
            "designate place at (10 7) light switch",
            "take the red block near the light switch",
        ),
    ),
    "unknown": ("corridor", ("go to (9 2)",)),
}
"""Site and sentences of each; the last sentence is the task whose planning is drawn."""


def perform(dialogue: Dialogue, table: Table) -> None:
    """Have all orders done that the dialogue gives."""
    table.speed = 2.0
    while (order := dialogue.order) is not None:
        table.take(order)
        while table.order is not None:
            table.tick(0.02)
        dialogue.see(table.report)


def dialogue_of(scene: str) -> tuple[Dialogue, Table]:
    """Return a dialogue in which the sentences of a scene were said, and the table it is about."""
    site, sentences = SCENES[scene]
    table = table_of(site_named(site), seed=1)
    dialogue = Dialogue(store.site_of(site_named(site)))
    dialogue.see(table.report)
    for sentence in sentences:
        dialogue.hear(sentence)
    return dialogue, table


def drawn() -> Iterator[tuple[str, str]]:
    """Yield each picture: its name, and SVG."""
    for scene in SCENES:
        dialogue, table = dialogue_of(scene)
        if scene == "unknown":
            perform(dialogue, table)
            yield f"{scene}-felt", drawing.picture(dialogue, "site")
            dialogue.answer(next(iter(dialogue.asked)), "box")
            yield f"{scene}-way", drawing.picture(dialogue, "way")
            continue
        for which in drawing.TITLES:
            yield f"{scene}-{which}", drawing.picture(dialogue, which)


def main(folder: str = ".") -> None:
    """Write all pictures into a folder."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    for name, svg in drawn():
        (Path(folder) / f"{name}.svg").write_text(svg, encoding="utf-8")
        print(Path(folder) / f"{name}.svg")


if __name__ == "__main__":
    main(*sys.argv[1:])
