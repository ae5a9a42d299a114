"""Functional properties: SET starts an action, GET tells how it stands and what came of it.

Who runs the work (at once, or on a thread) is given from outside; the outcome comes back through
the owner of the service, so state is touched by one thread only.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Protocol

from rtkit.property.codes import PropertyError
from rtkit.property.messages import failed
from rtkit.property.spec import Parameter
from rtkit.property.types import Content, check
from rtkit.property.values import Element, Value, Word

Work = Callable[[], object]
Finished = Callable[[object, BaseException | None], None]


class Run(Protocol):
    """Runs some work; has the owner of the service call `finished` with what came of it."""

    def __call__(self, work: Work, finished: Finished) -> None:
        """Begin."""
        ...


def run_at_once(work: Work, finished: Finished) -> None:
    """Run some work before returning."""
    try:
        result = work()
    except Exception as error:
        finished(None, error)
    else:
        finished(result, None)


class Function:
    """An action with its arguments.

    What is called and yields can be stopped whenever it yields; what it yields is how far it is.

    Args:
        function: What is called.
        parameters: Its arguments, in order.
        convert: Makes a value of what it returns.
        run: Who calls it.
        is_open: It takes any arguments, by place only.

    Attributes:
        state: ``idle``, ``running``, ``done``, ``failed`` or ``stopped``.
    """

    def __init__(
        self,
        function: Callable[..., object],
        parameters: tuple[Parameter, ...] = (),
        convert: Callable[[object], Content] = lambda result: result,  # type: ignore[assignment,return-value]
        run: Run = run_at_once,
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
        self._can_stop = False

    def describe(self) -> Element:
        """Return how it stands: ``<call state="done"><result>…</result></call>``."""
        children: list[Element] = []
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
    def _only(parameter: Parameter, value: tuple[Value, ...]) -> tuple[Value, ...]:
        """Tell a group that is the only argument from a group that holds it."""
        if parameter.type.base in ("vector", "list") and not (
            len(value) == 1 and isinstance(value[0], tuple)
        ):
            return (value,)
        return value

    def _checked(self, parameter: Parameter, bound: dict[str, Value]) -> Value:
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
    ) -> None:
        """Begin; `changed` is called whenever it stands otherwise.

        Raises:
            PropertyError: ``busy``: it runs already.
        """
        if self.state == "running":
            raise PropertyError("busy", "it is running")
        self.state, self._result, self._error = "running", None, None
        self._is_to_stop = self._can_stop = False
        changed()

        def finished(result: object, error: BaseException | None) -> None:
            if error is None:
                try:
                    self._result = None if result is None else self._convert(result)
                except PropertyError as refused:
                    error = refused
            if error is not None:
                answer = failed(error)
                bad = isinstance(error, ValueError | TypeError)
                self._error = ("bad-value" if bad else answer.error, str(answer.payload))
            self.state = "failed" if error else "stopped" if self._is_to_stop else "done"
            changed()

        self._run(lambda: self._work(arguments), finished)

    def _work(self, arguments: tuple[tuple[Value, ...], dict[str, Value]]) -> object:
        outcome = self._function(*arguments[0], **arguments[1])
        if not isinstance(outcome, Generator):
            return outcome
        self._can_stop = True
        while True:
            if self._is_to_stop:
                outcome.close()
                return None
            try:
                next(outcome)
            except StopIteration as end:
                self._can_stop = False
                return end.value

    def stop(self) -> None:
        """Have it end at its next step; what does not run stays as it is.

        Raises:
            PropertyError: ``conflict``: it cannot be stopped.
        """
        if self.state != "running":
            return
        if not self._can_stop:
            raise PropertyError("conflict", "it cannot be stopped")
        self._is_to_stop = True
