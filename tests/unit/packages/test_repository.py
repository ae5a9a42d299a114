"""Repositories as they are named: no secret goes where others see it."""

from __future__ import annotations

import pytest

from rtkit.errors import Refused
from rtkit.packages.repository import opened


@pytest.mark.parametrize(
    "address",
    [
        "https://anna:hunter2@example.org/simple", "http://hunter2@example.org/simple",
        "git+https://hunter2@example.org/p.git@v1", "git+ssh://git:hunter2@example.org/p.git",
    ],
)  # fmt: skip
def test_a_secret_in_the_address_of_a_repository_is_refused(address: str) -> None:
    """Whoever runs ps would see it, since pip and git are given it as an argument."""
    with pytest.raises(Refused, match="secret in the address") as found, opened([address]):
        pass
    assert "hunter2" not in str(found.value)
    assert "netrc" in str(found.value)
