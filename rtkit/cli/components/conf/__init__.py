"""Operations of ``rtconf`` on configuration sets, files of them, and manager properties."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rtkit.cli.shared.app import WrongArguments

Sets = Mapping[str, Mapping[str, str]]


class ConfRequest(NamedTuple):
    """The operation, and the set that it is about."""

    verb: str
    arguments: tuple[str, ...]
    set_id: str
    has_hidden: bool
    is_long: bool
    is_json: bool


def values_of(arguments: Sequence[str]) -> dict[str, str]:
    """Read ``PARAM VALUE``, or ``PARAM=VALUE`` several times.

    Raises:
        WrongArguments: One is of neither form.
    """
    if len(arguments) == 2 and "=" not in arguments[0]:
        return {arguments[0]: arguments[1]}
    values = {}
    for argument in arguments:
        name, equals, value = argument.partition("=")
        if not equals:
            raise WrongArguments(f"not PARAM=VALUE: {argument}")
        values[name] = value
    return values
