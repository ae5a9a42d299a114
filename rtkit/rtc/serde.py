"""Converts records to plain data (dict, list, str, number) and back, compiled once per type.

Data from another process is not trusted: `decode` checks every field.
"""

from __future__ import annotations

import builtins
import json
import sys
from collections.abc import Callable, Mapping
from enum import Enum
from types import ModuleType, UnionType
from typing import Any, ForwardRef, TypeVar, Union, cast, get_args, get_origin

from rtkit.errors import Malformed
from rtkit.fast_dataclass import MISSING, fields, is_record

T = TypeVar("T")
Coder = Callable[[Any], Any]

_encoders: dict[Any, Coder] = {}
_decoders: dict[Any, Coder] = {}


def encode(value: object) -> Any:
    """Return `value`, a record, as plain data; fields that hold their default are left out."""
    return _encoder(type(value))(value)


def decode(cls: type[T], data: object) -> T:
    """Rebuild a record of type `cls`.

    Raises:
        Malformed: The data does not have the shape of the type.
    """
    return cast(T, _decoder(cls)(data))


def encode_text(value: object) -> str:
    """Return a record as one line of JSON."""
    return json.dumps(encode(value), separators=(",", ":"))


def decode_text(cls: type[T], text: str) -> T:
    """Rebuild a record from JSON.

    Raises:
        Malformed: The text is no JSON, or has not the shape of the type.
    """
    return decode(cls, parse_json(text))


def parse_json(text: str | bytes) -> Any:
    """Return the plain data of a JSON text.

    Raises:
        Malformed: It is none.
    """
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise Malformed(f"not JSON: {error}") from error


def parse_table(text: str | bytes) -> dict[str, Any]:
    """Return the table that a JSON text holds.

    Raises:
        Malformed: It holds none.
    """
    table = parse_json(text)
    if not isinstance(table, dict):
        raise Malformed("not a JSON table")
    return table


def _same(value: Any) -> Any:
    return value


def _encoder(hint: Any) -> Coder:
    known = _encoders.get(hint)
    if known is None:
        known = _encoders[hint] = _make_encoder(hint)
    return known


def _make_encoder(hint: Any) -> Coder:
    origin, args = get_origin(hint), get_args(hint)
    if origin is frozenset:
        item = _encoder(args[0])
        return lambda value: sorted(map(item, value))
    if origin is tuple:
        item = _encoder(args[0])
        return list if item is _same else lambda value: [item(x) for x in value]
    if origin is not None and origin not in (Union, UnionType) and issubclass(origin, Mapping):
        item = _encoder(args[1])
        return dict if item is _same else lambda value: {k: item(v) for k, v in value.items()}
    if origin in (Union, UnionType):
        return _optional_encoder(args)
    if is_record(hint):
        return _record_encoder(hint)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return lambda value: value.value
    return _same


def _optional_encoder(args: tuple[Any, ...]) -> Coder:
    (some,) = (arg for arg in args if arg is not type(None))
    item = _encoder(some)
    return lambda value: None if value is None else item(value)


def _record_encoder(cls: Any) -> Coder:
    columns = [
        (
            field.name,
            field.default_factory() if field.default_factory is not MISSING else field.default,
        )
        for field in fields(cls)
    ]
    coders: dict[str, Coder] = {}

    def encode_record(value: Any) -> dict[str, Any]:
        plain = {}
        for name, default in columns:
            item = getattr(value, name)
            if item != default:
                # Made at first use: a type that is never sent need not even be imported.
                coder = coders.get(name)
                if coder is None:
                    coder = coders[name] = _encoder(hint_of(cls, name))
                plain[name] = coder(item)
        return plain

    return encode_record


def hint_of(cls: type, name: str) -> Any:
    """Return the type of a field."""
    for owner in cls.__mro__:
        annotation = getattr(owner, "__annotations__", {}).get(name)  # its own only
        if annotation is not None:
            break
    if isinstance(annotation, ForwardRef):  # as a NamedTuple keeps them
        annotation = annotation.__forward_arg__
    if not isinstance(annotation, str):
        return annotation
    return eval(annotation, {}, _Names(sys.modules[owner.__module__]))


class _Names(dict[str, Any]):
    """Names that annotations of a module may use, also those that it imports only on demand."""

    def __init__(self, module: ModuleType) -> None:
        super().__init__(vars(module))
        self._module = module

    def __missing__(self, name: str) -> Any:
        return getattr(builtins, name, None) or getattr(self._module, name)


def _decoder(hint: Any) -> Coder:
    known = _decoders.get(hint)
    if known is None:
        known = _decoders[hint] = _make_decoder(hint)
    return known


def _make_decoder(hint: Any) -> Coder:
    origin, args = get_origin(hint), get_args(hint)
    if origin is tuple:
        return _sequence_decoder(_decoder(args[0]))
    if origin is frozenset:
        items = _sequence_decoder(_decoder(args[0]))
        return lambda data: frozenset(items(data))
    if origin is not None and origin not in (Union, UnionType) and issubclass(origin, Mapping):
        return _mapping_decoder(_decoder(args[1]))
    if origin in (Union, UnionType):
        (some,) = (arg for arg in args if arg is not type(None))
        item = _decoder(some)
        return lambda data: None if data is None else item(data)
    if is_record(hint):
        return _record_decoder(hint)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return _enum_decoder(hint)
    return _scalar_decoder(hint)


def _sequence_decoder(item: Coder) -> Coder:
    def decode_sequence(data: Any) -> tuple[Any, ...]:
        if not isinstance(data, (list, tuple)):
            raise Malformed(f"expected a list, found {type(data).__name__}")
        return tuple(item(x) for x in data)

    return decode_sequence


def _mapping_decoder(item: Coder) -> Coder:
    def decode_mapping(data: Any) -> dict[str, Any]:
        if not isinstance(data, Mapping) or not all(isinstance(key, str) for key in data):
            raise Malformed(f"expected a table, found {type(data).__name__}")
        return {key: item(value) for key, value in data.items()}

    return decode_mapping


def _enum_decoder(enum: type[Enum]) -> Coder:
    members = {member.value: member for member in enum}

    def decode_enum(data: Any) -> Enum:
        try:
            return members[data]
        except (KeyError, TypeError):
            allowed = ", ".join(str(value) for value in members)
            raise Malformed(f"expected one of {allowed}, found {data!r}") from None

    return decode_enum


def _scalar_decoder(hint: type) -> Coder:
    accepted = (int, float) if hint is float else (hint,)

    def decode_scalar(data: Any) -> Any:
        if not isinstance(data, accepted) or (isinstance(data, bool) and hint is not bool):
            raise Malformed(f"expected {hint.__name__}, found {type(data).__name__}")
        return data

    return decode_scalar


def _record_decoder(cls: Any) -> Coder:
    coders = {field.name: _decoder(hint_of(cls, field.name)) for field in fields(cls)}

    def decode_record(data: Any) -> Any:
        if not isinstance(data, Mapping):
            raise Malformed(f"{cls.__name__}: expected a table, found {type(data).__name__}")
        values = {}
        for name, value in data.items():
            coder = coders.get(name)
            if coder is None:
                raise Malformed(f"{cls.__name__}: unknown field {name!r}")
            try:
                values[name] = coder(value)
            except Malformed as error:
                raise Malformed(f"{cls.__name__}.{name}: {error}") from None
        try:
            return cls(**values)
        except TypeError as error:
            raise Malformed(f"{cls.__name__}: {error}") from None

    return decode_record
