"""Reads parameters of requests as values: common ones, and those that a property declares."""

from __future__ import annotations

from collections.abc import Iterable

from rtkit.property.codes import PropertyError
from rtkit.property.naming import RequestTarget
from rtkit.property.property_spec import RequestParameter
from rtkit.property.reading import read
from rtkit.property.types import check, parse_type
from rtkit.property.values import Element, Value, Word, is_number

COMMON = {
    "echo": RequestParameter(
        "echo", parse_type("any"), False, (), "answer with the value in force"
    ),
    "timeout": RequestParameter("timeout", parse_type("number"), None, (), "how long to wait [s]"),
    "if": RequestParameter("if", parse_type("integer"), None, (), "only at this revision"),
    "id": RequestParameter("id", parse_type("any"), None, (), "repeated with it, it acts once"),
}
OF_GET = {"timeout": COMMON["timeout"]}


def checked_parameters(
    declared: tuple[RequestParameter, ...],
    target: RequestTarget,
    common: dict[str, RequestParameter],
) -> dict[str, Value]:
    """Return the parameters of a request as values.

    Raises:
        PropertyError: ``bad-parameter``: not declared, or of another type.
    """
    if not target.parameters:
        return {}
    known = {**common, **{each.key: each for each in declared}}
    values: dict[str, Value] = {}
    for key, text in target.parameters.items():
        parameter = known.get(key)
        if parameter is None:
            raise no_parameter(target.name, key, known)
        try:
            value: Value = True if text is None else _given(parameter, text)
            checked = check(parameter.type, value)
            if parameter.spec is not None and not parameter.choices:
                parameter.spec.within(checked)
            assert not isinstance(checked, bytes)
            parameter.choose(checked)
        except PropertyError as error:
            raise PropertyError("bad-parameter", f"{key}: {error}") from None
        values[key] = checked
    return values


def no_parameter(what: str, key: str, known: Iterable[str]) -> PropertyError:
    """Return the error that something takes no parameter of that name; names those like it."""
    from rtkit.rtc.nearest import did_you_mean

    text = f"{what} has no parameter {key}{did_you_mean(key, known)}"
    return PropertyError("bad-parameter", text)


def _given(parameter: RequestParameter, text: str) -> Value:
    if parameter.type.base == "text":
        return text
    try:
        value = read(text)
    except PropertyError as error:
        if parameter.type.base == "string" and " " in text.strip():
            why = f"{error} (a text with blanks stands in quotes)"
            raise PropertyError(error.code, why) from None
        raise
    if parameter.type.base == "boolean" and type(value) is int and value in (0, 1):
        return value == 1
    is_lone = not isinstance(value, str | tuple | Element)
    if parameter.type.base == "string" and (is_lone or isinstance(value, Word)):
        return text.strip()
    return value


def number(given: dict[str, Value], key: str, default: float) -> float:
    """Take a parameter that is a number.

    Raises:
        PropertyError: ``bad-parameter``.
    """
    value = given.pop(key, default)
    if not is_number(value) or value != value:
        raise PropertyError("bad-parameter", f"{key} is a number")
    return value  # type: ignore[return-value]


def flag(given: dict[str, Value], key: str) -> bool:
    """Take a parameter that is on when it is there, unless it is 0 or false."""
    return given.pop(key, False) not in (False, 0)


def nothing_else(parameters: dict[str, Value], what: str) -> None:
    """Refuse parameters that nothing has taken.

    Raises:
        PropertyError: ``bad-parameter``.
    """
    if parameters:
        raise PropertyError("bad-parameter", f"{what} has no parameter {min(parameters)}")
