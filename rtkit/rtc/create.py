"""The create string: which component to make, where, and with which properties.

Grammar (OpenRTM manager interface)::

    create := id [ "?" key=value { "&" key=value } ]
    id     := implementation_id | "RTC:" vendor ":" category ":" id ":" language ":" version
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass, field

_ESCAPED = "%&=?"
_ESCAPES = "(?:%[0-9A-Fa-f]{2})+"
_NEVER_EMPTY = ("instance_name", "manager_name", "manager_address", "manager", "language")
FRESH_SLAVE = "manager_%p"
"""Value of ``manager_name`` that asks for a slave of its own, named after its process."""


@dataclass(frozen=True, slots=True)
class CreateString:
    """A parsed create string; empty identity fields match anything.

    Attributes:
        options: Every option in the order given, values without escapes.
    """

    implementation_id: str
    vendor: str = ""
    category: str = ""
    language: str = ""
    version: str = ""
    options: Mapping[str, str] = field(default_factory=dict)

    @property
    def instance_name(self) -> str:
        """The desired instance name, empty when the manager is to choose."""
        return self.options.get("instance_name", "")

    @property
    def place(self) -> str:
        """The slave that is to hold the component; empty for the manager itself."""
        return self.options.get("manager_name", "")

    @property
    def address(self) -> str:
        """``host:port`` of the manager that is to hold it; empty for the receiving manager."""
        return self.options.get("manager_address", "") or self.options.get("manager", "")

    @property
    def members(self) -> tuple[str, ...]:
        """Instance names of what a composite is made of, in order of execution."""
        return listed_names(self.options.get("members", ""))

    @property
    def is_place_open(self) -> bool:
        """Return whether the manager chooses the process: by the address, or by the members."""
        return not self.place and bool(self.address or self.options.get("members"))

    def with_options(self, **options: str) -> CreateString:
        """Return the same with these options set, or removed where empty."""
        merged = {**self.options, **options}
        kept = {key: value for key, value in merged.items() if value}
        return CreateString(
            self.implementation_id, self.vendor, self.category, self.language, self.version, kept
        )

    def __str__(self) -> str:
        name = self.implementation_id
        if self.vendor or self.category or self.language or self.version:
            name = f"RTC:{self.vendor}:{self.category}:{name}:{self.language}:{self.version}"
        options = "&".join(f"{key}={_escape(value)}" for key, value in self.options.items())
        return f"{name}?{options}" if options else name


def parse_create(text: str) -> CreateString:
    """Read a create string; options may stand in any order.

    Raises:
        Malformed: Names the part that cannot be read.
    """
    name, question, tail = text.partition("?")
    if "?" in tail:
        raise Malformed(f"more than one '?' in create string: {text}")
    options = _options(tail, text) if question else {}
    if ":" not in name:
        identity = {"implementation_id": name}
    else:
        parts = name.split(":")
        if parts[0] != "RTC" or len(parts) != 6:
            raise Malformed(
                "create string needs RTC:vendor:category:implementation_id:language:version,"
                f" found: {name}"
            )
        keys = ("vendor", "category", "implementation_id", "language", "version")
        identity = dict(zip(keys, parts[1:], strict=True))
    if not identity["implementation_id"].strip():
        raise Malformed(f"create string names no component type: {text!r}")
    return CreateString(options=options, **identity)


def readable_create(text: str) -> CreateString:
    """Read a create string; one that cannot be read, or none, has no type and no options."""
    try:
        return parse_create(text) if text else CreateString("")
    except Malformed:
        return CreateString("")


def listed_names(text: str) -> tuple[str, ...]:
    """Return the names of a list that is separated by commas."""
    return tuple(filter(None, map(str.strip, text.split(","))))


def _options(tail: str, text: str) -> dict[str, str]:
    options: dict[str, str] = {}
    for option in tail.split("&"):
        key, equals, value = option.partition("=")
        if not equals or not key:
            raise Malformed(f"option {option!r} is not KEY=VALUE in create string: {text}")
        if key in options:
            raise Malformed(f"option {key!r} is given twice in create string: {text}")
        if not value and key in _NEVER_EMPTY:
            raise Malformed(f"option {key!r} has no value in create string: {text}")
        options[key] = _unescape(value, text)
    return options


def _escape(value: str) -> str:
    return "".join(f"%{ord(c):02X}" if c in _ESCAPED else c for c in value)


def _unescape(value: str, text: str) -> str:
    """Return `value` with ``%XX`` as the bytes of UTF-8 text that they stand for."""

    def read(escapes: re.Match[str]) -> str:
        try:
            return bytes.fromhex(escapes[0].replace("%", "")).decode()
        except UnicodeDecodeError:
            hint = "a per cent sign is %25"
            raise Malformed(f"{escapes[0]} is no UTF-8 ({hint}) in create string: {text}") from None

    return re.sub(_ESCAPES, read, value) if "%" in value else value
