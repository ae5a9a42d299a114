"""Runs a component in the process that calls: a script, a debugger, a profiler or a notebook.

The process attaches to a manager, and its component is in the tree while it stays. The calling
thread drives it, so what looks at that thread sees the component's code.

See decision 57.
"""

from __future__ import annotations

import _thread
import atexit
import logging
import os
import queue
import sys
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from threading import Event, Lock
from types import FunctionType
from typing import TYPE_CHECKING, NamedTuple, NoReturn

from rtkit.closing import Closing
from rtkit.component.base import Component
from rtkit.component.contexts import callbacks
from rtkit.component.describe import CODE
from rtkit.component.factory import free_name
from rtkit.container.attached_process import ENTERING, AttachedProcess, attached_to, leave_if_empty
from rtkit.container.component_factory import odd_options
from rtkit.container.pacer import Driver
from rtkit.errors import Refused, RtkitError
from rtkit.link import places
from rtkit.link.threads import start_thread
from rtkit.modules.neighbours import lies_in, read
from rtkit.rtc.create import FRESH_SLAVE, CreateString
from rtkit.rtc.enums import ReturnCode, Transition

if TYPE_CHECKING:
    from rtkit.tree.client import Tree

Value = str | int | float | bool
Complete = Callable[[str, Mapping[str, str]], Mapping[str, str]]
"""Takes the name of an instance and its options, and returns these with more."""
_log = logging.getLogger("rtkit")
_running: dict[tuple[str, str], RunningComponent] = {}
"""Components of this process, by type and the name that was asked for: a cell that is run again
replaces what it made before."""


class _Wish(NamedTuple):
    """Arguments of `run`, those of the command line included."""

    name: str
    options: Mapping[str, str]
    activates: bool
    manager: str
    starts: bool
    timeout_s: float
    replaces: bool = True
    complete: Complete = lambda _name, options: options


def run(
    component_class: type[Component],
    *,
    name: str = "",
    rate: float | None = None,
    context: str = "",
    parameters: Mapping[str, Value] | None = None,
    options: Mapping[str, str] | None = None,
    activate: bool = False,
    manager: str = "",
    start: bool = False,
    wait: bool | None = None,
    arguments: Sequence[str] | None = None,
    timeout_s: float = 10.0,
) -> RunningComponent:
    """Run a component in this process, in the tree of a manager, until Ctrl-C or its end.

    Args:
        component_class: Its class.
        name: Of the instance; by default the type and the lowest free number.
        rate: Of its execution context [Hz]; by default that of its class.
        context: Type of that context, ``PeriodicExecutionContext`` for example.
        parameters: Values of its default configuration set.
        options: More, as create strings have them.
        activate: Activate it at once.
        manager: Name or address of the manager; by default ``RTKIT_MANAGER``, or ``manager``.
        start: Start that manager if it does not run; it stays when the component leaves.
        wait: Return only when it has left; by default so, unless this thread runs an event loop.
        arguments: Command line, which outranks the others (``--help`` tells its options); by
            default that of the script, if the class is defined in it.
        timeout_s: How long the manager may take to answer [s].

    Returns:
        What runs, or ran; its `close` has it leave.

    Raises:
        Unreachable: No such manager runs.
        Refused: Its name is taken, or it does not initialise.
        Malformed: An option cannot be read.
    """
    given = {**(options or {})}
    if rate is not None:
        given["exec_cxt.periodic.rate"] = repr(float(rate))
    if context:
        given["exec_cxt.periodic.type"] = context
    for key, value in (parameters or {}).items():
        given[f"conf.default.{key}"] = str(value).lower() if isinstance(value, bool) else str(value)
    wish = _Wish(name, given, activate, manager, start, timeout_s)
    is_script = arguments is None and _is_script(component_class)
    arguments = sys.argv[1:] if is_script else arguments or ()
    wish = _read_arguments(component_class, arguments, wish) if arguments else wish
    is_waiting = not _is_in_loop() if wait is None else wait
    with _ending_by_ctrl_c() if is_waiting else nullcontext():
        try:
            running = RunningComponent(component_class, wish, is_driving=is_waiting)
        except RtkitError as error:
            if is_script:
                _give_up(error)
            raise
        if is_waiting:
            running.wait()
    return running


