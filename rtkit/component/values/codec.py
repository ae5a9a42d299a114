"""Encodes and decodes values as CDR with a four-byte header, little-endian by default.

Payloads of a `bytes` port pass unchanged. Reading is total: any bytes give a value or
`Malformed`, and the length of the message bounds memory.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

from rtkit.component.values.cdr_parts import Octets
from rtkit.component.values.codegen import (
    compile_decoder,
    compile_encoder,
    compile_splitter,
    is_fixed,
)
from rtkit.component.values.type_layout import complaint, layout_of
from rtkit.errors import Malformed

T = TypeVar("T")
_LITTLE = b"\x00\x01"
_BIG = b"\x00\x00"
_HEADER = 4


class Codec(NamedTuple):
    """Encoder and decoder of the values of one type.

    Both raise `Malformed`: `encode` for a value that does not fit, naming field and type,
    `decode` for bytes that are no value of the type.
    """

    encode: Callable[[Any], bytes]
    decode: Callable[[Octets], Any]


def _encode_bytes(value: Any) -> bytes:
    if not isinstance(value, (bytes, bytearray, memoryview)):
        raise Malformed(f"{type(value).__name__} is not bytes")
    return bytes(value)


BYTES = Codec(_encode_bytes, bytes)
"""Codec for types without a declaration here: bytes pass unchanged."""

_codecs: dict[type, Codec] = {bytes: BYTES}
_big_encoders: dict[type, Callable[[Any], bytes]] = {bytes: _encode_bytes}


def codec_for(cls: type) -> Codec:
    """Return the codec of a dataclass, or of bytes.

    Raises:
        Malformed: The type has a field that cannot be carried.
    """
    known = _codecs.get(cls)
    if known is None:
        known = _codecs[cls] = Codec(_encoder(cls), _decoder(cls))
    return known


def encoder_for(cls: type, *, is_big_endian: bool) -> Callable[[Any], bytes]:
    """Return the encoder of a dataclass, or of bytes, for an order of bytes.

    Raises:
        Malformed: The type has a field that cannot be carried.
    """
    if not is_big_endian:
        return codec_for(cls).encode
    if cls not in _big_encoders:
        _big_encoders[cls] = _encoder(cls, ">")
    return _big_encoders[cls]


def splitter_for(cls: type, *, is_big_endian: bool) -> Callable[[Any], Octets | list[Octets]]:
    """Return such an encoder, whose values may come in parts that make up the bytes.

    So what is large in a value is copied once, where it is sent; until then it must not change.
    """
    if cls is bytes or is_fixed(layout_of(cls)):
        return encoder_for(cls, is_big_endian=is_big_endian)
    order = ">" if is_big_endian else "<"
    return _checked(cls, compile_splitter(layout_of(cls), order))


def _encoder(cls: type, order: str = "<") -> Callable[[Any], bytes]:
    return _checked(cls, compile_encoder(layout_of(cls), order))


def _checked(cls: type, pack: Callable[[Any], T]) -> Callable[[Any], T]:
    layout = layout_of(cls)

    def encode(value: Any) -> T:
        try:
            return pack(value)
        except Exception as error:
            reason = complaint(layout, value, cls.__name__) or f"{cls.__name__}: {error}"
            raise Malformed(reason) from None

    return encode


def _decoder(cls: type) -> Callable[[Octets], Any]:
    layout = layout_of(cls)
    unpack = compile_decoder(layout, "<")
    unpack_big: list[Callable[[Octets], tuple[Any, int]]] = []

    def decode(data: Octets) -> Any:
        try:
            if data[:2] == _LITTLE:
                value, end = unpack(data)
            else:
                value, end = _other(data)(data)
        except Malformed as error:
            raise Malformed(f"{cls.__name__}: {error}") from None
        except Exception as error:
            raise Malformed(f"{cls.__name__}: {error} in {len(data)} bytes") from None
        if end != len(data):
            _check_tail(data, end, cls)
        return value

    def _other(data: Octets) -> Callable[[Octets], tuple[Any, int]]:
        if len(data) < _HEADER or data[:2] != _BIG:
            raise Malformed(f"no CDR header: {data[:_HEADER].hex(' ') or 'no bytes'}")
        if not unpack_big:
            unpack_big.append(compile_decoder(layout, ">"))
        return unpack_big[0]

    return decode


def _check_tail(data: Octets, end: int, cls: type) -> None:
    # Writers of DDS pad a message to a multiple of four bytes; anything else is not ours.
    tail = data[end:]
    if len(tail) >= _HEADER or any(tail):
        raise Malformed(f"{cls.__name__}: {len(tail)} bytes too many")
