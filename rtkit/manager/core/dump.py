"""Text of a dump: a header, the checkpoint, one line for each event or fault, the state at the end.

Each line is a JSON table. Unlike `rtkit.rtc.serde` it needs no expected type: types that JSON lacks
are written as an object with one key that begins with ``~``, and each record names its class. A
dump that is read is data of a stranger: it is checked before anything is done with it. Only the
classes that events and state consist of are ever made, and each field is checked against its
annotation.
"""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from enum import Enum
from functools import cache
from types import NoneType, UnionType
from typing import Any, NamedTuple, Union, get_args, get_origin

from rtkit.deployment.facts import Snapshot
from rtkit.deployment.health import HealthRule, Sample
from rtkit.deployment.limits import Capacity, SlaveLimits
from rtkit.errors import Malformed, RtkitError, from_kind
from rtkit.fast_dataclass import MISSING, fields, is_record
from rtkit.manager.core.desired import DesiredState
from rtkit.manager.core.event_ring import Fault, Recording
from rtkit.manager.core.events import Event
from rtkit.manager.core.indexed_table import IndexedTable
from rtkit.manager.core.secrets import HIDDEN, hidden_in, is_secret
from rtkit.manager.core.state import ManagerState
from rtkit.rtc.serde import hint_of, parse_table
from rtkit.settings.properties import Settings

FORM = 1
"""Of the file; another one cannot be read."""
_FORM_KEY = "rtkit-dump"


class Dump(NamedTuple):
    """A recording, with what its file says about it.

    Attributes:
        header: Texts: ``manager``, ``host``, ``pid``, ``rtkit`` (its version), ``time``, ``why``.
    """

    header: Mapping[str, str]
    recording: Recording


def to_lines(dump: Dump) -> Iterator[str]:
    """Yield the lines of a dump, without their ends."""
    header, recording = dump
    yield _line({_FORM_KEY: FORM, **header, "lost": recording.lost})
    yield _line({"start": to_plain(recording.start)})
    for at, item in recording.items:
        yield _line({"at": at, "item": to_plain(item)})
    yield _line({"end": to_plain(recording.end)})


def from_lines(lines: Iterable[str]) -> Dump:
    """Read a dump.

    Raises:
        Malformed: It is none, or of another form, or cut off; names the line.
    """
    header: dict[str, Any] = {}
    found: dict[str, Any] = {}
    items: list[tuple[float, Any]] = []
    number = 0
    for number, line in enumerate(lines, 1):
        try:
            table = parse_table(line)
            if number == 1:
                header = _header(table)
            elif "end" in found:
                raise Malformed("something follows the end")
            elif "item" in table and "start" in found:
                items.append((_moment(table.get("at")), from_plain(table["item"])))
            else:
                name = "end" if "start" in found else "start"
                if table.keys() != {name}:
                    raise Malformed("no such line is expected here")
                found[name] = from_plain(table[name])
        except Malformed as error:
            raise Malformed(f"not a dump of a manager, line {number}: {error}") from error
    if "end" not in found:
        raise Malformed(f"not a whole dump of a manager: it ends after line {number}")
    return _checked(header, found, items)


def _checked(
    header: dict[str, Any], found: Mapping[str, Any], items: list[tuple[float, Any]]
) -> Dump:
    start, end, lost = found["start"], found["end"], header.pop("lost")
    if not isinstance(end, ManagerState) or not isinstance(start, dict | None):
        raise Malformed("not a dump of a manager: it has no state")
    return Dump(header, Recording(start, items, end, lost))


def _line(table: Mapping[str, Any]) -> str:
    return json.dumps(table, separators=(",", ":"))


def _header(table: dict[str, Any]) -> dict[str, Any]:
    form = table.pop(_FORM_KEY, None)
    if form is None:
        raise Malformed("no header")
    if form != FORM:
        by = f", of rtkit {table['rtkit']}" if isinstance(table.get("rtkit"), str) else ""
        raise Malformed(f"form {form!r}{by}; this rtkit reads form {FORM}")
    lost = table.pop("lost", None)
    if type(lost) is not int or not all(type(text) is str for text in table.values()):
        raise Malformed("a header of another kind")
    return {**table, "lost": lost}