def begin(
    component_class: type[Component],
    name: str,
    options: Mapping[str, str],
    complete: Complete,
    timeout_s: float,
) -> RunningComponent:
    """Have one more component of a class live in this process, driven by threads of its own.

    It enters the usual manager, which runs.

    Args:
        component_class: Its class.
        name: Of the instance; empty for the type and the lowest free number.
        options: As create strings have them.
        complete: Adds to them when the name is known.
        timeout_s: How long the manager may take to answer [s].

    Raises:
        Unreachable: The manager does not answer.
        Refused: Its name is taken, or it does not initialise.
    """
    wish = _Wish(name, options, False, "", False, timeout_s, replaces=False, complete=complete)
    return RunningComponent(component_class, wish, is_driving=False)


@contextmanager
def _ending_by_ctrl_c() -> Iterator[None]:
    """Let Ctrl-C end the component also after `breakpoint` and `c`: the debugger would stop again.

    Another debugger than Python's own stays as it was chosen.
    """
    before = sys.breakpointhook
    if before is sys.__breakpointhook__ and not os.environ.get("PYTHONBREAKPOINT"):
        sys.breakpointhook = _stop
    try:
        yield
    finally:
        sys.breakpointhook = before


def _stop(*, header: str | None = None) -> None:
    from inspect import currentframe
    from pdb import Pdb

    debugger, here = Pdb(nosigint=True), currentframe()
    if header is not None:
        debugger.message(header)
    debugger.set_trace(here and here.f_back)


class RunningComponent(Closing):
    """A component that runs in this process; leaves at the end of its block, or of the process.

    Attributes:
        component: The component.
        path: Its path in the tree.
    """

    def __init__(self, component_class: type[Component], wish: _Wish, *, is_driving: bool) -> None:
        from rtkit.tree.connect import connect

        self._calling = _CallingThread(is_lent=is_driving)
        self._is_activated = wish.activates
        own = wish.name if wish.replaces else f"{id(self)}"
        self._key = (component_class.type_profile().type_name, own)
        if is_driving:
            _show_logs()
        if wish.starts:
            from rtkit.manager import launch
            from rtkit.settings.configuration import CommandLineSettings

            name = wish.manager or places.usual_manager()
            launch.ensure(name, CommandLineSettings(), wish.timeout_s)
        if self._key in _running:
            _running[self._key].close()
        with connect(wish.manager, wish.timeout_s) as tree:
            self._attached, self.component = self._enter(tree, component_class, wish)
            atexit.register(self.close)
            _running[self._key] = self
            rows = tree.listing().rows
        names = [each.names for each in rows if each.instance == self.component.instance]
        self.path = f"/{names[0][0]}" if names and names[0] else self.component.instance
        if wish.activates:
            self._activate(0.0 if is_driving else wish.timeout_s)

    def __repr__(self) -> str:
        return f"<{self.path}: {'runs' if self.is_running else 'has left'}>"

    @property
    def is_running(self) -> bool:
        """Return whether it lives: it has not left, and was not ended from outside."""
        return self.component.instance in self._attached.holds

    def wait(self) -> None:
        """Drive it on this thread until Ctrl-C, or until it is ended from outside; then leave."""
        wait_for([self])

    @property
    def hint(self) -> str:
        """Advice on how it is activated; empty if it is."""
        return "" if self._is_activated else f"rtact {self.path} activates it, "

    def serve(self) -> None:
        """Drive it on this thread, if that is lent to it, until it is ended from outside."""
        self._calling.serve()
        _log.info("%s was ended", self.path)

    def close(self) -> None:
        """End the component and leave the manager; without effect when that was done already."""
        atexit.unregister(self.close)
        if _running.get(self._key) is self:
            del _running[self._key]
        self._calling.end()
        self._attached.end([self.component.instance])
        if self.look in self._attached.listeners:
            self._attached.listeners.remove(self.look)
        leave_if_empty(self._attached)

    def _enter(
        self, tree: Tree, component_class: type[Component], wish: _Wish
    ) -> tuple[AttachedProcess, Component]:
        """Enter under the name that was asked for, else under the first free one."""
        taken = {row.instance for row in tree.listing().rows if not row.zombie}
        if wish.name in taken:
            raise Refused(f"{wish.name} exists already (rtexit ends it)")
        kind, code = self._key[0], _code_of(component_class)
        setattr(component_class, CODE, code)
        while True:
            instance = wish.name or free_name(kind, taken)
            options = wish.complete(instance, wish.options)
            component = component_class(instance, options)
            component.initialize()
            for text in odd_options(component, options):
                component.report(text)
            origin = {"create": _create(kind, instance, options), "module": _module(code)}
            try:
                with ENTERING:
                    attached = attached_to(
                        tree.manager, tree.host, kind, AttachedProcess.be_watched
                    )
                    attached.enter([component], wish.timeout_s, origin, self._calling.start)
                    attached.listeners.append(self.look)
            except RtkitError as error:
                attached.end([instance])
                leave_if_empty(attached)
                if wish.name or not isinstance(error, Refused):
                    raise
                taken.add(instance)  # another process took it in the meantime
                continue
            return attached, component

    def _activate(self, timeout_s: float) -> None:
        done = Event()

        def note(code: ReturnCode, why: str) -> None:
            if code is not ReturnCode.OK:
                _log.warning("%s is not active: %s", self.path, why)
            done.set()

        for context in self.component.contexts.values():
            context.request(self.component, Transition.ACTIVATE, note)
            done.wait(timeout_s)

    def look(self) -> None:
        """Notice whether it was ended from outside."""
        if not self.is_running:
            self._calling.end()


