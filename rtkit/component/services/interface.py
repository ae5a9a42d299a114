"""Service interfaces: reads a protocol class into methods whose arguments can be carried.

Arguments and results are of the kinds that data types have (`rtkit.component.types`). Annotations
give those kinds; ``-> None`` stands for no result. An exception that a method declares
(`raises`) arrives as itself, with the arguments of its constructor.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, Protocol, TypeVar, get_type_hints

from rtkit.component.contexts.callbacks import describe_failure, unfit_kind
from rtkit.component.values.carried import Test, compile_test
from rtkit.component.values.codec import Codec, codec_for
from rtkit.component.values.type_layout import ArrayLayout, Layout, layout_of_hint
from rtkit.errors import Malformed, Refused
from rtkit.fast_dataclass import MISSING, make_dataclass

F = TypeVar("F", bound=Callable[..., Any])

_BUILT_IN = ("object", "Protocol", "Generic", "ABC")


def raises(*exceptions: type[Exception]) -> Callable[[F], F]:
    """Declare which exceptions of a method arrive at its caller as themselves.

    ::

        class Gripper(Protocol):
            @raises(Busy)
            def close(self, force: float) -> None: ...

    What their constructors take is annotated, and kept under the same names; one without a
    constructor of its own carries its text. Any other exception arrives as `Refused` with its text.
    """

    def declare(method: F) -> F:
        method.__raises__ = exceptions  # type: ignore[attr-defined]
        return method

    return declare


def returns(*names: str) -> Callable[[F], F]:
    """Name the values of the tuple that a method returns: ``""`` for the result itself.

    ::

        class Gripper(Protocol):
            @returns("", "width")
            def close(self, force: float) -> tuple[bool, float]: ...

    The named ones are the ``out`` parameters of an interface definition; a single name is that of
    the only value.
    """

    def declare(method: F) -> F:
        method.__returns__ = names  # type: ignore[attr-defined]
        return method

    return declare


class Raised(Refused):
    """An exception that a provider raised, with the data that rebuilds it where it is declared."""

    def __init__(self, text: str, name: str, data: bytes) -> None:
        super().__init__(text)
        self.name = name
        self.data = data


class InterfaceMethod:
    """One method of an interface.

    Attributes:
        label: ``MyService.echo``, for messages.
        signature: ``echo(text:string)->string``; equal on both sides of a call.
        hints: Annotations by parameter, and of ``return``.
    """

    def __init__(self, owner: str, name: str, function: Callable[..., Any]) -> None:
        self.name = name
        self.label = f"{owner}.{name}"
        self._likes: dict[InterfaceMethod, bool] = {}
        self._raises = {
            cls.__name__: _Exception(cls, self.label) for cls in getattr(function, "__raises__", ())
        }
        self._shape = _without_self(inspect.signature(function))
        self._returns: tuple[str, ...] = getattr(function, "__returns__", ())
        self.hints = _hints(function, self.label)
        given = [f"{n}:{self._layout(n).name}" for n in self._shape.parameters]
        self.returns_nothing = self.hints.get("return", ...) is type(None)
        kinds = [each.kind for each in self._shape.parameters.values()]
        self._is_positional = inspect.Parameter.KEYWORD_ONLY not in kinds
        self._count = len(kinds)
        result = "void" if self.returns_nothing else self._layout("return").name
        self.signature = f"{name}({','.join(given)})->{result}"

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of its parameters."""
        return tuple(self._shape.parameters)

    @property
    def layouts(self) -> dict[str, Layout]:
        """The layout of each parameter, by name."""
        return {name: self._layout(name) for name in self._shape.parameters}

    @property
    def results(self) -> tuple[tuple[str, ...], tuple[Layout, ...]]:
        """Names and layouts of what it returns; the result itself has an empty name.

        A tuple of several types without names has ``out1``, ``out2`` ... behind its first one.
        """
        if self.returns_nothing:
            return (), ()
        layout, names = self._layout("return"), self._returns
        if len(names) == 1 or not isinstance(layout, ArrayLayout):
            return names[:1] or ("",), (layout,)
        if not names and any(item != layout.items[0] for item in layout.items):
            names = ("", *(f"out{number}" for number in range(1, len(layout.items))))
        return (names, layout.items) if len(names) == len(layout.items) else (("",), (layout,))

    @property
    def exceptions(self) -> dict[str, dict[str, Layout]]:
        """The layouts of what each declared exception carries, by their names."""
        return {name: each.members for name, each in self._raises.items()}

    @property
    def exception_classes(self) -> dict[str, Any]:
        """The classes of declared exceptions, by their names."""
        return {name: each.cls for name, each in self._raises.items()}

    def encode_arguments(self, arguments: Sequence[Any], named: Mapping[str, Any]) -> bytes:
        """Return arguments as bytes.

        Raises:
            Malformed: They do not fit the parameters.
        """
        return self._encode(self.bind(arguments, named))

    def _encode(self, bound: tuple[Any, ...]) -> bytes:
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

    def encode_exception(self, error: BaseException) -> tuple[str, bytes] | None:
        """Return the name and the bytes of an exception that is declared, None for any other.

        One of a derived class counts as the first one declared that it derives from.
        """
        for name, each in self._raises.items():
            if isinstance(error, each.cls):
                try:
                    return name, each.encode(error)
                except BaseException:  # a property of a user's exception may raise anything
                    return None
        return None

    def decode_exception(self, name: str, data: bytes) -> BaseException | None:
        """Return the exception that the bytes stand for, None where it is not declared so here."""
        known = self._raises.get(name)
        if known is None:
            return None
        try:
            return known.decode(data)
        except Malformed:
            return None

    def pass_arguments(
        self, arguments: Sequence[Any], named: Mapping[str, Any], other: InterfaceMethod
    ) -> tuple[Any, ...]:
        """Return arguments as a provider in this process gets them.

        Raises:
            Malformed: They do not fit the parameters.
        """
        bound = self.bind(arguments, named)
        if self._is_like(other) and self._may_pass(bound):
            return bound
        return other.decode_arguments(self._encode(bound))

    def pass_result(self, value: Any, other: InterfaceMethod) -> Any:
        """Return a result as a caller in this process gets it.

        Raises:
            Malformed: It is not of the type that the method promises.
        """
        if self._is_like(other) and self._may_return(value):
            return value
        return other.decode_result(self.encode_result(value))

    def _is_like(self, other: InterfaceMethod) -> bool:
        """Return whether it has the very classes of another one of the same signature."""
        if other not in self._likes:
            self._likes[other] = self.hints == other.hints
        return self._likes[other]

    @cached_property
    def _may_pass(self) -> Test:
        items = tuple(self._layout(name) for name in self._shape.parameters)
        return compile_test(ArrayLayout(items, "arguments"))

    @cached_property
    def _may_return(self) -> Test:
        return _is_none if self.returns_nothing else compile_test(self._layout("return"))

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
        names = self._shape.parameters
        return make_dataclass(self.label, [(name, self.hints[name], MISSING) for name in names])

    @cached_property
    def _arguments(self) -> Codec:
        return codec_for(self._record)

    @cached_property
    def _result(self) -> tuple[Codec, type]:
        record = make_dataclass(self.label, [("result", self.hints["return"], MISSING)])
        return codec_for(record), record

    def _layout(self, name: str) -> Layout:
        what = "what it returns" if name == "return" else f"the type of {name}"
        if name not in self.hints:
            raise Malformed(f"{self.label} does not say {what}; annotate it")
        return layout_of_hint(self.hints[name], f"{self.label}: {name}")