def _moment(at: object) -> float:
    if type(at) not in (int, float) or not math.isfinite(at):  # type: ignore[arg-type]
        raise Malformed(f"no time: {at!r}")
    return float(at)  # type: ignore[arg-type]


_ROOTS = (
    *Event.__subclasses__(),
    *(ManagerState, DesiredState, Settings, Snapshot, Sample, HealthRule, Capacity, Fault),
)
_OBJECTS = (DesiredState, Settings)
"""Classes that are no records: their attributes are plain data, set from outside."""
_DEPTH = 64


def to_plain(value: object) -> Any:
    """Return a value as JSON has it; what is named like a secret is hidden.

    Raises:
        TypeError: It consists of something else than events and state do.
    """
    match value:
        case None | bool() | int() | float() | str() if type(value) in _SCALARS:
            return _scalar(value)
        case Enum():
            return {"~enum": f"{type(value).__name__}.{value.name}"}
        case RtkitError():
            return {"~error": [value.kind, str(value)]}
        case set() | frozenset():
            return {"~set": sorted(map(to_plain, value), key=repr)}
        case Mapping():
            return _mapping(value)
        case list() | deque():
            return [to_plain(item) for item in value]
    name = type(value).__name__
    if type(value) is _classes().get(name):
        return {"~": name} | {
            field: HIDDEN if is_secret(field, item) else to_plain(item)
            for field, item in _content(value)
        }
    if isinstance(value, tuple):
        return {"~tuple": [to_plain(item) for item in value]}
    raise TypeError(f"neither event nor state: {name}")


def from_plain(plain: Any, depth: int = 0) -> Any:
    """Rebuild a value.

    Raises:
        Malformed: The data stands for no value that events and state have.
    """
    if depth > _DEPTH:
        raise Malformed(f"more than {_DEPTH} values in each other")
    if isinstance(plain, list):
        return [from_plain(item, depth + 1) for item in plain]
    if not isinstance(plain, dict):
        return plain
    special = [key for key in plain if key.startswith("~")]
    if not special:
        return {key: from_plain(item, depth + 1) for key, item in plain.items()}
    if special == ["~"]:
        content = {k: from_plain(v, depth + 1) for k, v in plain.items() if k != "~"}
        return _made(plain["~"], content)
    tag, content = next(iter(plain.items()))
    make = _TAGS.get(tag)
    if len(plain) != 1 or make is None:
        raise Malformed(f"unknown kind of value: {', '.join(special)}")
    try:
        return make(from_plain(content, depth + 1))
    except (TypeError, ValueError, LookupError) as error:
        raise Malformed(f"{tag}: {error}") from error


_SCALARS = (NoneType, bool, int, float, str)


def _scalar(value: object) -> object:
    if isinstance(value, str):
        return hidden_in(value)
    if isinstance(value, float) and not math.isfinite(value):
        return {"~float": str(value)}
    return value


def _mapping(value: Mapping[Any, Any]) -> Any:
    if all(type(key) is str and not key.startswith("~") for key in value):
        return {k: HIDDEN if is_secret(k, item) else to_plain(item) for k, item in value.items()}
    return {"~dict": [[to_plain(key), to_plain(item)] for key, item in value.items()]}


