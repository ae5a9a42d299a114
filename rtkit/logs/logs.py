"""Opens the log of this process, which takes what is logged, printed or raised.

Components log with ``self.logger``, which bears their name; output of their code becomes records
of the loggers ``stdout`` and ``stderr``. Text that programs and C code write to the descriptors
themselves passes by here.
"""

from __future__ import annotations

import contextlib
import faulthandler
import io
import logging
import os
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from types import TracebackType
from typing import Any

from rtkit.component.current import current
from rtkit.errors import Malformed, RtkitError
from rtkit.link import places
from rtkit.link.threads import OwnThread
from rtkit.logs.logfile import LogFile, Lossy, Terminal
from rtkit.logs.outputs import forget_old, redirect
from rtkit.logs.records import LEVELS, JsonLines, Readable
from rtkit.version import __version__

LEVEL_KEY = "logger.log_level"
"""Property of a manager, and option of a create string: the least level that is logged."""

_MAX_LINE = 8192
_RECENT = 32
"""How many pieces of text are known that a thread printed last."""
_log = logging.getLogger("rtkit")
_components: set[str] = set()


class Log:
    """The log of one process.

    Args:
        process: Name of the manager or slave.
        path: The file of its own.
        terminal: Descriptor to which readable lines go too; it is taken over. None for nowhere.

    Attributes:
        folder: Where the file lies.
    """

    def __init__(self, process: str, path: str, terminal: int | None = None) -> None:
        self.folder = os.path.dirname(path)
        self._file = LogFile(path)
        self._formatters: list[JsonLines | Readable] = [JsonLines(process, _components)]
        self._handlers = [Lossy(self._file, self._formatters[0])]
        if terminal is not None:
            self._formatters.append(Readable(process))
            self._handlers.append(Lossy(Terminal(terminal), self._formatters[1]))
        self._before: list[Any] = []
        # Made now: a slave would touch 240 kB of its zygote's memory to make it (decision 49).
        text = f"begins, rtkit {__version__}"
        self._first = logging.LogRecord("rtkit", logging.INFO, __file__, 0, text, (), None)

    def open(self) -> None:
        """Take in everything that is logged, printed or raised from now on."""
        root = logging.getLogger()
        self._before = [
            root.level,
            sys.stdout,
            sys.stderr,
            sys.excepthook,
            sys.unraisablehook,
            threading.excepthook,
            threading.Thread.start,
        ]
        if root.level != logging.INFO:  # a change lets every logger forget what it worked out
            root.setLevel(logging.INFO)
        for handler in self._handlers:
            root.addHandler(handler)
        logging.captureWarnings(True)
        sys.stdout = Printed("stdout", logging.INFO, 1, self._handlers)
        sys.stderr = Printed("stderr", logging.WARNING, 2, self._handlers)
        sys.excepthook = _main_failed
        sys.unraisablehook = _unraisable
        threading.excepthook = _thread_failed
        threading.Thread.start = _start_labelled  # type: ignore[assignment, method-assign]

    def begin(self) -> None:
        """Log that this process begins."""
        record = self._first
        record.created, record.process = time.time(), os.getpid()
        record.msecs = record.created % 1.0 * 1000.0
        for handler in self._handlers:
            if record.levelno >= handler.level:
                handler.handle(record)

    def hand_over(self, process: str, path: str) -> None:
        """Go on as the log of another process, which was forked: under its name, in its file."""
        self._file.move(path)
        for formatter in self._formatters:
            formatter.process = process

    @contextlib.contextmanager
    def lent(self, process: str, path: str) -> Iterator[None]:
        """Be the log of another process for a while, of which nothing is shown."""
        before = self._formatters[0].process, self._file.path
        self.hand_over(process, path)
        for handler in self._handlers[1:]:
            handler.setLevel(logging.CRITICAL + 1)
        try:
            yield
        finally:
            self.hand_over(*before)
            for handler in self._handlers[1:]:
                handler.setLevel(logging.NOTSET)

    def close(self) -> None:
        """Write what is left, and have everything as it was before; once only."""
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        root = logging.getLogger()
        level, sys.stdout, sys.stderr, *hooks = self._before
        sys.excepthook, sys.unraisablehook, threading.excepthook, start = hooks
        threading.Thread.start = start  # type: ignore[method-assign]
        logging.captureWarnings(False)
        root.setLevel(level)
        for handler in self._handlers:
            root.removeHandler(handler)
            handler.close()

    def __enter__(self) -> Log:
        return self

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if error is None:
            _log.info("ends")
        else:
            is_plain = isinstance(error, RtkitError)
            _log.critical("ends: %s", error, exc_info=None if is_plain else error)
        self.close()


def open_log(manager: str, *, is_shown: bool = False) -> Log:
    """Open the log of a manager, and lead what it writes past it to a file beside it.

    One that is shown keeps its descriptors, and sends what is logged to stderr too.
    """
    if not is_shown:
        redirect(places.output_file(manager), manager)
    forget_old(manager)
    log = share_log(manager, manager, is_shown=is_shown)
    log.begin()
    return log


