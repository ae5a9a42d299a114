"""Has managers of other hosts expect connectors: they let nobody make one that is not expected.

See decision 74.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Protocol

from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.rtc.profiles import ConnectorProfile


class SettableManager(Protocol):
    """Manager whose properties can be set: a `Tree`."""

    def set(self, name: str, value: str) -> object:
        """Set a property, or call an operation."""


@contextmanager
def expected(wanted: Iterable[tuple[SettableManager, ConnectorProfile]]) -> Iterator[list[str]]:
    """Have managers expect connectors that others make inside the block.

    Those whose ids are put into the list, and all if the block fails, they expect no more at its
    end. The connectors are given with both ends named as between managers
    (`rtkit.rtc.far_ends.named_by`).

    Raises:
        Unreachable: One of the managers does not answer.
    """
    from rtkit.rtc.serde import encode_text

    asked: list[tuple[SettableManager, str]] = []
    failed: list[str] = []
    try:
        for tree, connector in wanted:
            asked.append((tree, connector.connector_id))
            tree.set("expect", encode_text(connector))
        yield failed
    except BaseException:
        failed[:] = [connector_id for _, connector_id in asked]
        raise
    finally:
        for tree, connector_id in asked:
            if connector_id in failed:
                with suppress(RtkitError):
                    tree.set("expect_no_more", connector_id)