def wait_for(components: Sequence[RunningComponent]) -> None:
    """Return when all were ended from outside, or at Ctrl-C; then they leave."""
    import bdb

    callbacks.escaping = (KeyboardInterrupt, bdb.BdbQuit)
    for each in components:
        _log.info("%s is in the tree; %sCtrl-C ends it", each.path, each.hint)
    try:
        for each in components:
            each.serve()
    except callbacks.escaping:
        for each in components:
            _log.info("%s leaves", each.path)
    finally:
        callbacks.escaping = ()
        for each in components:
            each.close()


class _Turn:
    """Work that the calling thread does in place of a thread of its own."""

    def __init__(self, work: Callable[[], object]) -> None:
        self._work = work
        self._is_done = Event()

    def run(self) -> None:
        try:
            self._work()
        finally:
            self._is_done.set()

    def join(self, timeout: float | None = None) -> None:
        self._is_done.wait(timeout)

    def is_alive(self) -> bool:
        return not self._is_done.is_set()


class _CallingThread:
    """Does the work of one context at a time on the thread that calls `serve`.

    That of the others, and all of it where that thread is not lent, is done on their own threads.
    """

    def __init__(self, *, is_lent: bool) -> None:
        self._lock = Lock()
        self._is_free = is_lent
        self._is_over = False
        self._turns: queue.SimpleQueue[_Turn | None] = queue.SimpleQueue()

    def start(self, work: Callable[[], object], name: str) -> Driver:
        with self._lock:
            if not self._is_free:
                return start_thread(lambda: self._aside(work), name)
            self._is_free = False
        turn = _Turn(work)
        self._turns.put(turn)
        return turn

    def serve(self) -> None:
        """Do such work until `end`."""
        while (turn := self._turns.get()) is not None:
            turn.run()
            with self._lock:
                self._is_free = not self._is_over

    def end(self) -> None:
        """Have `serve` return; work that it has not begun goes to another thread."""
        with self._lock:
            self._is_free, self._is_over = False, True
        while not self._turns.empty():
            turn = self._turns.get()
            if turn is not None:
                start_thread(turn.run, "deferred")
        self._turns.put(None)

    @staticmethod
    def _aside(work: Callable[[], object]) -> None:
        try:
            work()
        except callbacks.escaping:
            _thread.interrupt_main()


def _create(kind: str, instance: str, options: Mapping[str, str]) -> str:
    """Return the create string of what a manager would make in place of it."""
    own = {"instance_name": instance, "manager_name": FRESH_SLAVE}
    return str(CreateString(kind, options={**options, **own}))


