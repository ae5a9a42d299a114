"""Tables of the XML form of model classes, shared by reader, normaliser and writer."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from math import isfinite
from typing import Any

from rtkit.fast_dataclass import MISSING, dataclass, fields
from rtkit.profile.common import NO_FOREIGN
from rtkit.profile.xmlnames import clark, split

Supply = str | Callable[[Any, Any], str]
"""A value for an absent attribute, or how to find one from its element and the findings."""

TEXT, FLAG, WHOLE, REAL, DATE, WORD = "text", "flag", "whole", "real", "date", "word"

# Compiled at first use: building from the strict form needs none of them.
_REAL_FORM = r"\s*[+-]?([0-9]{1,400}(\.[0-9]{0,400})?|\.[0-9]{1,400})([eE][+-]?[0-9]{1,3})?\s*"
_WHOLE_FORM = r"\s*[+-]?[0-9]{1,18}\s*"
_DATE_FORM = (
    r"\s*[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}(\.[0-9]{1,12})?"
    r"(Z|[+-][0-9]{2}:[0-9]{2})?\s*"
)
_ALLOWED = {
    FLAG: "true, false, 1, 0",
    WHOLE: "a whole number of at most 18 digits",
    REAL: "a finite number",
    DATE: "a date and time as in 2024-01-31T12:00:00+09:00",
}
_FLAGS = {"true": True, "false": False, "1": True, "0": False}


def is_real(text: str) -> bool:
    """Return whether a text is a finite number as profiles write it."""
    return re.fullmatch(_REAL_FORM, text) is not None and isfinite(float(text))


def is_whole(text: str) -> bool:
    """Return whether a text is a whole number as profiles write it."""
    return re.fullmatch(_WHOLE_FORM, text) is not None


def is_date(text: str) -> bool:
    """Return whether a text is a date and time as profiles write it."""
    return re.fullmatch(_DATE_FORM, text) is not None


def _finite(text: str) -> float:
    value = float(text)
    if not isfinite(value):
        raise ValueError(text)
    return value


@dataclass(frozen=True, slots=True)
class Attr:
    """One attribute: its model field, its name, its allowed values.

    Attributes:
        supply: Value to fill in, with a note, where a required attribute is absent.
        words: The allowed values of an enumeration.
        allowed: Allowed values, in words for a message.
        respellings: Old or wrong spellings in lower case, and what they mean.
        check: Tests whether a text is valid; None accepts any.
        read: Turns the text into the model's value; None keeps the text.
    """

    field: str
    name: str
    kind: str
    required: bool
    supply: Supply | None
    words: tuple[str, ...]
    allowed: str
    respellings: dict[str, str]
    check: Callable[[str], Any] | None
    read: Callable[[str], Any] | None


def field_name(local: str) -> str:
    """Return the field of a model for an XML name: that in small letters.

    >>> field_name("dataType"), field_name("OnExecute")
    ('data_type', 'on_execute')
    """
    return re.sub("(?<!^)(?=[A-Z])", "_", local).lower()


def local_name(field: str) -> str:
    """Return the XML name of an attribute for a field of a model.

    >>> local_name("data_type")
    'dataType'
    """
    first, *others = field.split("_")
    return first + "".join(map(str.capitalize, others))


def attribute(
    name: str,
    kind: str = TEXT,
    *,
    required: bool = False,
    supply: Supply | None = None,
    words: tuple[str, ...] = (),
    respellings: dict[str, str] | None = None,
) -> Attr:
    """Describe an attribute by its short name, from which its field follows.

    `words` make it an enumeration.
    """
    kind = WORD if words else kind
    check: dict[str, Callable[[str], Any] | None] = {
        FLAG: lambda text: text.strip() in _FLAGS,
        WHOLE: is_whole,
        REAL: is_real,
        DATE: is_date,
        WORD: frozenset(words).__contains__,
    }
    read: dict[str, Callable[[str], Any]] = {
        FLAG: lambda text: _FLAGS[text.strip()],
        WHOLE: int,
        REAL: _finite,
        WORD: {word: word for word in words}.__getitem__,
    }
    return Attr(
        field_name(name.partition(":")[2]),
        clark(name),
        kind,
        required or supply is not None,
        supply,
        words,
        ", ".join(words) or _ALLOWED.get(kind, "any text"),
        {word.lower(): word for word in words} | (respellings or {}),
        check.get(kind),
        read.get(kind),
    )


def required(*names: str) -> list[Attr]:
    """Describe attributes that hold any text and must be there."""
    return [attribute(name, required=True) for name in names]


@dataclass(frozen=True, slots=True)
class Child:
    """One child element: its model field, its tag, its spec; None is a text element.

    Attributes:
        least: How many there must be; children of one field count together.
    """

    field: str
    name: str
    spec: ElementSpec | None
    is_many: bool
    least: int


def child(
    name: str,
    spec: ElementSpec | None = None,
    *,
    field: str = "",
    many: bool = False,
    least: int = 0,
) -> Child:
    """Describe a child element by its short name, which gives the field unless one is stated."""
    return Child(field or field_name(name.partition(":")[2]), clark(name), spec, many, least)


_OLDER = {
    "ConstraintHash": "ConstraintHashType",
    "ConstraintList": "ConstraintListType",
    "ConstraintUnit": "ConstraintUnitType",
    "Property": "Properties",
    "TransMethod": "TransMethods",
}
"""Names of elements in older trees of the usual tools, and the present ones."""


class ElementSpec:
    """XML form of one model class.

    Attributes:
        make: The model class.
        xsi_type: The ``xsi:type`` that the strict form carries, as ``(namespace, local)``.
        also_types: Further types that are right as they stand.
        extended_type: The ``xsi:type`` that is written where there is content of its namespace;
            readers do without.
        tag_field: Field that holds the element's local name, for classes with several tags.
        wraps: Field of the only child, where the element has no model class of its own.
        foreign_field: Field for content of other namespaces.
        blank: Values of the model's fields for an element without attributes and children.
        readers: Place among these and conversion of each attribute, at hand for speed.
        slots: Rank, place, table and whether it may be repeated, of each child, at hand for speed.
        checks: Whether each attribute is as it should be and whether it must be there.
        is_choice: Whether it is one of its children and nothing else.
        needs: Fields that cannot do without children, and how many they need.
        rule: A repair of its own, run before the general ones.
        respellings: Old local names of attributes and children, and the present ones.
    """

    def __init__(
        self,
        make: Callable[..., Any],
        attributes: Iterable[Attr | str] = (),
        children: Iterable[Child] = (),
        *,
        xsi_type: str | None = None,
        also_types: Iterable[str] = (),
        extended_type: str | None = None,
        tag_field: str | None = None,
        wraps: str | None = None,
        rule: Callable[[Any, Any], None] | None = None,
        respellings: dict[str, str] | None = None,
    ) -> None:
        self.make = make
        self.xsi_type = split(clark(xsi_type)) if xsi_type else None
        self.xsi_type_text = xsi_type
        self.also_types = tuple(split(clark(name)) for name in also_types)
        self.extended_type = extended_type
        self.tag_field = tag_field
        self.wraps = wraps
        self.rule = rule
        self.foreign_field = "around" if wraps else "foreign"
        self.attributes = tuple(
            attribute(item) if isinstance(item, str) else item for item in attributes
        )
        self.known = {item.name: item for item in self.attributes}
        self.blank, self._places = _fields(make, wraps)
        self.foreign_place = self._places[self.foreign_field]
        self.tag_place = self._places[tag_field] if tag_field else None
        self.readers = {
            item.name: (self._places[item.field], item.read) for item in self.attributes
        }
        self.checks = {item.name: (item.check, item.required) for item in self.attributes}
        self.required_count = sum(item.required for item in self.attributes)
        self._respellings = {**_OLDER, **(respellings or {})}
        self.attribute_by_local = self._locals(self.known)
        self.children: tuple[Child, ...] = ()
        self.index: dict[str, tuple[int, Child]] = {}
        self.child_by_local: dict[str, str] = {}
        self.slots: dict[str, tuple[int, int, ElementSpec | None, bool]] = {}
        self.many_places: tuple[int, ...] = ()
        self.needs: dict[str, int] = {}
        self.add_children(children)

    def add_children(self, children: Iterable[Child]) -> None:
        """Append children; for specs that contain themselves."""
        self.children += tuple(children)
        self.index = {item.name: (rank, item) for rank, item in enumerate(self.children)}
        self.child_by_local = self._locals(self.index)
        places = [self._places[item.field] for item in self.children]
        self.slots = {
            item.name: (rank, place, item.spec, item.is_many)
            for rank, (item, place) in enumerate(zip(self.children, places, strict=True))
        }
        self.many_places = tuple(
            {place for item, place in zip(self.children, places, strict=True) if item.is_many}
        )
        fields = [item.field for item in self.children]
        self.is_choice = len(fields) > 1 and not self.attributes and len(set(fields)) == 1
        self.needs = {item.field: item.least for item in self.children if item.least}

    def _locals(self, names: Iterable[str]) -> dict[str, str]:
        by_local = {split(name)[1]: name for name in reversed(list(names))}
        old = {was: by_local[now] for was, now in self._respellings.items() if now in by_local}
        return old | by_local


def _fields(make: Callable[..., Any], wraps: str | None) -> tuple[list[Any], dict[str, int]]:
    """Return the defaults of a model class, None where there is none, and the places of fields."""
    if wraps is not None:
        return [None, NO_FOREIGN], {wraps: 0, "around": 1}
    found = fields(make)  # type: ignore[arg-type]
    defaults = [None if item.default is MISSING else item.default for item in found]
    return defaults, {item.name: place for place, item in enumerate(found)}
