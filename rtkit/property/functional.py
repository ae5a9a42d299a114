"""Functional properties: SET starts an action, GET reports its state and its outcome.

Who runs the work (at once, or on a thread) is given from outside; the outcome comes back through
the owner of the service, so state is touched by one thread only.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator, Callable, Generator
from functools import partial

from rtkit.guard import kind_and_text
from rtkit.property.codes import PropertyError
from rtkit.property.messages import failed
from rtkit.property.property_spec import RequestParameter
from rtkit.property.types import Content, check
from rtkit.property.user_code import AT_ONCE, Finished, UserCode, Work, is_coroutine
from rtkit.property.values import Element, Value, Word

Report = Callable[[object], object]
Run = Callable[[Work, Finished], None]
"""Runs some work; has the owner of the service take what came of it."""


class FunctionalProperty:
    """Action with its arguments.

    What is called and yields can be stopped whenever it yields; what it yields is how far it is. A
    coroutine can be stopped whenever it waits.

    Args:
        function: What is called.
        parameters: Its arguments, in order.
        convert: Makes a value of what it returns.
        run: Who calls it; None for whom the service has for it.
        is_open: It takes any arguments, by place only.

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
    ) -> None:
        self.state = "idle"
        self.parameters = parameters
        self._function = function
        self._convert = convert
        self._run = run
        self._is_open = is_open
        self._result: Content | None = None
        self._error: tuple[str, str] | None = None
        self._is_to_stop = False
        self._stop: Callable[[], object] | None = None
        self._progress: Content | None = None
        self._is_reporting = False

    def describe(self) -> Element:
        """Return how it stands: ``<call state="done"><result>…</result></call>``.

        What it yielded last is its ``progress``.
        """
        children: list[Element] = []
        if self._progress is not None and not isinstance(self._progress, bytes):
            children.append(Element("progress", {}, (), self._progress))
        if self._error is not None:
            children.append(Element("error", {"code": self._error[0]}, (), self._error[1]))
        elif self._result is not None and not isinstance(self._result, bytes):
            children.append(Element("result", {}, (), self._result))
        return Element("call", {"state": self.state}, tuple(children))

    def bind(
        self, value: Value, named: dict[str, Value]
    ) -> tuple[tuple[Value, ...], dict[str, Value]]:
        """Return the arguments that a SET stands for, by place and by name.

        Raises:
            PropertyError: ``bad-value``: too many, too few, or of another type.
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
        if parameter.choices and value not in parameter.choices:
            raise PropertyError("bad-value", f"{parameter.key}: not one of its choices")
        return value  # type: ignore[return-value]

    def start(
        self,
        arguments: tuple[tuple[Value, ...], dict[str, Value]],
        changed: Callable[[], None],
        user_code: UserCode = AT_ONCE,
    ) -> None:
        """Begin; `changed` is called whenever it stands otherwise.

        Raises:
            PropertyError: ``busy``: it runs already, or very much else does.
        """
        if self.state == "running":
            raise PropertyError("busy", "it is running")
        before = self.state, self._result, self._error, self._progress
        self.state, self._result, self._error, self._progress = "running", None, None, None
        self._is_to_stop, self._stop = False, None

        def finished(result: object, error: BaseException | None) -> None:
            self._end(result, error)
            changed()

        work = partial(self._work, arguments, user_code, changed)
        try:
            (self._run or user_code.start)(work, finished)
        except PropertyError:
            self.state, self._result, self._error, self._progress = before
            raise
        if self.state == "running":
            changed()

    def _end(self, result: object, error: BaseException | None) -> None:
        self._result = result  # type: ignore[assignment]
        if error is not None:
            answer = failed(error)
            bad = isinstance(error, ValueError | TypeError)
            text = kind_and_text(error) if bad else str(answer.payload)
            self._error = ("bad-value" if bad else answer.error, text)
        self.state = "failed" if error else "stopped" if self._is_to_stop else "done"

    def _work(
        self,
        arguments: tuple[tuple[Value, ...], dict[str, Value]],
        user_code: UserCode,
        changed: Callable[[], None],
    ) -> Content | None:
        """Call it, to its end; on the thread that is for it."""
        outcome = self._function(*arguments[0], **arguments[1])
        report = partial(self._report, user_code, changed)
        if isinstance(outcome, Generator):
            outcome = self._through(outcome, report)
        elif is_coroutine(outcome):
            outcome = user_code.awaited(outcome, self._cancellable)
        elif isinstance(outcome, AsyncGenerator):
            outcome = user_code.awaited(_through(outcome, report), self._cancellable)
        return None if outcome is None else self._convert(outcome)

    def _through(self, steps: Generator[object, object, object], report: Report) -> object:
        self._stop = lambda: None
        while True:
            if self._is_to_stop:
                steps.close()
                return None
            try:
                report(next(steps))
            except StopIteration as end:
                self._stop = None
                return end.value

    def _cancellable(self, cancel: Callable[[], object]) -> None:
        self._stop = cancel

    def _report(self, user_code: UserCode, changed: Callable[[], None], step: object) -> None:
        """Report yielded values; of those that come too fast to be sent, only the latest."""
        if step is None:
            return
        self._progress = self._convert(step)
        if not self._is_reporting:
            self._is_reporting = True
            user_code.post(partial(self._progressed, changed))

    def _progressed(self, changed: Callable[[], None]) -> None:
        self._is_reporting = False
        if self.state == "running":
            changed()

    def stop(self) -> None:
        """Have it end at its next step; what does not run stays as it is.

        Raises:
            PropertyError: ``conflict``: it cannot be stopped.
        """
        if self.state != "running":
            return
        if self._stop is None:
            raise PropertyError("conflict", "it cannot be stopped")
        self._is_to_stop = True
        self._stop()


async def _through(steps: AsyncGenerator[object, object], report: Report) -> None:
    async for step in steps:
        report(step)
