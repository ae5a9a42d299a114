"""Compacts the heap of slaves: new objects lie together, apart from the pages of the zygote.

A page that a slave writes to becomes its own, and is copied first. What it allocates would go into
gaps all over the memory that it has in common with the others; where those are filled, it goes to
new pages, of which it needs but few.

See decision 49.
"""

from __future__ import annotations

_LARGEST, _STEP = 512, 16
"""Of what sizes Python keeps gaps in pools of one size each [bytes]."""

_HEAD = 33
"""What an object of bytes needs beside them [bytes]."""

_RUN = 8
"""So many objects one behind the other lie in a pool that was empty."""

_MOST = 1024
"""How many gaps of one size are filled at most, should the allocator be another one."""


def fill_gaps() -> list[bytes]:
    """Return what now lies where objects were; it is to be kept."""
    filling: list[bytes] = []
    for size in range(_HEAD // _STEP * _STEP + _STEP, _LARGEST + 1, _STEP):
        filled: list[bytes] = []
        while len(filled) < _MOST and not _is_run(filled[-_RUN:], size):
            filled.append(bytes(size - _HEAD))
        filling += filled[:-_RUN]
    return filling


def _is_run(last: list[bytes], size: int) -> bool:
    places = [id(each) for each in last]
    return len(places) == _RUN and places == list(range(places[0], places[0] + _RUN * size, size))
