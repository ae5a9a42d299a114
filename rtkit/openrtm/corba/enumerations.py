"""Enumerations as omniORB has them: items with a name and a number, in the scope around them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum
from typing import Any

from rtkit.rtc.enums import LifeCycleState, ReturnCode


class EnumItem:
    """A member of an enumeration.

    Attributes:
        member: The member of rtkit's own enumeration that it stands for.
    """

    __slots__ = ("_n", "_parent_id", "_v", "member")

    def __init__(self, name: str, value: int, parent_id: str = "", member: Any = None) -> None:
        self._n = name
        self._v = value
        self._parent_id = parent_id
        self.member = member

    def __str__(self) -> str:
        return self._n

    def __repr__(self) -> str:
        return self._n

    def __eq__(self, other: object) -> bool:
        return isinstance(other, EnumItem) and self._key == other._key

    def __lt__(self, other: EnumItem) -> bool:
        return self._v < other._v

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[str, int]:
        return self._parent_id, self._v


class ItemsOfEnum:
    """An enumeration: its items by number."""

    def __init__(self, repository_id: str, items: Iterable[EnumItem]) -> None:
        self._NP_RepositoryId = repository_id
        self._items = list(items)

    def _item(self, number: int) -> EnumItem:
        return self._items[number]


def items_of(cls: type[Enum], repository_id: str) -> ItemsOfEnum:
    """Return an enumeration for one of rtkit, item for item."""
    items = (EnumItem(each.name, number, repository_id, each) for number, each in enumerate(cls))
    return ItemsOfEnum(repository_id, items)


def _named(scope: str, name: str, items: Mapping[str, Any]) -> ItemsOfEnum:
    id = f"IDL:{scope}/{name}:1.0"
    return ItemsOfEnum(id, [EnumItem(n, i, id, m) for i, (n, m) in enumerate(items.items())])


RETURN_CODES = _named("omg.org/RTC", "ReturnCode_t", {each.value: each for each in ReturnCode})
LIFE_CYCLE_STATES = _named(
    "omg.org/RTC", "LifeCycleState", {f"{each.name}_STATE": each for each in LifeCycleState}
)
_OTHERS = {
    "ExecutionKind": ("PERIODIC", "EVENT_DRIVEN", "OTHER"),
    "PortInterfacePolarity": ("PROVIDED", "REQUIRED"),
}
ENUMERATIONS: Mapping[str, ItemsOfEnum] = {
    "ReturnCode_t": RETURN_CODES,
    "LifeCycleState": LIFE_CYCLE_STATES,
    **{
        name: _named("omg.org/RTC", name, dict.fromkeys(members))
        for name, members in _OTHERS.items()
    },
}
"""Enumerations of the RTC specification that are no data types, by name."""
ITEMS: Mapping[str, EnumItem] = {
    item._n: item  # noqa: SLF001 - as omniORB's own code reads it
    for each in ENUMERATIONS.values()
    for item in each._items  # noqa: SLF001
}
OK = ITEMS["RTC_OK"]
"""Outcome of a callback that did well."""


def item_for(code: ReturnCode | LifeCycleState) -> EnumItem:
    """Return the item that stands for a code, or a state."""
    among = RETURN_CODES if isinstance(code, ReturnCode) else LIFE_CYCLE_STATES
    return next(each for each in among._items if each.member is code)  # noqa: SLF001
