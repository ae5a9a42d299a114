"""Tree of scripts: everything that commands do to a running system, as methods."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rtkit.api.data_tree import DataTree
from rtkit.api.profiles import Source, SystemProfile, load
from rtkit.api.script import ScriptSession
from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.api.checking import SystemReport
    from rtkit.api.plan import SystemPlan

NO_MAP: Mapping[str, Any] = {}


class Tree(DataTree):
    """A connection to one manager, through which a system is looked at and changed.

    `rtkit.connect` makes it. A profile is a path or what `rtkit.load` returns; where it has
    components in other managers of this host, these are connected to, and started when needed.
    Every method is bounded by the time-out of the connection, or by one of its own [s]. Errors are
    those of `rtkit.errors`.

    Systems: `plan apply_profile bring_up start stop check save teardown`. Waiting: `wait`. Data:
    `read values write call`. Observing: `logs events live properties`. Components: `ls component
    create delete activate deactivate reset connect disconnect configure load`.

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
        transmit: bool = False,
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
            transmit: Stand-ins write values while active.
            hosts: Hosts of the profile that stand for others: ``{"10.0.0.7": "localhost"}``.
            strict: Take warnings for errors.

        Raises:
            Impossible: There is no plan; names the conditions that cannot hold together.
            InvalidDocument: The profile makes no sense; names file and line.
        """
        from rtkit.api import planning
        from rtkit.api.plan import SystemPlan

        way = planning.WayOptions(_texts(costs), planning.MEASURED, stand_in, transmit, replace)
        aim = planning.GoalOptions(_known(state, planning.STATES), way, prune)
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
        transmit: bool = False,
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
            transmit: See `plan`.
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

        way = planning.WayOptions(_texts(costs), planning.MEASURED, stand_in, transmit, replace)
        aim = planning.GoalOptions(_known(state, planning.STATES), way, prune)
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
        transmit: bool = False,
        hosts: Mapping[str, str] = NO_MAP,
        wait_s: float = 0.0,
    ) -> None:
        """Create, connect and configure what is missing of a profile; activate nothing.

        What is there is left as it is. If something required fails, what was made is removed.

        Args:
            profile: The profile.
            create: Whether missing components are created, or an error.
            stand_in: See `plan`.
            transmit: See `plan`.
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
            bring_up(
                session,
                document,
                _mapped(hosts),
                may_create=create,
                stand_in=stand_in,
                transmit=transmit,
                lock=lock,
            )

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

        word = _known(state, [*LifeCycleState, UNKNOWN_STATE])
        wanted = None if word == UNKNOWN_STATE else LifeCycleState(word)
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

    def stop_manager(self, *, keep: bool = False) -> None:
        """End the manager with all its slaves; return when its process has ended.

        Args:
            keep: Whether its next start makes again what it holds.

        Raises:
            Unreachable: It does not run, or did not end in time.
        """
        from rtkit.tree.managers import stop

        stop(self.manager, self.timeout_s, is_kept=keep)

    @contextmanager
    def _session(
        self, what: str, document: SystemProfile, *, strict: bool = False
    ) -> Iterator[ScriptSession]:
        name = f"script {what} {document.source}"
        with ScriptSession(self, self.notify, name, is_strict=strict) as session:
            yield session


def _known(state: str, words: Sequence[str]) -> str:
    """Return a state as it is written; it may be given in any case."""
    for word in words:
        if word.casefold() == state.casefold():
            return word
    raise Malformed(f"state is one of {', '.join(words)}, not {state!r}")


def _texts(costs: Mapping[str, float]) -> tuple[str, ...]:
    return tuple(f"{name}={cost!r}" for name, cost in costs.items())


def _mapped(hosts: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(f"{host}={other}" for host, other in hosts.items())


_FIRST = """
activate apply apply_profile bring_up call check close component configure connect create
deactivate delete disconnect events get host listing live load logs ls manager notify plan
properties read reset save set snapshot start stop stop_manager teardown timeout_s values wait write
"""
