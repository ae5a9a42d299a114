"""Callbacks of a component: declares them, and contains their failures when it runs them."""

from __future__ import annotations

from collections.abc import Callable
from types import CoroutineType, TracebackType
from typing import Any

from rtkit.component.contexts.input_wait import InputEnded
from rtkit.guard import kind_and_text
from rtkit.rtc.enums import ReturnCode

_HOME = "rtkit.component."
_ALIKE = 0.8
"""Similarity to a callback's name from which a method counts as a misspelt callback."""
CO_GENERATOR, CO_COROUTINE, CO_ASYNC_GENERATOR = 0x20, 0x80, 0x200
"""Flags of code objects, as `inspect` has them, which takes long to import."""


class Callbacks:
    """The twelve actions of the OMG RTC specification; the defaults do nothing.

    Each returns a `ReturnCode` or None, which means RTC_OK. Another code, or any exception, is
    a failure of this component and of nothing else. `context` is the id of the execution context
    that calls, on the thread that drives it; the two without it are called by the thread that
    makes or deletes the component.
    """

    def on_initialize(self) -> ReturnCode | None:
        """Prepare: called once, before any other. A failure means that it is not created."""

    def on_finalize(self) -> ReturnCode | None:
        """Clean up: called once, last. A failure is reported."""

    def on_startup(self, context: str) -> ReturnCode | None:
        """React to the start of an execution context. A failure is reported."""

    def on_shutdown(self, context: str) -> ReturnCode | None:
        """React to the stop of an execution context. A failure is reported."""

    def on_activated(self, context: str) -> ReturnCode | None:
        """Go from Inactive to Active: called once. A failure leads to Error."""

    def on_deactivated(self, context: str) -> ReturnCode | None:
        """Go from Active to Inactive: called once. A failure is reported."""

    def on_aborting(self, context: str) -> ReturnCode | None:
        """Enter Error: called once, after the failure. A failure here is reported."""

    def on_error(self, context: str) -> ReturnCode | None:
        """Wait in Error: called every period. A failure is reported when its text is new."""

    def on_reset(self, context: str) -> ReturnCode | None:
        """Go from Error to Inactive: called once. A failure leaves it in Error."""

    def on_execute(self, context: str) -> ReturnCode | None:
        """Do the work of one period while Active. A failure leads to Error."""

    def on_state_update(self, context: str) -> ReturnCode | None:
        """Publish new state, after all participants executed. A failure leads to Error."""

    def on_rate_changed(self, context: str) -> ReturnCode | None:
        """React to a new rate of the execution context. A failure leads to Error."""


escaping: tuple[type[BaseException], ...] = ()
"""Exceptions with which callbacks may end the process; set only for components run by hand."""

CALLBACKS = tuple(name for name in vars(Callbacks) if name.startswith("on_"))


def near_misses(cls: type[Callbacks]) -> list[str]:
    """Return warnings about methods that look like callbacks but are never called."""
    from rtkit.rtc.nearest import nearest

    ours = {
        name for each in cls.__mro__ if each.__module__.startswith(_HOME) for name in vars(each)
    }
    own = {
        name: nearest(name, CALLBACKS, 1, _ALIKE)
        for each in cls.__mro__
        for name, value in vars(each).items()
        if name not in ours and name.lower().startswith("on") and callable(value)
    }
    return [
        f"{cls.__name__}.{name} is no callback (did you mean {near[0]}?)"
        for name, near in own.items()
        if near
    ]


def overrides(component: object, name: str) -> bool:
    """Return whether `component` has a callback of its own for `name`."""
    callback = getattr(component, name)
    return getattr(callback, "__func__", callback) is not getattr(Callbacks, name)


def unfit_kind(function: object) -> str:
    """Return the reason why a plain call would not run a function; empty when it would.

    Calling a coroutine function only makes a coroutine, which nothing awaits, and of a generator
    nothing runs before somebody asks it for a value.
    """
    code = getattr(getattr(function, "__func__", function), "__code__", None)
    flags = getattr(code, "co_flags", 0)
    if flags & (CO_COROUTINE | CO_ASYNC_GENERATOR):
        return "a coroutine function, which nothing awaits: write def instead of async def"
    if flags & CO_GENERATOR:
        return "a generator function, of which nothing runs: write it without yield"
    return ""


class Failure(str):
    """The failure of a callback in one line; an empty text when there was none.

    Attributes:
        error: Exception that it raised; None when it returned a code, or did well.
    """

    __slots__ = ("error",)

    error: BaseException | None

    def __new__(cls, text: str = "", error: BaseException | None = None) -> Failure:  # noqa: D102
        failure = super().__new__(cls, text)
        failure.error = error
        return failure


def attempt(callback: Callable[..., Any], *arguments: str) -> Failure:
    """Run a callback; return its failure, which is empty on success.

    Nothing that the callback raises gets out: not SystemExit, not KeyboardInterrupt either,
    because one component must not end the process that it shares with others; but see `escaping`.
    One that waited for input, and is to be left, has done well (see `input_wait`).
    """
    try:
        code = callback(*arguments)
        if code is None or code == ReturnCode.OK:
            return Failure()
        if isinstance(code, CoroutineType):
            code.close()  # else Python warns that the coroutine was never awaited
            return Failure(f"returned a coroutine, which nothing awaits ({_place(None, callback)})")
        return Failure(f"returned {code} ({_place(None, callback)})")
    except escaping:
        raise
    except InputEnded:
        return Failure()
    except BaseException as error:
        return Failure(describe_failure(error, callback), error)


def describe_failure(error: BaseException, callback: Callable[..., Any]) -> str:
    """Return ``ValueError: text (file.py:12 in on_execute)`` on one line.

    The place is the innermost line of the file that defines the callback, so that a mistake in
    a call to a library is shown where its author can mend it. Where that is in another function,
    the callback is named, too.
    """
    place = _place(error.__traceback__, callback)
    return f"{kind_and_text(error)} ({place})"


def _place(traceback: TracebackType | None, callback: Callable[..., Any]) -> str:
    code = getattr(getattr(callback, "__func__", callback), "__code__", None)
    file, line, name = "", 0, repr(callback)
    caller = code.co_name if code else ""
    if code:
        file, line, name = code.co_filename, code.co_firstlineno, code.co_name
    while traceback is not None:
        frame = traceback.tb_frame.f_code
        if frame.co_filename == file or not code:
            file, line, name = frame.co_filename, traceback.tb_lineno, frame.co_name
        traceback = traceback.tb_next
    via = f", called by {caller}" if caller not in ("", name) else ""
    return f"{file.rpartition('/')[2]}:{line} in {name}{via}"