class ServiceCaller(Protocol):
    """Calls methods on behalf of a client."""

    def call(
        self,
        method: InterfaceMethod,
        type_name: str,
        arguments: tuple[Any, ...],
        named: Mapping[str, Any],
        timeout_s: float | None,
    ) -> Any:
        """Call a method of the provider; the time-out [s] defaults to that of the port."""


class _Client:
    """Base of clients: a subclass has the methods of one interface."""

    __slots__ = ("_port", "_timeout_s")

    def __init__(self, port: ServiceCaller, timeout_s: float | None) -> None:
        self._port = port
        self._timeout_s = timeout_s


def _calling(type_name: str, method: InterfaceMethod) -> Callable[..., Any]:
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
        self.methods: Mapping[str, InterfaceMethod] = {
            key: InterfaceMethod(self.name, key, value)
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

    def client(self, port: ServiceCaller, timeout_s: float | None) -> object:
        """Return an object with the methods of the interface, which calls through `port`."""
        return self._client(port, timeout_s)

    def check_methods(self, implementation: object, where: str) -> None:
        """Refuse an implementation without the methods, or with some that a call would not run.

        Raises:
            Refused: So; names the implementation and its methods, behind `where`.
        """
        kind = type(implementation).__name__
        missing = [n for n in self.methods if not callable(getattr(implementation, n, None))]
        if missing:
            what = f"{kind} does not implement {self.name}: it lacks {', '.join(missing)}"
            raise Refused(f"{where}: {what}")
        for name in self.methods:
            unfit = unfit_kind(getattr(implementation, name))
            if unfit:
                raise Refused(f"{where}: {kind}.{name} is {unfit}")

    def check(self, implementation: object, where: str) -> None:
        """Refuse, too, an implementation whose methods do not take the arguments of a call.

        Raises:
            Refused: So; names the method and its place.
        """
        self.check_methods(implementation, where)
        for name, method in self.methods.items():
            function = getattr(implementation, name)
            try:
                method.call(inspect.signature(function).bind, method.parameters)
            except ValueError:  # it is not written in Python, and has no signature
                continue
            except TypeError as error:
                wanted = f"{method.label}({', '.join(method.parameters)})"
                what = f"{type(implementation).__name__}.{name} does not do as {wanted}"
                why = describe_failure(error, function)
                raise Refused(f"{where}: {what}: {why}") from error


class _Exception:
    """An exception that a method declares.

    Attributes:
        members: Layouts of what it carries, by name.
    """

    def __init__(self, cls: type[BaseException], label: str) -> None:
        if not (isinstance(cls, type) and issubclass(cls, Exception)):
            raise Malformed(f"{label} raises what is no exception: {cls!r}")
        self.cls = cls
        hints: dict[str, Any] = {"text": str}
        self._is_plain = "__init__" not in {n for each in _own_bases(cls) for n in vars(each)}
        if not self._is_plain:
            function: Any = cls.__init__
            shape = _without_self(inspect.signature(function)).parameters
            declared = _hints(function, cls.__name__)
            hints = {name: declared.get(name) for name in shape}
        self.members = {
            name: layout_of_hint(hint, f"{label}: {cls.__name__}.{name}")
            for name, hint in hints.items()
        }
        self._names = tuple(hints)
        columns = [(name, hint, MISSING) for name, hint in hints.items()]
        self._record = make_dataclass(cls.__name__, columns)

    def encode(self, error: BaseException) -> bytes:
        """Return the arguments of its constructor as bytes.

        Raises:
            Malformed: It does not have that, or of another type.
        """
        if self._is_plain:
            text = error.args[0] if len(error.args) == 1 else str(error)
            return codec_for(self._record).encode(self._record(str(text)))
        if not self._names:
            return b""
        try:
            values = [getattr(error, name) for name in self._names]
        except AttributeError as missing:
            raise Malformed(f"{self.cls.__name__}: {missing}") from None
        return codec_for(self._record).encode(self._record(*values))

    def decode(self, data: bytes) -> BaseException:
        """Return the exception.

        Raises:
            Malformed: They are no bytes of it, or its constructor fails.
        """
        record = codec_for(self._record).decode(data) if self._names else None
        values = {name: getattr(record, name) for name in self._names}
        try:
            if self._is_plain:
                return self.cls(values["text"]) if values["text"] else self.cls()
            return self.cls(**values)
        except Exception as error:
            raise Malformed(f"{self.cls.__name__} cannot be made: {error}") from None


def _own_bases(cls: type) -> Iterator[type]:
    """Yield a class of exceptions and those it derives from that are written in Python."""
    yield from (each for each in cls.__mro__ if each.__module__ != "builtins")


def _is_none(value: Any) -> bool:
    """Return whether it is None."""
    return value is None


def _without_self(signature: inspect.Signature) -> inspect.Signature:
    parameters = list(signature.parameters.values())[1:]
    return signature.replace(parameters=parameters)


def _hints(function: Callable[..., Any], label: str) -> dict[str, Any]:
    plain = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    for parameter in list(inspect.signature(function).parameters.values())[1:]:
        if parameter.kind not in plain:
            raise Malformed(f"{label} has parameter {parameter}, which cannot be carried")
    try:
        return get_type_hints(function, include_extras=True)
    except (NameError, TypeError) as error:
        raise Malformed(f"{label}: its annotations cannot be read: {error}") from error
