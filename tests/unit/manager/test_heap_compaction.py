"""What is allocated after gaps were filled lies in memory of its own."""

from __future__ import annotations

import pytest

from rtkit.manager.slaves.warm_up import fill_gaps

POOL = 16 * 1024


@pytest.mark.parametrize("size", [40, 200, 400])
def test_new_objects_lie_together(size: int) -> None:
    scattered = [bytes(size) for _ in range(3000)]
    del scattered[::7]
    filling = fill_gaps()
    made = [bytes(size) for _ in range(20)]
    assert filling
    assert len({id(each) // POOL for each in made}) <= 2