def share_log(manager: str, process: str, *, is_shown: bool) -> Log:
    """Open the log of a manager for this process, which writes to it under a name of its own."""
    faulthandler.enable(2)
    log = Log(process, places.log_file(manager), os.dup(2) if is_shown else None)
    log.open()
    return log


def hand_over(log: Log, manager: str, slave: str) -> Log:
    """Have a log that was shared become that of a slave, in the process that was forked.

    What the slave writes past it goes to a file beside it, also where logs are shown.
    """
    redirect(places.output_file(manager, slave, log.folder), slave)
    log.hand_over(slave, places.log_file(manager, slave, log.folder))
    log.begin()
    return log


class Printed(io.TextIOBase):
    """Makes a record of each line that is printed; threads do not mix.

    The records go to the handlers of the log and to no other, so that a handler that prints cannot
    call itself.

    Attributes:
        encoding: Of text as bytes.
        errors: Handler of text that has no bytes.
        name: Of the stream.
        buffer: The descriptor itself, for who writes bytes.
        tap: Takes what is printed, too, by the thread that prints; None for nobody.
    """

    encoding, errors = "utf-8", "backslashreplace"
    tap: Callable[[str], object] | None = None

    def __init__(self, name: str, level: int, descriptor: int, handlers: list[Lossy]) -> None:
        self.name = f"<{name}>"
        self._name = name
        self._level = level
        self.buffer = io.FileIO(descriptor, "w", closefd=False)
        self._handlers = handlers
        self._begun = threading.local()

    def fileno(self) -> int:
        """Return the descriptor, for programs that are started with it."""
        return self.buffer.fileno()

    def writable(self) -> bool:
        """Return whether it can be written to: always true."""
        return True

    def write(self, text: str) -> int:
        """Take text; whole lines become records."""
        recent: deque[str] | None = getattr(self._begun, "recent", None)
        if recent is None:
            recent = self._begun.recent = deque(maxlen=_RECENT)
        recent.append(text)
        if self.tap is not None:
            self.tap(text)
        *lines, rest = (getattr(self._begun, "text", "") + text).split("\n")
        for line in lines:
            self._log(line)
        while len(rest) > _MAX_LINE:
            self._log(rest[:_MAX_LINE])
            rest = rest[_MAX_LINE:]
        self._begun.text = rest
        return len(text)

    def recent(self) -> str:
        """Return what this thread printed last: a question, before its answer is waited for."""
        return "".join(getattr(self._begun, "recent", ()))

    def flush(self) -> None:
        """Make a record of a line that has been begun."""
        rest = getattr(self._begun, "text", "")
        if rest:
            self._begun.text = ""
            self._log(rest)

    def _log(self, line: str) -> None:
        if line.strip() and logging.getLogger().isEnabledFor(self._level):
            record = logging.LogRecord(self._name, self._level, "", 0, line.rstrip(), (), None)
            for handler in self._handlers:
                handler.handle(record)


def level_of(word: str) -> int:
    """Return the number of a level's word.

    Raises:
        Malformed: There is no such level.
    """
    number = LEVELS.get(word.strip().upper())
    if number is None:
        raise Malformed(f"unknown log level {word!r}; known: {', '.join(LEVELS)}")
    return number


def begin_component(
    instance: str, options: Mapping[str, str], inherited: Mapping[str, str]
) -> None:
    """Register the logger of an instance as one, with the level of its options.

    A level that is but inherited from the manager is that of the process: it may change.

    Raises:
        Malformed: There is no such level.
    """
    word = options.get(LEVEL_KEY, "")
    if word == inherited.get(LEVEL_KEY):
        word = ""
    level = level_of(word) if word else logging.NOTSET
    if word or instance in logging.root.manager.loggerDict:  # else it is made when it is used
        logger = logging.getLogger(instance)
        if logger.level != level:  # a change lets every logger forget what it worked out
            logger.setLevel(level)
    _components.add(instance)


_start = threading.Thread.start


def _start_labelled(thread: threading.Thread) -> None:
    """Start a thread; its output and errors bear the name of the component that starts it."""
    instance = current.get()
    if instance and not isinstance(thread, OwnThread):
        run = thread.run

        def run_labelled() -> None:
            del thread.run
            current.set(instance)  # for good: an exception is reported when `run` is left
            run()

        thread.run = run_labelled  # type: ignore[method-assign]
    _start(thread)


def _main_failed(
    kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    _log.critical("the process failed", exc_info=(kind, error, trace))


def _thread_failed(failure: threading.ExceptHookArgs) -> None:
    if failure.exc_type is SystemExit or failure.exc_value is None:
        return
    name = failure.thread.name if failure.thread is not None else "?"
    _log.error(
        "thread %s failed",
        name,
        exc_info=(failure.exc_type, failure.exc_value, failure.exc_traceback),
    )


def _unraisable(failure: sys.UnraisableHookArgs) -> None:
    what = failure.err_msg or "an exception could not be raised"
    error = failure.exc_value
    _log.error(
        "%s: %s",
        what,
        type(failure.object).__name__,
        exc_info=None if error is None else (type(error), error, failure.exc_traceback),
    )
