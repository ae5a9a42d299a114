"""An operator who has two objects change places: ``python switch.py [SERVICE]``.

Every way offered is printed; the first of those that cost least is taken.
"""

from __future__ import annotations

import sys

import rtkit

SITE = (
    "designate object at (3 4) A",
    "designate object at (7 4) B",
    "designate region at (4 5) (5 5) (6 5) X",
    "designate region at (4 4) (6 4) Y",
    "define switch A B X Y = take A to X; go to Y; take B to where A was; take A to where B was",
)


def main(service: str = "table") -> None:
    """Switch A and B."""
    with rtkit.connect() as tree:
        desk = tree.properties

        def say(sentence: str) -> None:
            desk.set(f"{service}.command", sentence)

        for sentence in SITE:
            say(sentence)
        say("switch A B X Y")
        id, text, choices = desk.get(f"{service}.questions.open")[0]
        print(text)
        print(desk.get(f"{service}.questions.{id}.details"))
        desk.set(f"{service}.questions.{id}", choices[0])
        for change in desk.listen(f"{service}.state"):
            if change.value == "idle":
                break
        print(desk.get(f"{service}.said"))


if __name__ == "__main__":
    main(*sys.argv[1:])
