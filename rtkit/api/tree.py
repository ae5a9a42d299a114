"""Tree of scripts: everything that commands do to a running system, as methods."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rtkit.api.ports import NotReached, PortReader
from rtkit.api.profiles import Source, SystemProfile, load
from rtkit.api.script import Notify, ScriptSession, Stream, begun
from rtkit.tree import client

if TYPE_CHECKING:
    from rtkit.api.checking import SystemReport
    from rtkit.api.events import SystemEvent
    from rtkit.api.live import Properties
    from rtkit.api.plan import SystemPlan
    from rtkit.api.planning import GoalOptions
    from rtkit.api.ports import PortValue
    from rtkit.link.transport import Link
    from rtkit.tree.logbook import LogEntry

NO_MAP: Mapping[str, Any] = {}


def _silent(_text: str) -> None:
    pass


class Tree(client.Tree):
    """A connection to one manager, through which a system is looked at and changed.

    `rtkit.connect` makes it. A profile is a path or what `rtkit.load` returns; where it has
    components in other managers of this host, these are connected to, and started when needed.
    Every method is bounded by the time-out of the connection, or by one of its own [s]. Errors are
    those of `rtkit.errors`.

    Systems: `plan apply_profile bring_up start stop check save teardown`. Waiting: `wait`. Data:
    `read values write call`. Observing: `logs events properties`. Components: `ls component create
    delete activate deactivate reset connect disconnect configure load`.

    Example::

        with rtkit.connect() as tree:
            tree.apply_profile("robot.xml", rollback=True)
            tree.wait("/localhost/Camera0.rtc:image", timeout_s=5.0)
            print(tree.read("/localhost/Camera0.rtc:image"))
            for deviation in tree.check("robot.xml"):
                print(deviation.text)
            tree.teardown("robot.xml", end=True)

    Attributes:
        host: Host name of the manager.
        manager: Its name.
        timeout_s: Bound on every call [s].
        notify: Receives progress and warnings, one line each: what commands tell on stderr.
    """

    def __init__(
        self,
        link: Link,
        host: str,
        manager: str,
        timeout_s: float = client.DEFAULT_TIMEOUT_S,
        notify: Notify = _silent,
    ) -> None:
        """Use a link to a manager; `rtkit.connect` makes it."""
        super().__init__(link, host, manager, timeout_s)
        self.notify = notify

    def __dir__(self) -> list[str]:
        return _FIRST.split()  # what authors use; the others speak the manager's own language

    # Systems

    def plan(
        self,
        profile: Source,
        *,
        state: str = "Active",
        prune: bool = False,
        replace: bool = False,
        costs: Mapping[str, float] = NO_MAP,
        stand_in: bool = False,
        hosts: Mapping[str, str] = NO_MAP,
        strict: bool = False,
    ) -> SystemPlan:
        """Return the cheapest plan from what lives to a profile; nothing is changed.

        Args:
            profile: Where it is to lead.
            state: State that every component is to be in: ``Active``, ``Inactive`` or ``Any``.
            prune: End the other components, and remove the other connections of its own.
            replace: End and replace what cannot be changed in place.
            costs: What kinds of steps cost, or interruptions of a component, by name.
            stand_in: Generate what is missing, without its modules.
            hosts: Hosts of the profile that stand for others: ``{"10.0.0.7": "localhost"}``.
            strict: Take warnings for errors.

        Raises:
            Impossible: There is no plan; names the conditions that cannot hold together.
            InvalidDocument: The profile makes no sense; names file and line.
        """
        from rtkit.api import planning
        from rtkit.api.plan import SystemPlan

        aim = _aim(state, costs, prune=prune, replace=replace, stand_in=stand_in)
        document = load(profile, strict=strict)
        with self._session("plan", document, strict=strict) as session:
            prepared = planning.prepare(session, document, _mapped(hosts), aim, is_dry=True)
        return SystemPlan(self, self.notify, document, prepared)

    def apply_profile(
        self,
        profile: Source,
        *,
        state: str = "Active",
        prune: bool = False,
        replace: bool = False,
        costs: Mapping[str, float] = NO_MAP,
        stand_in: bool = False,
        hosts: Mapping[str, str] = NO_MAP,
        strict: bool = False,
        rollback: bool = False,
        parallel: int = 0,
        wait_s: float = 0.0,
    ) -> SystemPlan:
        """Make the live system what a profile says, by the cheapest plan, and return that plan.

        What holds already is not touched. Options are those of `plan`, and:

        Args:
            profile: The profile.
            state: See `plan`.
            prune: See `plan`.
            replace: See `plan`.
            costs: See `plan`.
            stand_in: See `plan`.
            hosts: See `plan`.
            strict: See `plan`.
            rollback: When a step fails, go back to what was before.
            parallel: Most steps under way at once; 0 for no bound.
            wait_s: How long to wait for another plan at work at the manager [s].

        Raises:
            Impossible: There is no plan.
            Refused: A step failed, or somebody else is at work; tells what is left.
        """
        from rtkit.api import planning
        from rtkit.api.plan import SystemPlan, run
        from rtkit.tree.plan_locks import PlanLocks

        aim = _aim(state, costs, prune=prune, replace=replace, stand_in=stand_in)
        document, mapped = load(profile, strict=strict), _mapped(hosts)
        with (
            self._session("apply", document, strict=strict) as session,
            PlanLocks(session.name, wait_s, self.notify) as lock,
        ):
            prepared = planning.prepare(
                session, document, mapped, aim, is_dry=False, parallel=parallel, lock=lock
            )
            run(session, prepared, rollback=rollback, exact=False)
        return SystemPlan(self, self.notify, document, prepared)

    def bring_up(
        self,
        profile: Source,
        *,
        create: bool = True,
        stand_in: bool = False,
        hosts: Mapping[str, str] = NO_MAP,
        wait_s: float = 0.0,
    ) -> None:
        """Create, connect and configure what is missing of a profile; activate nothing.

        What is there is left as it is. If something required fails, what was made is removed.

        Args:
            profile: The profile.
            create: Whether missing components are created, or an error.
            stand_in: See `plan`.
            hosts: See `plan`.
            wait_s: See `apply_profile`.

        Raises:
            Refused: Something required failed.
        """
        from rtkit.api.bring_up import bring_up
        from rtkit.tree.plan_locks import PlanLocks

        document = load(profile)
        with (
            self._session("bring up", document) as session,
            PlanLocks(session.name, wait_s, self.notify) as lock,
        ):
            mapped = _mapped(hosts)
            bring_up(session, document, mapped, may_create=create, stand_in=stand_in, lock=lock)

    def start(
        self,
        profile: Source,
        *,
        wait: bool = True,
        timeout_s: float | None = None,
        hosts: Mapping[str, str] = NO_MAP,
    ) -> None:
        """Activate every component of a profile, in its order.

        Args:
            profile: The profile.
            wait: Whether each is waited for until it is active.
            timeout_s: Bound on a profile with conditions as a whole [s]; None for none.
            hosts: See `plan`.

        Raises:
            Refused: A required component is missing, or did not become active.
        """
        from rtkit.api import following, starting

        document, mapped = load(profile), _mapped(hosts)
        plan_for = starting.start_plan_of(document, wait=wait)
        with self._session("start", document) as session:
            is_followed = following.is_wanted(session, document)
            inputs = starting.prepare(session, document, plan_for, mapped)
            starting.carry_out(session, inputs, timeout_s)
            if is_followed:
                following.begin_as_stated(session, document, mapped)

    def stop(
        self,
        profile: Source,
        *,
        wait: bool = True,
        timeout_s: float | None = None,
        hosts: Mapping[str, str] = NO_MAP,
    ) -> None:
        """Deactivate every component of a profile, in reverse order or that of the profile.

        What is missing or refuses goes to `notify`; the others are stopped all the same. The
        arguments are those of `start`.

        Raises:
            InvalidDocument: The order that the profile gives makes no sense.
        """
        from rtkit.api import starting

        document = load(profile)
        with self._session("stop", document) as session:
            plan_for = starting.stop_plan_of(session, document, wait=wait)
            mapped = _mapped(hosts)
            inputs = starting.prepare(session, document, plan_for, mapped, may_lack=True)
            starting.carry_out(session, inputs, timeout_s)

    def check(
        self,
        profile: Source,
        *,
        state: str = "Active",
        hosts: Mapping[str, str] = NO_MAP,
        strict: bool = False,
    ) -> SystemReport:
        """Compare what lives with a profile; the report is true when nothing required deviates.

        Example::

            report = tree.check("robot.xml")
            assert report, report

        Args:
            profile: The profile.
            state: State that every component is to be in; ``Unknown`` for none at all.
            hosts: See `plan`.
            strict: Take warnings about the profile for errors.

        Raises:
            InvalidDocument: The profile makes no sense.
        """
        from rtkit.api.checking import compare
        from rtkit.rtc.enums import UNKNOWN_STATE, LifeCycleState

        wanted = None if state == UNKNOWN_STATE else LifeCycleState(state)
        document = load(profile, strict=strict)
        with self._session("check", document, strict=strict) as session:
            return compare(session, document, wanted, _mapped(hosts))

    def save(
        self,
        name: str = "RTSystem",
        *,
        version: str = "0",
        vendor: str = "Me",
        abstract: str = "RT System",
        servers: Sequence[str] = (),
        unconnected: bool = False,
    ) -> SystemProfile:
        """Return the live system as a profile: ``tree.save("Robot").write("robot.xml")``.

        Args:
            name: Of the system.
            version: Of the system.
            vendor: Who made it.
            abstract: In a few words.
            servers: Hosts, or managers of this host (``/localhost/m1.mgr``); none for all that
                this manager knows.
            unconnected: Also components without connections.
        """
        from rtkit.api.capturing import capture
        from rtkit.api.profiles import made

        about = (name, version, vendor, abstract)
        with ScriptSession(self, self.notify) as session:
            profile = capture(session, servers, about, takes_all=unconnected)
            return made(profile, f"{name} as it lives")

    def teardown(
        self, profile: Source, *, end: bool = False, hosts: Mapping[str, str] = NO_MAP
    ) -> None:
        """Remove every connection of a profile, with `end` its components too.

        What is missing goes to `notify`; the rest is removed all the same.

        Args:
            profile: The profile.
            end: Also end the components, in reverse order.
            hosts: See `plan`.
        """
        from rtkit.api.starting import teardown

        document = load(profile)
        with self._session("tear down", document) as session:
            teardown(session, document, _mapped(hosts), ends_components=end)

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
            port: Path of an out port: ``/localhost/Robot0.rtc:pose``.
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
            ports: Paths of out ports.
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
            port: Path of the port.
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
            Refused: It raised an exception.
            Unreachable: There was no answer in time.
        """
        from rtkit.api.calling import call

        return call(self, operation, arguments, self.timeout_s if timeout_s is None else timeout_s)

    # Observing

    @property
    def properties(self) -> Properties:
        """Live properties of components, managers, this host and served objects."""
        from rtkit.api.live import Properties

        return Properties(self)

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

        until = None if timeout_s is None else time.monotonic() + timeout_s
        chosen = logs.selected(level, sources, text, since_s)
        with ScriptSession(self, self.notify) as session:
            named = paths or (f"/localhost/{self.manager}.mgr",)
            tests = [logs.about(session, session.path(path)) for path in named]
            wanted = logs.all_of(chosen, lambda entry: any(test(entry) for test in tests))
            return begun(logs.follow(session, wanted, last, until, is_over=not follow))

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

    @contextmanager
    def _session(
        self, what: str, document: SystemProfile, *, strict: bool = False
    ) -> Iterator[ScriptSession]:
        name = f"script {what} {document.source}"
        with ScriptSession(self, self.notify, name, is_strict=strict) as session:
            yield session


def _aim(
    state: str, costs: Mapping[str, float], *, prune: bool, replace: bool, stand_in: bool
) -> GoalOptions:
    from rtkit.api.planning import STATES, GoalOptions, WayOptions

    if state not in STATES:
        raise ValueError(f"state is one of {', '.join(STATES)}, not {state!r}")
    given = tuple(f"{name}={cost!r}" for name, cost in costs.items())
    return GoalOptions(state, WayOptions(given, stand_in=stand_in, replaces=replace), prune)


def _mapped(hosts: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(f"{host}={other}" for host, other in hosts.items())


_FIRST = """
activate apply apply_profile bring_up call check close component configure connect create deactivate
delete disconnect events get host listing load logs ls manager notify plan properties read reset
save set snapshot start stop teardown timeout_s values wait write
"""
