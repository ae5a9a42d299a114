"""Functional properties: SET starts an action, GET reports its state and its outcome.

Who runs the work (at once, or on a thread) is given from outside; the outcome comes back through
the owner of the service, so state is touched by one thread only.
"""

from __future__ import annotations

import dataclasses
from collections.abc import AsyncGenerator, Callable, Generator, Mapping
from functools import partial
from typing import Any, TypeVar

from rtkit.guard import kind_and_text
from rtkit.property.codes import PropertyError
from rtkit.property.conversion import child_of
from rtkit.property.messages import failed
from rtkit.property.property_spec import RequestParameter
from rtkit.property.types import Content, check
from rtkit.property.user_code import AT_ONCE, Finished, UserCode, Work, is_coroutine
from rtkit.property.values import Element, Value, Word
from rtkit.property.writing import write

F = TypeVar("F", bound=Callable[..., Any])
Arguments = tuple[tuple[Value, ...], dict[str, Value]]
Report = Callable[[object], object]
Run = Callable[[Work, Finished], None]
"""Runs some work; has the owner of the service take what came of it."""
_NOTHING_LEFT = Element("remaining")


def behavior(function: F) -> F:
    """Make a behaviour of a method: an action with a target, which a new SET replaces.

    A generator or coroutine function. A SET while it runs stops it at its next ``yield`` or
    ``await``, and begins anew with the new arguments. A GET tells
    ``<behavior state="running"><target>…</target><remaining>…</remaining></behavior>``: the
    arguments of the last SET, and what it yielded last: what remains, or a mapping or dataclass
    with ``remaining`` and whatever else there is to tell. ``SET NAME.stop true`` stops it, and
    ``SET PLACE.stop true`` all actions below a place.
    """
    function.__dict__["is_behavior"] = True
    return function


class _Call:
    """One call of an action.

    Attributes:
        stop: Ends it at its next step, None where nothing does.
    """

    def __init__(
        self, arguments: Arguments, changed: Callable[[], None], user_code: UserCode
    ) -> None:
        self.arguments = arguments
        self.changed = changed
        self.user_code = user_code
        self.progress: tuple[Element, ...] = ()
        self.is_reporting = False
        self.is_to_stop = False
        self.stop: Callable[[], object] | None = None

    def halt(self) -> None:
        self.is_to_stop = True
        if self.stop is not None:
            self.stop()

    def cancellable(self, cancel: Callable[[], object]) -> None:
        self.stop = cancel
        if self.is_to_stop:
            cancel()