def _file_of(component_class: type[Component]) -> str:
    """Return the file that defines a class; empty for a notebook's cell.

    Its functions know it; its module does not where a profiler or debugger runs it.
    """
    functions = (each for each in vars(component_class).values() if isinstance(each, FunctionType))
    module = sys.modules.get(component_class.__module__)
    named = [each.__code__.co_filename for each in functions]
    file = next(iter(named), None) or getattr(module, "__file__", None) or ""
    return os.path.realpath(file) if os.path.isfile(file) else ""


def _code_of(component_class: type[Component]) -> str:
    """Return the CRC-32 of the file of a class, and of files beside it that were imported."""
    file = _file_of(component_class)
    if not file:
        return ""
    folder = os.path.dirname(file)
    beside = [m.__file__ for n, m in tuple(sys.modules.items()) if lies_in(folder, n, m)]
    files = dict.fromkeys([file, *(each for each in beside if each)])
    return "\n".join(f"{zlib.crc32(text):08x} {each}" for each in files if (text := read(each)))


def _module(code: str) -> str:
    """Return the module that a manager would load; empty where it could not."""
    file = code.partition("\n")[0].partition(" ")[2]
    init = f"{os.path.basename(file).partition('.')[0]}Init"
    return file if file and f"def {init}(".encode() in (read(file) or b"") else ""


def _is_script(component_class: type[Component]) -> bool:
    is_main = component_class.__module__ == "__main__" and bool(_file_of(component_class))
    return is_main and not hasattr(sys, "ps1")


def _is_in_loop() -> bool:
    asyncio = sys.modules.get("asyncio")  # without that import no loop runs
    if asyncio is None:
        return False
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True


def _show_logs() -> None:
    """Show in the terminal what components log, unless the program has logs of its own."""
    from rtkit.logs.records import Readable

    root = logging.getLogger()
    if not root.handlers:
        handler = logging.StreamHandler()
        handler.setFormatter(Readable())
        root.addHandler(handler)
        root.setLevel(logging.INFO)


def _read_arguments(
    component_class: type[Component], arguments: Sequence[str], wish: _Wish
) -> _Wish:
    import argparse

    parser = argparse.ArgumentParser(description=f"Run {component_class.__name__} by hand.")
    add = parser.add_argument
    add("--name", default=wish.name, help="name of the instance")
    add("--rate", metavar="HZ", help="rate of its execution context")
    add("--context", metavar="TYPE", help="type of its execution context")
    for option, metavar, text in (
        ("--set", "PARAMETER=VALUE", "value of a parameter"),
        ("-o", "KEY=VALUE", "option, as create strings have it"),
    ):
        add(option, metavar=metavar, help=text, action="append", default=[], type=_pair)
    add("--activate", action="store_true", default=wish.activates, help="activate it at once")
    add("--manager", default=wish.manager, help="name or address of the manager")
    text = "start the manager if it does not run"
    add("--start", action="store_true", default=wish.starts, help=text)
    found = parser.parse_args(arguments)
    options = {**wish.options, **dict(found.o)}
    options.update((f"conf.default.{key}", value) for key, value in found.set)
    keys = {"exec_cxt.periodic.rate": found.rate, "exec_cxt.periodic.type": found.context}
    options.update((key, value) for key, value in keys.items() if value)
    return wish._replace(
        name=found.name,
        options=options,
        activates=found.activate,
        manager=found.manager,
        starts=found.start,
    )


def _pair(text: str) -> tuple[str, str]:
    from argparse import ArgumentTypeError

    key, equals, value = text.partition("=")
    if not (key and equals):
        raise ArgumentTypeError(f"not KEY=VALUE: {text!r}")
    return key, value


def _give_up(error: RtkitError) -> NoReturn:
    """End the script with a line about an error, and the traceback of user code that failed."""
    cause = error.__cause__
    if cause is not None and not isinstance(cause, (RtkitError, OSError)):
        import traceback

        traceback.print_exception(cause)
    print(f"{os.path.basename(sys.argv[0])}: {error}", file=sys.stderr)
    sys.exit(1)
