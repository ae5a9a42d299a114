"""Formats values as text and as JSON: one line, long contents abbreviated unless wanted in full."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

from rtkit.component.types import Time
from rtkit.component.values.fields import steps_of
from rtkit.errors import NotFound

_MOST_BYTES = 32
_MOST_ITEMS = 16
_STAMP = "tm"
Show = Callable[[Any], str]


def text_of(value: Any, *, is_full: bool = False) -> str:
    """Return a value as one line: ``[sec.nsec] data`` where it has nothing but these two."""
    if is_dataclass(value) and [each.name for each in fields(value)] == ["tm", "data"]:
        data: Any = value
        return f"[{stamp_text(data.tm)}] {_text(data.data, is_full)}"
    return _text(value, is_full)


def stamp_text(time: Time) -> str:
    """Return a time stamp as seconds with nine decimals."""
    return f"{time.sec}.{time.nsec:09}"


def _text(value: Any, is_full: bool) -> str:
    if is_dataclass(value) and not isinstance(value, type):
        if not is_full and _is_image(value):
            return _image(value)
        parts = (f"{f.name}={_text(getattr(value, f.name), is_full)}" for f in fields(value))
        return f"{type(value).__name__}({', '.join(parts)})"
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, bytes):
        is_short = is_full or len(value) <= _MOST_BYTES
        return repr(value) if is_short else f"<{len(value)} bytes>"
    if isinstance(value, (list, tuple)):
        shown = value if is_full or len(value) <= _MOST_ITEMS else value[:_MOST_ITEMS]
        rest = f", … {len(value)} values" if len(shown) < len(value) else ""
        return f"[{', '.join(_text(item, is_full) for item in shown)}{rest}]"
    return repr(value)


def _is_image(value: Any) -> bool:
    return isinstance(getattr(value, "width", None), int) and isinstance(
        getattr(value, "height", None), int
    )


def _image(value: Any) -> str:
    """Return the properties of an image without its pixels."""
    parts = [f"{value.width} x {value.height}"]
    for each in fields(value):
        item = getattr(value, each.name)
        if isinstance(item, bytes):
            parts.append(f"{len(item)} bytes")
        elif each.name == _STAMP:
            parts.insert(0, f"[{stamp_text(item)}]")
        elif each.name not in ("width", "height"):
            parts.append(f"{each.name} {_text(item, False)}")
    return f"{type(value).__name__}({', '.join(parts)})"


def plain(value: Any) -> Any:
    """Return a value as data of JSON, which `rtkit.component.values.literal` can read again."""
    if is_dataclass(value) and not isinstance(value, type):
        return {each.name: plain(getattr(value, each.name)) for each in fields(value)}
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, bytes):
        if len(value) <= _MOST_BYTES:
            return list(value)
        import base64

        return {"base64": base64.b64encode(value).decode("ascii")}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value


def field_reader(text: str) -> Callable[[Any], Any]:
    """Return a function that gets ``data.position.x`` or ``ranges[0]`` of a value.

    Raises:
        Malformed: It is no such text. The function raises NotFound for a value without that field.
    """
    steps = steps_of(text)

    def read(value: Any) -> Any:
        for step in steps:
            try:
                value = value[step] if isinstance(step, int) else _attribute(value, step)
            except (IndexError, TypeError):
                raise NotFound(f"no field {text}: {_text(value, False)} has no [{step}]") from None
            except LookupError:
                raise NotFound(
                    f"no field {text}: {type(value).__name__} has {_names(value)}"
                ) from None
        return value

    return read


def _attribute(value: Any, name: str) -> Any:
    if not is_dataclass(value) or name not in (each.name for each in fields(value)):
        raise LookupError(name)
    return getattr(value, name)


def _names(value: Any) -> str:
    return ", ".join(each.name for each in fields(value)) if is_dataclass(value) else "no fields"