class FunctionalProperty:
    """Action with its arguments.

    What is called and yields can be stopped whenever it yields; what it yields is how far it is. A
    coroutine can be stopped whenever it waits.

    Args:
        function: Function to call.
        parameters: Its arguments, in order.
        convert: Makes a value of what it returns.
        run: Runner that calls it; None for that of the service.
        is_open: It takes any arguments, by place only.
        is_behavior: See `behavior`.
        fit: Raises what is wrong with an argument beyond its declared type.

    Attributes:
        state: ``idle``, ``running``, ``done``, ``failed`` or ``stopped``.
    """

    def __init__(
        self,
        function: Callable[..., object],
        parameters: tuple[RequestParameter, ...] = (),
        convert: Callable[[object], Content] = lambda result: result,  # type: ignore[assignment,return-value]
        run: Run | None = None,
        *,
        is_open: bool = False,
        is_behavior: bool = False,
        fit: Callable[[str, Value], object] = lambda key, value: None,
    ) -> None:
        self.state = "idle"
        self.parameters = parameters
        self._function = function
        self._convert = convert
        self._run = run
        self._is_open = is_open
        self._is_behavior = is_behavior
        self._fit = fit
        self._result: Content | None = None
        self._error: tuple[str, str] | None = None
        self._last: _Call | None = None
        self._at_work: _Call | None = None

    def describe(self) -> Element:
        """Return how it stands: ``<call state="done"><result>…</result></call>``.

        What it yielded last is its ``progress``; of behaviours see `behavior`.
        """
        children = [] if self._last is None else list(self._last.progress)
        if self._is_behavior:
            children = [self._target(), *(children or [_NOTHING_LEFT])]
        if self._error is not None:
            children.append(Element("error", {"code": self._error[0]}, (), self._error[1]))
        elif self._result is not None and not isinstance(self._result, bytes):
            children.append(Element("result", {}, (), self._result))
        kind = "behavior" if self._is_behavior else "call"
        return Element(kind, {"state": self.state}, tuple(children))

    def _target(self) -> Element:
        given, named = ((), {}) if self._last is None else self._last.arguments
        values = [*given, *named.values()]
        if len(values) == 1 and isinstance(only := values[0], Element):
            return Element("target", only.attributes, only.children, only.leaf)
        if len(values) == 1:
            return child_of("target", values[0])
        return Element("target", {}, tuple(child_of(key, each) for key, each in named.items()))

    def bind(self, value: Value, named: dict[str, Value]) -> Arguments:
        """Return the arguments that a SET stands for, by place and by name.

        Raises:
            PropertyError: ``bad-value``: too many, too few, or of another type; or of the code of
                the choices that it is not among.
        """
        given: tuple[Value, ...] = value if isinstance(value, tuple) else (value,)
        if isinstance(value, str) and not isinstance(value, Word) and not value:
            given = ()
        if self._is_open:
            return given, {}
        if len(self.parameters) == 1 and isinstance(value, tuple) and not named:
            given = self._only(self.parameters[0], value)
        free = [each for each in self.parameters if each.key not in named]
        if len(given) > len(free):
            raise PropertyError("bad-value", f"expected at most {len(free)} arguments")
        bound = dict(named)
        for parameter, argument in zip(free, given, strict=False):
            bound[parameter.key] = argument
        wanted = [each for each in self.parameters if each.key in bound or each.default is None]
        return (), {each.key: self._checked(each, bound) for each in wanted}

    @staticmethod
    def _only(parameter: RequestParameter, value: tuple[Value, ...]) -> tuple[Value, ...]:
        """Distinguish a group that is the only argument from a group that holds it."""
        if parameter.type.base == "any" and len(value) > 1:
            return (value,)
        if parameter.type.base in ("vector", "list") and not (
            len(value) == 1 and isinstance(value[0], tuple)
        ):
            return (value,)
        return value

    def _checked(self, parameter: RequestParameter, bound: dict[str, Value]) -> Value:
        if parameter.key not in bound:
            raise PropertyError("bad-value", f"argument is missing: {parameter.key}")
        try:
            value = check(parameter.type, bound[parameter.key])
        except PropertyError as error:
            raise PropertyError("bad-value", f"{parameter.key}: {error}") from None
        try:
            parameter.choose(value)  # type: ignore[arg-type]
            if parameter.spec is not None:
                parameter.spec.within(value)
            self._fit(parameter.key, value)  # type: ignore[arg-type]
        except (ValueError, TypeError, PropertyError) as error:
            code = error.code if isinstance(error, PropertyError) else "bad-value"
            raise PropertyError(code, f"{parameter.key}: {error}") from None
        return value  # type: ignore[return-value]

    def start(
        self, arguments: Arguments, changed: Callable[[], None], user_code: UserCode = AT_ONCE
    ) -> None:
        """Begin; `changed` is called whenever it stands otherwise.

        Raises:
            PropertyError: ``busy``: it runs already and is no behaviour, or very much else does.
        """
        if self.state == "running":
            if not self._is_behavior or self._last is None:
                raise PropertyError("busy", "it is running")
            self.state = "stopped"
            self._last.halt()
            self._last.changed()
        before = self.state, self._result, self._error, self._last
        self._last = call = _Call(arguments, changed, user_code)
        self.state, self._result, self._error = "running", None, None
        try:
            if self._at_work is None:
                self._begin(call)
        except PropertyError:
            self.state, self._result, self._error, self._last = before
            raise
        if self.state == "running":
            changed()

    def _begin(self, call: _Call) -> None:
        """Have a call done; when it has ended, the one that has replaced it meanwhile.

        Raises:
            PropertyError: ``busy``: very much else runs.
        """
        self._at_work = call

        def finished(result: object, error: BaseException | None) -> None:
            self._at_work = None
            last = self._last
            if last is call:
                self._end(call, result, error)
            elif last is not None and self.state == "running":
                try:
                    self._begin(last)
                except PropertyError as refusal:
                    self._end(last, None, refusal)

        try:
            (self._run or call.user_code.start)(partial(self._work, call), finished)
        except PropertyError:
            self._at_work = None
            raise

    def _end(self, call: _Call, result: object, error: BaseException | None) -> None:
        self._result = result  # type: ignore[assignment]
        if error is not None:
            answer = failed(error)
            bad = isinstance(error, ValueError | TypeError)
            text = kind_and_text(error) if bad else str(answer.payload)
            self._error = ("bad-value" if bad else answer.error, text)
        self.state = "failed" if error else "stopped" if call.is_to_stop else "done"
        call.changed()

    def _work(self, call: _Call) -> Content | None:
        """Call it, to its end; on the thread that is for it."""
        outcome = self._function(*call.arguments[0], **call.arguments[1])
        report = partial(self._report, call)
        if isinstance(outcome, Generator):
            outcome = _through(call, outcome, report)
        elif is_coroutine(outcome):
            outcome = call.user_code.awaited(outcome, call.cancellable)
        elif isinstance(outcome, AsyncGenerator):
            outcome = call.user_code.awaited(_awaited(outcome, report), call.cancellable)
        return None if outcome is None else self._convert(outcome)

    def _report(self, call: _Call, step: object) -> None:
        """Report yielded values; of those that come too fast to be sent, only the latest."""
        if step is None:
            return
        call.progress = self._shown(step)
        if not call.is_reporting:
            call.is_reporting = True
            call.user_code.post(partial(self._progressed, call))

    def _shown(self, step: object) -> tuple[Element, ...]:
        """Return how far it is, as elements."""
        if self._is_behavior and isinstance(step, Mapping):
            children = tuple(
                child_of(str(key), _value(self._convert(each))) for key, each in step.items()
            )
            write(Element("progress", {}, children))  # a key may be no name
        else:
            value = self._convert(step)
            if isinstance(value, bytes):
                return ()
            if not self._is_behavior:
                return (Element("progress", {}, (), value),)
            is_record = dataclasses.is_dataclass(step) and isinstance(value, Element)
            children = value.children if is_record else (child_of("remaining", value),)  # type: ignore[union-attr]
        has_rest = any(each.name == "remaining" for each in children)
        return children if has_rest else (*children, _NOTHING_LEFT)

    def _progressed(self, call: _Call) -> None:
        call.is_reporting = False
        if call is self._last and self.state == "running":
            call.changed()

    def stop(self) -> None:
        """Have it end at its next step; an action that does not run stays as it is.

        Raises:
            PropertyError: ``conflict``: it cannot be stopped.
        """
        call = self._last
        if self.state != "running" or call is None:
            return
        if call is not self._at_work:
            self.state = "stopped"
            call.changed()
        elif call.stop is None and not self._is_behavior:
            raise PropertyError("conflict", "it cannot be stopped")
        else:
            call.halt()


def _through(call: _Call, steps: Generator[object, object, object], report: Report) -> object:
    call.stop = lambda: None
    while True:
        if call.is_to_stop:
            steps.close()
            return None
        try:
            report(next(steps))
        except StopIteration as end:
            call.stop = None
            return end.value


async def _awaited(steps: AsyncGenerator[object, object], report: Report) -> None:
    async for step in steps:
        report(step)


def _value(content: Content) -> Value:
    return "" if isinstance(content, bytes) else content
