"""Encodes calls of services: requests of the caller and replies of the provider.

A request is one line (deadline, interface, method) and the arguments as CDR; a reply is the kind
of its outcome on one line and the result as CDR, or the reason as text. For a declared exception
the line has its name and the reason, too, and its arguments follow as CDR. The deadline is in
nanoseconds of the monotonic clock, which all processes of one host share.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from rtkit.component.contexts.callbacks import describe_failure
from rtkit.component.current import current
from rtkit.component.services.interface import Interface, InterfaceMethod, Raised
from rtkit.component.services.reentrancy import Reentrancy, Run
from rtkit.errors import Malformed, NotFound, Refused, RtkitError, Unreachable, from_kind

NANOSECONDS = 1_000_000_000
Send = Callable[[bytes, float], bytes]
"""Takes a request and a time-out [s], returns the reply or raises `Unreachable`."""
_OK = "ok"
_RAISED = "raised\t"


class CallTarget(Protocol):
    """The callable end of a connector: a provider in this process or another one."""

    def call(
        self,
        method: InterfaceMethod,
        arguments: Sequence[Any],
        named: Mapping[str, Any],
        timeout_s: float,
    ) -> Any:
        """Call a method.

        Raises:
            Malformed: The arguments, or the result, are not what the interface says.
            Refused: The provider raised an exception; the message names it.
            Unreachable: No answer in time, or the provider is gone.
        """


class ProvidedInterface(NamedTuple):
    """One provided interface and its implementation.

    Attributes:
        label: ``Provider0.myservice``, for messages.
        called: Called after each call.
    """

    interface: Interface
    implementation: object
    label: str
    called: Callable[[], object]

    def invoke(self, method: InterfaceMethod, arguments: Sequence[Any]) -> Any:
        """Call the implementation on this thread; raise nothing but an `RtkitError`.

        Raises:
            Refused: It raised an exception; `Raised` when that is declared.
        """
        function = getattr(self.implementation, method.name)
        before = current.set(self.label.rpartition(".")[0])
        try:
            return method.call(function, arguments)
        except BaseException as error:
            why = describe_failure(error, function)
            text = f"{self.label}: {method.label} failed: {why}"
            declared = method.encode_exception(error)
            raise (Raised(text, *declared) if declared else Refused(text)) from error
        finally:
            current.reset(before)
            self.called()


class CallRouting(NamedTuple):
    """The caller and provider of calls within a process, and the means to bound a call that hangs.

    Attributes:
        label: ``Consumer0.port: Provider0.port``, for messages.
    """

    caller: str
    provider: str
    label: str
    crossings: Reentrancy
    run: Run


class Direct:
    """A provider in this process: its implementation runs on the caller's thread.

    But for a call that closes a circle, which may be a deadlock: that runs on a thread of its own,
    and its caller waits no longer than for a provider in another process.
    """

    def __init__(self, served: ProvidedInterface, passage: CallRouting | None = None) -> None:
        self._served = served
        self._passage = passage

    @property
    def implementation(self) -> object:
        """The object that does it."""
        return self._served.implementation

    def call(
        self,
        method: InterfaceMethod,
        arguments: Sequence[Any],
        named: Mapping[str, Any],
        timeout_s: float,
    ) -> Any:
        """See `CallTarget.call`; the time-out bounds only calls that close a circle."""
        own = self._served.interface.by_signature.get(method.signature)
        if own is None:
            raise _differs(self._served, method.signature)
        passed = method.pass_arguments(arguments, named, own)
        try:
            result = self._invoke(method, own, passed, timeout_s)
        except Raised as raised:
            raise _rebuilt(method, raised) from raised.__cause__
        try:
            return own.pass_result(result, method)
        except Malformed as malformed:
            raise Malformed(f"{self._served.label}: {malformed}") from None

    def _invoke(
        self,
        method: InterfaceMethod,
        own: InterfaceMethod,
        arguments: tuple[Any, ...],
        timeout_s: float,
    ) -> Any:
        passage = self._passage
        if passage is None:
            return self._served.invoke(own, arguments)
        call, circle = passage.crossings.enter(passage.caller, passage.provider)
        try:
            if not circle:
                return self._served.invoke(own, arguments)
            return passage.run(lambda: self._served.invoke(own, arguments), timeout_s)
        except TimeoutError as error:
            late = str(error) or f"no answer within {timeout_s:g} s"
            raise Unreachable(
                f"{passage.label}: {method.label}: {late};"
                f" they call each other: {' → '.join(circle)}"
            ) from None
        finally:
            passage.crossings.leave(call)


class Remote:
    """A provider in another process."""

    def __init__(self, type_name: str, label: str, send: Send, clock: Callable[[], int]) -> None:
        self._type_name = type_name
        self._label = label
        self._send = send
        self._clock = clock

    def call(
        self,
        method: InterfaceMethod,
        arguments: Sequence[Any],
        named: Mapping[str, Any],
        timeout_s: float,
    ) -> Any:
        """See `CallTarget.call`."""
        body = method.encode_arguments(arguments, named)
        call = f"{self._type_name}\t{method.signature}\n".encode() + body
        try:
            reply = self.pass_on(call, timeout_s)
        except Unreachable as error:
            raise Unreachable(f"{self._label}: {method.label}: {error}") from None
        head, _, tail = reply.partition(b"\n")
        kind = head.decode()
        if kind.startswith(_RAISED):
            _, name, text = kind.split("\t", 2)
            raise _rebuilt(method, Raised(text, name, tail))
        if kind != _OK:
            raise from_kind(kind, tail.decode())
        return method.decode_result(tail)

    def pass_on(self, call: bytes, timeout_s: float) -> bytes:
        """Send a call that is encoded but for its deadline; return the encoded reply.

        Raises:
            Unreachable: No answer in time, or the provider is gone.
        """
        deadline = self._clock() + int(timeout_s * NANOSECONDS)
        return self._send(f"{deadline}\t".encode() + call, timeout_s)


def _rebuilt(method: InterfaceMethod, raised: Raised) -> BaseException:
    """Return the exception for the caller: its own declared one, else a refusal."""
    error = method.decode_exception(raised.name, raised.data)
    return Refused(str(raised)) if error is None else error


def answer(request: bytes, served: Sequence[ProvidedInterface], now_ns: int) -> bytes:
    """Serve one request and return the reply; rubbish gets a reply, too."""
    try:
        return _OK.encode() + b"\n" + _serve(request, served, now_ns)
    except Raised as raised:
        text = str(raised).replace("\n", " ")
        return f"{_RAISED}{raised.name}\t{text}\n".encode(errors="replace") + raised.data
    except RtkitError as error:
        return f"{error.kind}\n{error}".encode()


def _serve(request: bytes, served: Sequence[ProvidedInterface], now_ns: int) -> bytes:
    head, newline, body = request.partition(b"\n")
    parts = head.decode(errors="replace").split("\t")
    if not newline or len(parts) != 3 or not parts[0].isdecimal():
        raise Malformed("what arrived is no call")
    deadline, type_name, signature = parts
    if int(deadline) < now_ns:
        raise Unreachable("the call came when nobody waited for it any more")
    for each in served:
        if each.interface.name == type_name:
            method = each.interface.by_signature.get(signature)
            if method is None:
                raise _differs(each, signature)
            result = each.invoke(method, method.decode_arguments(body))
            try:
                return method.encode_result(result)
            except Malformed as error:
                raise Malformed(f"{each.label}: {error}") from None
    raise NotFound(f"interface {type_name} is not provided here")


def _differs(served: ProvidedInterface, signature: str) -> Refused:
    name = signature.partition("(")[0]
    own = served.interface.methods.get(name)
    known = f"{name} is {own.signature}" if own else f"there is no {name}"
    return Refused(f"{served.label}: interfaces differ: {known} there, called is {signature}")
