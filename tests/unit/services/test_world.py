"""What the file of a home is refused for."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtkit.errors import InvalidDocument
from rtkit.services.world import HomeWorld


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("3", "the document: expected an object"),
        ('{"walls": 3}', "walls: expected a list"),
        ('{"walls": [3]}', "walls.0: corners are pairs of numbers, not 3"),
        (
            '{"walls": [{"outer": [[0, 0], [1, 0], [0, 1]], "holes": 3}]}',
            "walls.0: holes: expected a list",
        ),
        ('{"walls": [{"inner": []}]}', "walls.0: no such key: inner"),
        ('{"walls": [{}]}', "walls.0: a ring needs three corners that enclose an area, not []"),
        ('{"rooms": []}', "rooms: expected an object"),
        ('{"rooms": {"hall": 3}}', "rooms.hall: corners are pairs of numbers, not 3"),
        ('{"objects": {"ball": 3}}', "objects.ball: expected an object"),
    ],
)
def test_a_file_that_is_no_home_is_refused_with_the_place(
    tmp_path: Path, text: str, why: str
) -> None:
    file = tmp_path / "home.json"
    file.write_text(text)
    with pytest.raises(InvalidDocument) as refused, HomeWorld(file=str(file)):
        pass
    assert str(refused.value) == f"{file}: {why}"
