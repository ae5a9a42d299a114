"""Service interfaces: a protocol class read into methods whose arguments can be carried.

Arguments and results are of the kinds that data types have (`rtkit.component.types`), told by the
annotations; ``-> None`` tells that nothing comes back.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import make_dataclass
from functools import cached_property
from typing import Any, Protocol, get_type_hints

from rtkit.component.codec import Codec, codec_for
from rtkit.component.layout import Layout, layout_of_hint
from rtkit.errors import Malformed

_PLAIN = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
_BUILT_IN = ("object", "Protocol", "Generic", "ABC")


class Method:
    """One method of an interface.

    Attributes:
        label: ``MyService.echo``, for messages.
        signature: ``echo(text:string)->string``; equal on both sides of a call.
    """

    def __init__(self, owner: str, name: str, function: Callable[..., Any]) -> None:
        self.name = name
        self.label = f"{owner}.{name}"
        self._shape = _without_self(inspect.signature(function))
        self._hints = _hints(function, self.label)
        given = [f"{n}:{self._layout(n).name}" for n in self._shape.parameters]
        self.returns_nothing = self._hints.get("return", ...) is type(None)
        kinds = [each.kind for each in self._shape.parameters.values()]
        self._is_positional = inspect.Parameter.KEYWORD_ONLY not in kinds
        self._count = len(kinds)
        result = "void" if self.returns_nothing else self._layout("return").name
        self.signature = f"{name}({','.join(given)})->{result}"

    def encode_arguments(self, arguments: Sequence[Any], named: Mapping[str, Any]) -> bytes:
        """Return arguments as bytes.

        Raises:
            Malformed: They do not fit the parameters.
        """
        bound = self.bind(arguments, named)
        return self._arguments.encode(self._record(*bound)) if bound else b""

    def decode_arguments(self, data: bytes) -> tuple[Any, ...]:
        """Return the arguments that the bytes stand for, in the order of the parameters.

        Raises:
            Malformed: They are no arguments of this method.
        """
        if not self._shape.parameters:
            return ()
        record = self._arguments.decode(data)
        return tuple(getattr(record, name) for name in self._shape.parameters)

    def call(self, function: Callable[..., Any], arguments: Sequence[Any]) -> Any:
        """Call an implementation with arguments in the order of the parameters."""
        if self._is_positional:
            return function(*arguments)
        shape = self._shape.parameters.values()
        pairs = list(zip(shape, arguments, strict=True))
        plain = [value for each, value in pairs if each.kind is not each.KEYWORD_ONLY]
        named = {each.name: value for each, value in pairs if each.kind is each.KEYWORD_ONLY}
        return function(*plain, **named)

    def encode_result(self, value: Any) -> bytes:
        """Return a result as bytes.

        Raises:
            Malformed: It is not of the type that the method promises.
        """
        if not self.returns_nothing:
            codec, record = self._result
            return codec.encode(record(value))
        if value is not None:
            raise Malformed(f"{self.label} returns nothing, not {type(value).__name__}")
        return b""

    def decode_result(self, data: bytes) -> Any:
        """Return the result that the bytes stand for.

        Raises:
            Malformed: They are no result of this method.
        """
        return None if self.returns_nothing else self._result[0].decode(data).result

    def bind(self, arguments: Sequence[Any], named: Mapping[str, Any]) -> tuple[Any, ...]:
        """Return the arguments in the order of the parameters, defaults filled in.

        Raises:
            Malformed: One is missing, or there is one too many.
        """
        if not named and self._is_positional and len(arguments) == self._count:
            return tuple(arguments)
        try:
            bound = self._shape.bind(*arguments, **named)
        except TypeError as error:
            raise Malformed(f"{self.label}: {error}") from None
        bound.apply_defaults()
        return tuple(bound.arguments.values())

    @cached_property
    def _record(self) -> type:
        fields = [(name, self._hints[name]) for name in self._shape.parameters]
        return make_dataclass(self.label, fields, frozen=True, slots=True)

    @cached_property
    def _arguments(self) -> Codec:
        return codec_for(self._record)

    @cached_property
    def _result(self) -> tuple[Codec, type]:
        fields = [("result", self._hints["return"])]
        record = make_dataclass(self.label, fields, frozen=True, slots=True)
        return codec_for(record), record

    def _layout(self, name: str) -> Layout:
        what = "what it returns" if name == "return" else f"the type of {name}"
        if name not in self._hints:
            raise Malformed(f"{self.label} does not say {what}; annotate it")
        return layout_of_hint(self._hints[name], f"{self.label}: {name}")


class Caller(Protocol):
    """What a client calls through."""

    def call(
        self,
        method: Method,
        type_name: str,
        arguments: tuple[Any, ...],
        named: Mapping[str, Any],
        timeout_s: float | None,
    ) -> Any:
        """Call a method of the provider; without time-out that of the port counts [s]."""


class _Client:
    """Has the methods of one interface."""

    __slots__ = ("_port", "_timeout_s")

    def __init__(self, port: Caller, timeout_s: float | None) -> None:
        self._port = port
        self._timeout_s = timeout_s


def _calling(type_name: str, method: Method) -> Callable[..., Any]:
    def call(client: Any, *arguments: Any, **named: Any) -> Any:
        port, timeout_s = client._port, client._timeout_s  # noqa: SLF001 - it is its method
        return port.call(method, type_name, arguments, named, timeout_s)

    call.__name__ = method.name
    return call


class Interface:
    """A service interface.

    Attributes:
        cls: The class that was read.
        name: Its type name, ``MyService`` or ``SimpleService::MyService``.
        methods: By name.
        by_signature: The same by signature.
    """

    def __init__(self, cls: Any, name: str = "") -> None:
        if not isinstance(cls, type):
            raise Malformed(f"not a class: {cls!r}; an interface is a class of typing.Protocol")
        self.cls = cls
        self.name = name or cls.__name__
        if not self.name.isprintable():
            raise Malformed(f"name of interface has control characters: {self.name!r}")
        found: dict[str, Any] = {}
        for ancestor in reversed(cls.__mro__):
            if ancestor.__name__ not in _BUILT_IN:
                found.update(vars(ancestor))
        public = {key: value for key, value in found.items() if not key.startswith("_")}
        self.methods: Mapping[str, Method] = {
            key: Method(self.name, key, value)
            for key, value in public.items()
            if inspect.isfunction(value)
        }
        others = sorted(set(public) - set(self.methods))
        if others:
            raise Malformed(f"interface {self.name} has what is no method: {', '.join(others)}")
        if not self.methods:
            raise Malformed(f"interface {self.name} has no methods")
        self.by_signature = {method.signature: method for method in self.methods.values()}
        calls = {name: _calling(self.name, each) for name, each in self.methods.items()}
        self._client = type(f"{cls.__name__}Client", (_Client,), {"__slots__": (), **calls})

    def client(self, port: Caller, timeout_s: float | None) -> object:
        """Return an object with the methods of the interface, which calls through `port`."""
        return self._client(port, timeout_s)

    def missing_in(self, implementation: object) -> list[str]:
        """Return the methods that an implementation lacks."""
        return [n for n in self.methods if not callable(getattr(implementation, n, None))]


def _without_self(signature: inspect.Signature) -> inspect.Signature:
    parameters = list(signature.parameters.values())[1:]
    return signature.replace(parameters=parameters)


def _hints(function: Callable[..., Any], label: str) -> dict[str, Any]:
    for parameter in list(inspect.signature(function).parameters.values())[1:]:
        if parameter.kind not in _PLAIN:
            raise Malformed(f"{label} has parameter {parameter}, which cannot be carried")
    try:
        return get_type_hints(function, include_extras=True)
    except (NameError, TypeError) as error:
        raise Malformed(f"{label}: its annotations cannot be read: {error}") from error