def _content(value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the fields of a record that differ from their defaults, or all attributes."""
    if isinstance(value, _OBJECTS):
        yield from vars(value).items()
        return
    kind: Any = type(value)
    for name, default in _defaults(kind).items():
        item = getattr(value, name)
        if type(item) is not type(default) or item != default:
            yield name, item


@cache
def _defaults(cls: Any) -> dict[str, Any]:
    """Return the fields of a record with their defaults, ``MISSING`` where there is none."""
    if not is_record(cls):
        return {name: cls._field_defaults.get(name, MISSING) for name in cls._fields}
    return {
        each.name: each.default if each.default_factory is MISSING else each.default_factory()
        for each in fields(cls)
        if each.name not in getattr(cls, "UNRECORDED", ())
    }


def _made(name: object, content: Mapping[str, Any]) -> Any:
    cls = _classes().get(name) if isinstance(name, str) else None
    if cls is None or issubclass(cls, Enum):
        raise Malformed(f"unknown class: {name!r}")
    if cls in _OBJECTS:
        made = cls()
        if vars(made).keys() != content.keys():
            raise Malformed(f"{name}: other attributes than here: {', '.join(content)}")
        for key, plain in content.items():
            item = _indexed(plain, getattr(made, key))
            if type(item) is not type(getattr(made, key)):
                raise Malformed(f"{name}.{key}: not a {type(getattr(made, key)).__name__}")
            setattr(made, key, item)
        return made
    content = {key: _indexed(item, _defaults(cls).get(key)) for key, item in content.items()}
    for key, item in content.items():
        if key not in _defaults(cls):
            raise Malformed(f"{name}: unknown field {key!r}")
        if not _conforms(item, _hint(cls, key)):
            raise Malformed(f"{name}.{key}: not {_hint(cls, key)}: {str(item)[:80]}")
    try:
        return cls(**content)
    except TypeError as error:
        raise Malformed(f"{name}: {error}") from error


def _indexed(item: Any, default: object) -> Any:
    """Return a table as an indexed one where that is expected."""
    if isinstance(default, IndexedTable) and type(item) is dict:
        return default.like(item)
    return item


def _enum(text: str) -> Enum:
    name, _, member = text.partition(".")
    cls: Any = _classes()[name]
    if not issubclass(cls, Enum):
        raise Malformed(f"unknown class: {name!r}")
    made: Enum = cls[member]
    return made


def _error(parts: list[str]) -> RtkitError:
    kind, text = parts
    return from_kind(kind, text)


_TAGS: Mapping[str, Callable[[Any], Any]] = {
    "~enum": _enum,
    "~error": _error,
    "~float": float,
    "~set": set,
    "~tuple": tuple,
    "~dict": dict,
}


# classes and annotations


@cache
def _classes() -> dict[str, Any]:
    """Return all classes that events and state consist of, by name."""
    found: dict[str, Any] = {}
    left: list[Any] = [*_ROOTS, SlaveLimits]
    while left:
        hint = left.pop()
        left.extend(get_args(hint))
        if not isinstance(hint, type) or get_origin(hint) is not None:
            continue
        is_known = is_record(hint) or hasattr(hint, "_fields")
        if is_known or hint in _OBJECTS or issubclass(hint, Enum):
            if hint in found.values():
                continue
            assert hint.__name__ not in found, f"two classes are named {hint.__name__}"
            found[hint.__name__] = hint
            names: Iterable[str] = _defaults(hint) if is_known else ()
            left.extend(_hint(hint, name) for name in names)
    return found


@cache
def _hint(cls: Any, name: str) -> Any:
    return hint_of(cls, name)


def _conforms(value: Any, hint: Any) -> bool:
    """Return whether a value is of an annotated type."""
    origin, args = get_origin(hint), get_args(hint)
    if hint is Any or hint is object:
        return True
    if origin in (Union, UnionType):
        return any(_conforms(value, each) for each in args)
    if origin is None:
        if hint is float:
            return type(value) in (int, float)
        return type(value) is hint if hint in _SCALARS else isinstance(value, hint)
    if not isinstance(value, origin):
        return False
    if issubclass(origin, Mapping):
        key, item = args
        return all(_conforms(k, key) and _conforms(v, item) for k, v in value.items())
    if origin is tuple and args[-1] is not ...:
        return len(value) == len(args) and all(map(_conforms, value, args))
    if issubclass(origin, (Sequence, set, frozenset)):
        return all(_conforms(each, args[0]) for each in value)
    return True
