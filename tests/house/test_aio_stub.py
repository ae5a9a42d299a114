"""The types of `rtkit.aio` are those of `rtkit.Tree`, awaited."""

from __future__ import annotations

import make_aio_stub

from rtkit import aio
from rtkit.api.tree import Tree


def test_the_stub_is_up_to_date() -> None:
    assert make_aio_stub.STUB.read_text(encoding="utf-8") == make_aio_stub.text(), (
        "stale, write it anew with: python tools/make_aio_stub.py"
    )


def test_each_method_of_a_tree_is_awaited() -> None:
    for name in aio.waits(Tree):
        assert getattr(aio.AsyncTree, name).__doc__ == getattr(Tree, name).__doc__, name
