"""Arguments of a class that rtserve calls fit its annotations, or are refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtkit.cli.properties.served_object import made
from rtkit.errors import Malformed, RtkitError

LAMP = """
import typing, rtkit
Part = typing.Annotated[float, rtkit.Range(0, 1)]
class Lamp:
    def __init__(
        self, level: float = 1.0, *, name: str = "", steps: int = 3, colour=None, part: Part = 1
    ):
        self.given = (level, name, steps, colour)

class Open:
    def __init__(self, *names, **more):
        self.given = (names, more)
"""


@pytest.fixture
def lamps(tmp_path: Path) -> str:
    file = tmp_path / "lamps.py"
    file.write_text(LAMP)
    return str(file)


@pytest.mark.parametrize(
    ("arguments", "given"),
    [
        (["2"], (2.0, "", 3, None)),
        (["level=2", "name=5", "colour=(1 2)"], (2.0, "5", 3, [1, 2])),
        (["name=north (upper", "steps=4"], (1.0, "north (upper", 4, None)),
    ],
)
def test_arguments_are_what_annotations_say(
    lamps: str, arguments: list[str], given: tuple[object, ...]
) -> None:
    lamp = made(f"{lamps}:Lamp", arguments)
    assert vars(lamp)["given"] == given
    assert isinstance(vars(lamp)["given"][0], float)


@pytest.mark.parametrize(
    ("argument", "why"),
    [
        ("level=lots", "cannot be read: level=lots: expected float, found word lots"),
        ("steps=1.5", "cannot be read: steps=1.5: expected int, found number 1.5"),
        ("lots", "cannot be read: lots: expected float, found word lots"),
        ("part=2", "cannot be read: part=2: 2 is above 1 (part of "),
        ("stepz=1", "takes no argument stepz (did you mean steps?)"),
    ],
)
def test_an_argument_that_does_not_fit_is_refused(lamps: str, argument: str, why: str) -> None:
    with pytest.raises(Malformed) as refused:
        made(f"{lamps}:Lamp", [argument])
    assert why in str(refused.value)


def test_a_class_that_takes_anything_gets_it(lamps: str) -> None:
    assert vars(made(f"{lamps}:Open", ["1", "a=b"]))["given"] == ((1,), {"a": "b"})


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ([], "missing a required argument: 'a' (it takes a b=2 c=3)"),
        (["1", "2", "3"], "too many positional arguments (it takes a b=2 c=3)"),
        (["1", "a=2"], "multiple values for argument 'a' (it takes a b=2 c=3)"),
        (["1", "x"], "cannot be read: x: expected int, found word x (b of {})"),
    ],
)
def test_wrong_arguments_are_told_by_their_parameters(
    tmp_path: Path, arguments: list[str], why: str
) -> None:
    file = tmp_path / "pair.py"
    text = "class Pair:\n    def __init__(self, a: int, b: int = 2, *, c: int = 3) -> None: ...\n"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(RtkitError) as refused:
        made(f"{file}:Pair", arguments)
    assert str(refused.value).removeprefix(f"{file}:Pair: ") == why.format(f"{file}:Pair")
