"""Data side of the tree of scripts: values of ports, calls, configuration sets, what happens."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rtkit.api import configuring
from rtkit.api.ports import NotReached, PortReader
from rtkit.api.session import Notify, ScriptSession, Stream, begun
from rtkit.tree import client
from rtkit.tree.api import Value, as_text, value_text

if TYPE_CHECKING:
    from rtkit.api.client import Client
    from rtkit.api.events import SystemEvent
    from rtkit.api.ports import PortValue
    from rtkit.api.properties import Properties
    from rtkit.link.transport import Link
    from rtkit.logs.logbook import LogEntry
    from rtkit.rtc.names import Path
    from rtkit.tree.subscription import ManagerSubscription


def silent(_text: str) -> None:
    """Receive what nobody wants to know."""


class DataTree(client.Tree):
    """Methods of `rtkit.api.tree.Tree` that observe, exchange data, and configure.

    Attributes:
        notify: Receives progress and warnings, one line each: what commands tell on stderr.
    """

    def __init__(
        self,
        link: Link,
        host: str,
        manager: str,
        timeout_s: float = client.DEFAULT_TIMEOUT_S,
        notify: Notify = silent,
    ) -> None:
        """Use a link to a manager; `rtkit.connect` makes it."""
        super().__init__(link, host, manager, timeout_s)
        self.notify = notify
        self._client: Client | None = None
        self._led: dict[str, client.Tree] = {}

    def _manager_at(self, path: Path) -> str:
        """Return the other manager that a path leads to, as commands read it; empty for this one.

        It is named as `rtkit.connect` takes it.
        """
        from rtkit.tree.place import manager_of

        manager = manager_of(path)
        return "" if manager.partition("/")[0] in (self.manager, self.place) else manager

    def led_to(self, path: Path | str) -> client.Tree:
        """Return the connection to the manager that a path leads to; it is closed with this one.

        Example::

            tree.led_to("/robot1").create("ConsoleIn")

        Raises:
            Unreachable: That manager does not run, or does not answer.
        """
        from rtkit.rtc.names import parse_path

        manager = self._manager_at(parse_path(path) if isinstance(path, str) else path)
        if not manager:
            return self
        if manager not in self._led:
            from rtkit.tree.connect import connect

            self._led[manager] = connect(manager, self.timeout_s, type(self))
        return self._led[manager]

    def ls(self, path: str = "/localhost") -> list[str]:
        """Return the names of what is at a place, as ``rtls`` lists it.

        Raises:
            NotFound: Nothing is there.
        """
        from rtkit.rtc.names import LOCAL, parse_path
        from rtkit.tree.place import root_for
        from rtkit.tree.resolve import entry
        from rtkit.tree.view import build

        where = parse_path(as_text(path, "a path"))
        tree = self.led_to(where)
        if tree.place == LOCAL or tree is not self:
            root, host = root_for(lambda: tree, where, is_deep=False)
        else:
            listing = self.listing()
            root, host = build(listing), listing.host
        node = entry(root, where, host)
        return [child.name for child in node.entries()] if node.is_directory else [node.name]

    # Waiting

    def wait(self, *paths: str, state: str = "", timeout_s: float = 30.0) -> None:
        """Wait until components are in a state, or ports have carried data.

        Example::

            tree.wait("/localhost/A.rtc", "/localhost/B.rtc", state="active")
            tree.wait("/localhost/A.rtc:out", timeout_s=5.0)

        Args:
            paths: Components, or ports.
            state: ``exists``, ``created``, ``inactive``, ``active``, ``error``, ``gone``, for ports
                ``data``; by default ``exists`` or ``data``.
            timeout_s: How long to wait [s].

        Raises:
            NotReached: It is not so in time; a TimeoutError, too, that tells the reasons.
        """
        from rtkit.api import waiting

        until = time.monotonic() + timeout_s
        word = waiting.check_word(state)
        with ScriptSession(self, self.notify) as session:
            goals = [waiting.goal_of(session.path(path), word) for path in paths]
            problems = waiting.reach(session, goals, until)
        if problems:
            texts = (f"{goal.path.typed} {why}" for goal, why in problems)
            raise NotReached(f"{'; '.join(texts)} after {timeout_s:g} s")

    # Data

    def read(self, port: str, *, timeout_s: float | None = None) -> Any:
        """Return the next value that comes out of a port.

        Args:
            port: Path of an out port, ``/localhost/Robot0.rtc:pose``, or pattern, ``Robot*:pose``.
            timeout_s: How long to wait [s]; by default the time-out of the connection.

        Raises:
            NotReached: None came in time.
        """
        bound_s = self.timeout_s if timeout_s is None else timeout_s
        with PortReader(self, [port]) as reader:
            return reader.read(timeout_s=bound_s)

    def values(
        self,
        *ports: str,
        number: int | None = None,
        timeout_s: float | None = None,
        lossless: bool = False,
    ) -> Stream[PortValue]:
        """Yield values of out ports as they come, each with its port and time.

        A component of its own is connected as long as the loop runs.

        Args:
            ports: Paths of out ports, or patterns of those that are there: ``Robot*:pose``.
            number: How many; None for no bound.
            timeout_s: For how long [s]; None for no bound.
            lossless: Lose no value; the component that writes waits instead.

        Raises:
            Refused: No connection is left.
        """
        from rtkit.api.ports import values

        until = None if timeout_s is None else time.monotonic() + timeout_s
        return begun(values(self, ports, number, until, lossless=lossless))

    def write(self, port: str, *values: Any, rate: float = 0.0) -> int:
        """Write values to an in port; return how many, once all have arrived.

        Example::

            tree.write("/localhost/Motor0.rtc:speed", 42)
            tree.write("/localhost/Motor0.rtc:velocity", {"vx": 0.5}, {"vx": 0.0}, rate=10.0)

        Args:
            port: Path of the port, or pattern: each gets every value.
            values: Objects of the data type, or plain data as ``rtinject`` takes them.
            rate: Values per second [Hz]; 0 for as fast as they are taken.

        Raises:
            Malformed: One is no value of the port's type.
        """
        from rtkit.api.ports import write

        return write(self, port, values, rate)

    def call(self, operation: str, *arguments: Any, timeout_s: float | None = None) -> Any:
        """Call an operation of a service port and return its result.

        Example::

            tree.call("/localhost/Hand0.rtc:gripper.close", 3.5)

        Args:
            operation: ``COMPONENT:PORT.OPERATION``, or ``COMPONENT:PORT.INSTANCE.OPERATION``.
            arguments: Of the types of the interface, or plain data for them.
            timeout_s: Bound on the answer [s]; by default that of the connection.

        Returns:
            The result; with out parameters a dict, in which the result itself has no name.

        Raises:
            NotFound: There is no such operation.
            Malformed: An argument is of another type.
            Refused: It raised an exception. One that the interface declares has the name of its
                class, and what it carries: ``error.members["seconds"]``.
            Unreachable: There was no answer in time.
        """
        from rtkit.api.ports import call

        return call(self, operation, arguments, self.timeout_s if timeout_s is None else timeout_s)

    def answer(self, path: str, *lines: str, timeout_s: float = 2.0) -> None:
        """Type lines at the terminal of a component that asks, and wait until it has read them.

        Example::

            tree.answer("/localhost/ConsoleIn0.rtc", "5")

        Args:
            path: The component.
            lines: What is typed, without the ends of lines.
            timeout_s: How long the component may take to read them [s].

        Raises:
            Malformed: A line is longer than a terminal takes.
            Refused: It has not read all of them in time; what is left stays there to be read.
        """
        from rtkit.api.attaching import TerminalClient

        facts = self.component(path)
        client = TerminalClient(self.led_to(path), facts.instance)
        client.send((as_text(line, "a line").encode() for line in lines), timeout_s)

    # Configuration sets

    def configure(self, path: str, set_id: str = "", **values: Value) -> None:
        """Change parameters of a configuration set (by default the active one), all or none.

        A component sees a change of its active set within one period.

        Example::

            tree.configure("/localhost/Robot0.rtc", speed=0.5, name="left")

        Raises:
            NotFound: No such component, set or parameter.
            Malformed: A value does not fit its parameter.
        """
        facts = self.component(path)
        chosen = configuring.known(facts, set_id or facts.active_set)
        configuring.change(ScriptSession(self, self.notify), facts, {chosen: _texts(values)})

    def add_set(self, path: str, set_id: str, /, **values: Value) -> None:
        """Add a configuration set with these parameters; `activate_set` makes it the active one.

        Raises:
            NotFound: No such component or parameter.
            Malformed: A value does not fit its parameter.
            Refused: There is such a set.
        """
        configuring.add(
            ScriptSession(self, self.notify), self.component(path), set_id, _texts(values)
        )

    def copy_set(self, path: str, source: str, set_id: str, /, **values: Value) -> None:
        """Add a configuration set that is like another one, but for these parameters.

        Example::

            tree.copy_set("/localhost/Robot0.rtc", "careful", "gentle", speed=0.1)

        Raises:
            NotFound: No such component, set or parameter.
            Malformed: A value does not fit its parameter.
            Refused: There is such a set.
        """
        facts = self.component(path)
        copied = facts.sets[configuring.known(facts, source)]
        values = {**copied, **values}
        configuring.add(ScriptSession(self, self.notify), facts, set_id, _texts(values))

    def remove_set(self, path: str, set_id: str) -> None:
        """Remove a configuration set that was added.

        Raises:
            NotFound: No such component or set.
            Refused: It is the active one, or was not added.
        """
        configuring.remove(ScriptSession(self, self.notify), self.component(path), set_id)

    def activate_set(self, path: str, set_id: str) -> None:
        """Make a configuration set the active one: ``tree.component(path).sets`` has them all.

        Raises:
            NotFound: No such component or set.
        """
        configuring.activate(ScriptSession(self, self.notify), self.component(path), set_id)

    # Observing

    def live(self) -> ManagerSubscription:
        """Return the facts of the manager as they change: ``with tree.live() as live:``.

        ``live.wait(timeout_s)`` waits for changes, ``live.facts`` is what is known then.

        Raises:
            Unreachable: The manager does not answer.
        """
        from rtkit.tree.subscription import ManagerSubscription

        return ManagerSubscription(self)

    @property
    def properties(self) -> Properties:
        """Live properties of components, managers, this host and served objects."""
        from rtkit.api.client import Client
        from rtkit.api.properties import Properties

        if self._client is None:
            self._client = Client(self.timeout_s)
        return Properties(self, self._client)

    def close(self) -> None:
        """End the connection."""
        for tree in self._led.values():
            tree.close()
        self._led.clear()
        if self._client is not None:
            self._client.close()
        super().close()

    def logs(
        self,
        *paths: str,
        level: str = "NORMAL",
        sources: Sequence[str] = (),
        text: str | None = None,
        since_s: float | None = None,
        last: int | None = None,
        follow: bool = False,
        timeout_s: float | None = None,
    ) -> Stream[LogEntry]:
        """Yield what was logged, in order of time, with `follow` also what is logged from now on.

        Args:
            paths: Components, slaves, managers; none for everything of this manager.
            level: The most talkative level, ``ERROR``, ``WARN``, ``INFO``, ``NORMAL``, ``DEBUG`` …
            sources: Only what these loggers, or those below them, log.
            text: Only what has this in it.
            since_s: Only what was logged in the last seconds [s].
            last: Only so many of the records that are there.
            follow: Go on with what comes.
            timeout_s: How long to follow [s]; None for no end.

        Raises:
            NotFound: Nothing is at a path.
        """
        from rtkit.api import logs
        from rtkit.logs.selection import Selection

        until = None if timeout_s is None else time.monotonic() + timeout_s
        with ScriptSession(self, self.notify) as session:
            named = paths or (f"/localhost/{self.manager}.mgr",)
            subjects = tuple(logs.about(session.tree, session.path(path)) for path in named)
            wanted = Selection(level, tuple(sources), text, since_s, subjects)
            wanted.wanted()  # which tells whether there is such a level
            read = logs.follow(session, session.tree, wanted, last, until, is_over=not follow)
            return begun(read)

    def events(
        self, *paths: str, kinds: Iterable[str] = (), timeout_s: float | None = None
    ) -> Stream[SystemEvent]:
        """Yield what happens to components, processes and systems, as it happens.

        It listens from the call on. A manager that ends is waited for.

        Args:
            paths: Components, directories, managers; none for everything on this host.
            kinds: ``TREE_EVENT``, ``RTC_STATUS`` … (``rtwatch -h``); none for all but heartbeats.
            timeout_s: For how long [s]; None for no end.

        Raises:
            NotFound: Nothing is at a path.
        """
        from rtkit.api.events import watched

        until = None if timeout_s is None else time.monotonic() + timeout_s
        session = ScriptSession(self, self.notify)
        return begun(watched(session, paths or ("/",), kinds, until))


def _texts(values: Mapping[str, Value]) -> dict[str, str]:
    return {name: value_text(value, name) for name, value in values.items()}
