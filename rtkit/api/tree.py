"""Tree of scripts: everything that commands do to a running system, as methods."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Unpack

from rtkit.api.data_tree import DataTree
from rtkit.api.options import NO_MAP, PlanKeywords, WayKeywords, known, request, takes
from rtkit.api.session import ScriptSession
from rtkit.api.system_profiles import Source, SystemProfile, load, with_hosts

if TYPE_CHECKING:
    from rtkit.api.checking import SystemReport
    from rtkit.api.plan import SystemPlan
    from rtkit.api.states import StatesReport
    from rtkit.tree.plan_locks import PlanLocks


class Tree(DataTree):
    """A connection to one manager, through which a system is looked at and changed.

    `rtkit.connect` makes it. A profile is a path or what `rtkit.load` returns; where it has
    components in other managers of this host, these are connected to, and started when needed.
    Every method is bounded by the time-out of the connection, or by one of its own [s]. Errors are
    those of `rtkit.errors`.

    Systems: `plan apply_profile bring_up start stop check save teardown`. Their states: `states
    goto follow unfollow`. Waiting: `wait`. Data: `read values write call`. Observing: `logs events
    live properties`. Components: `ls component create delete activate deactivate reset tick
    connect disconnect load`. Their parameters: `configure add_set copy_set remove_set
    activate_set`.

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

    @takes(PlanKeywords)
    def plan(self, profile: Source, **options: Unpack[PlanKeywords]) -> SystemPlan:
        """Return the cheapest plan from what lives to a profile; nothing is changed.

        Args:
            profile: Where it is to lead.
            state: State that every component is to be in: ``Active``, ``Inactive`` or ``Any``.
            prune: End the other components, and remove the other connections of its own.
            replace: End and replace what cannot be changed in place.
            costs: What kinds of steps cost, or interruptions of a component, by name.
            stand_in: Generate what is missing, without its modules.
            transmit: Stand-ins write values while active, and answer calls.
            hosts: Hosts of the profile that stand for others: ``{"10.0.0.7": "localhost"}``.
            strict: Take warnings for errors.

        Raises:
            Impossible: There is no plan; names the conditions that cannot hold together.
            InvalidDocument: The profile makes no sense; names file and line.
        """
        from rtkit.api import planning
        from rtkit.api.plan import SystemPlan

        aim, hosts, strict = request(**options)
        document = _loaded(profile, hosts, strict=strict)
        with self._session("plan", document, strict=strict) as session:
            prepared = planning.prepare(session, document, aim, is_dry=True)
        return SystemPlan(self, self.notify, document, prepared)

    @takes(PlanKeywords)
    def apply_profile(
        self,
        profile: Source,
        *,
        rollback: bool = False,
        parallel: int = 0,
        wait_s: float = 0.0,
        **options: Unpack[PlanKeywords],
    ) -> SystemPlan:
        """Make the live system what a profile says, by the cheapest plan, and return that plan.

        What holds already is not touched. Options are those of `plan`, and:

        Args:
            profile: The profile.
            rollback: When a step fails, go back to what was before.
            parallel: Most steps under way at once; 0 for no bound.
            wait_s: How long to wait for another plan at work at the manager [s].

        Raises:
            Impossible: There is no plan.
            Refused: A step failed, or somebody else is at work; tells what is left.
        """
        from rtkit.api import planning
        from rtkit.api.plan import SystemPlan, run

        aim, hosts, strict = request(**options)
        document = _loaded(profile, hosts, strict=strict)
        with self._locked("apply", document, wait_s, strict=strict) as (session, lock):
            prepared = planning.prepare(
                session, document, aim, is_dry=False, parallel=parallel, lock=lock
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
        from rtkit.api.starting import bring_up

        document = _loaded(profile, hosts)
        with self._locked("bring up", document, wait_s) as (session, lock):
            bring_up(
                session,
                document,
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
        from rtkit.api import starting, states

        document = _loaded(profile, hosts)
        plan_for = starting.start_plan_of(document, wait=wait)
        with self._session("start", document) as session:
            is_followed = states.is_follow_wanted(session, document)
            inputs = starting.prepare(session, document, plan_for)
            starting.carry_out(session, inputs, timeout_s)
            if is_followed:
                states.follow_now(session, document)

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

        document = _loaded(profile, hosts)
        with self._session("stop", document) as session:
            plan_for = starting.stop_plan_of(session, document, wait=wait)
            inputs = starting.prepare(session, document, plan_for, may_lack=True)
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

        word = known(state, [*LifeCycleState, UNKNOWN_STATE])
        wanted = None if word == UNKNOWN_STATE else LifeCycleState(word)
        document = _loaded(profile, hosts, strict=strict)
        with self._session("check", document, strict=strict) as session:
            return compare(session, document, wanted)

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
        from rtkit.api.system_profiles import made

        about = (name, version, vendor, abstract)
        with ScriptSession(self, self.notify) as session:
            profile = capture(session, servers, about, takes_all=unconnected)
            return made(profile, f"{name} as it lives")

    def teardown(
        self,
        profile: Source,
        *,
        end: bool = False,
        uninstall: bool = False,
        hosts: Mapping[str, str] = NO_MAP,
        wait_s: float = 10.0,
    ) -> None:
        """Remove every connection of a profile, with `end` its components too.

        What is missing goes to `notify`; the rest is removed all the same.

        Args:
            profile: The profile.
            end: Also end the components, in reverse order.
            uninstall: With `end`, also remove packages that plans installed for it alone.
            hosts: See `plan`.
            wait_s: How long to wait for another plan at work at the manager [s].

        Raises:
            Refused: Somebody else is at work, or it was broken off; the message tells how far.
        """
        from rtkit.api.starting import teardown

        document = _loaded(profile, hosts)
        with self._locked("tear down", document, wait_s) as (session, lock):
            teardown(session, document, ends_components=end, uninstalls=uninstall, lock=lock)

    # States of a system

    @takes(WayKeywords)
    def states(self, profile: Source, **options: Unpack[WayKeywords]) -> StatesReport:
        """Look in which of its states a system is; nothing is changed.

        Example::

            report = tree.states("robot.xml")
            print(report.now, report.names, report.events)

        Args:
            profile: A profile that tells states (``rtkit help states``); options as of `plan`.

        Raises:
            InvalidDocument: It tells none, or they make no sense.
        """
        from rtkit.api import states

        aim, hosts, strict = request(**options)
        document = _loaded(profile, hosts, strict=strict)
        with self._session("look at", document, strict=strict) as session:
            return states.look(session, document, aim.way)

    @takes(WayKeywords)
    def goto(
        self,
        profile: Source,
        state: str = "",
        *,
        event: str = "",
        rollback: bool = False,
        wait_s: float = 0.0,
        **options: Unpack[WayKeywords],
    ) -> None:
        """Lead a system to one of its states by the cheapest plan; what both ask for is kept.

        Args:
            profile: The profile, and options as of `plan`.
            state: Name of the state.
            event: Lead it to where this event of the present state leads, instead.
            rollback: When a step fails, go back to what was before.
            wait_s: See `apply_profile`.

        Raises:
            InvalidDocument: There is no such state or event.
            Impossible: There is no plan.
            Refused: It was not reached; tells what is left.
        """
        from rtkit.api import states

        aim, hosts, strict = request(**options)
        document = _loaded(profile, hosts, strict=strict)
        with self._locked("lead", document, wait_s, strict=strict) as (session, lock):
            report = states.look(session, document, aim.way, starts=True, lock=lock)
            target = report.target(state, event)
            states.lead(session, report, target, event, rolls_back=rollback)

    @takes(WayKeywords)
    def follow(
        self, profile: Source, *, rollback: bool = False, **options: Unpack[WayKeywords]
    ) -> None:
        """Have the manager lead a system wherever its events lead, from now on.

        It goes on without this connection, and after a restart of the manager, until `unfollow`,
        `teardown`, or a transition that fails. ``events(kinds=["SYSTEM_STATE"])`` tells of it.

        Args:
            profile: The profile, and options as of `plan`.
            rollback: When a step fails, go back to what was before.

        Raises:
            Refused: It is followed as another profile tells it, or is in several managers.
        """
        from rtkit.api import states

        aim, hosts, strict = request(**options)
        document = _loaded(profile, hosts, strict=strict)
        with self._session("follow", document, strict=strict) as session:
            states.check_one_manager(session, document)
            report = states.look(session, document, aim.way)
            states.follow(session, document, report.states, rolls_back=rollback)

    def unfollow(self, name: str) -> None:
        """Have the manager follow a system no more; a transition under way ends first.

        Args:
            name: Of the system, or its identity, ``RTSystem:Me:Robot:1.0``.

        Raises:
            NotFound: It is not followed.
        """
        from rtkit.api import states

        self.notify(states.unfollow(self, states.identity_of(self.snapshot(), name)))

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

    @contextmanager
    def _locked(
        self, what: str, document: SystemProfile, wait_s: float, *, strict: bool = False
    ) -> Iterator[tuple[ScriptSession, PlanLocks]]:
        """Yield a session, and the locks that keep others off from before its first look."""
        from rtkit.tree.plan_locks import PlanLocks

        with (
            self._session(what, document, strict=strict) as session,
            PlanLocks(session.name, wait_s, self.notify) as lock,
        ):
            yield session, lock


def _loaded(profile: Source, hosts: Mapping[str, str], *, strict: bool = False) -> SystemProfile:
    pairs = (f"{host}={other}" for host, other in hosts.items())
    return with_hosts(load(profile, strict=strict), pairs)


_FIRST = """
activate activate_set add_set answer apply apply_profile bring_up call check close component
configure connect copy_set create deactivate delete disconnect events follow get goto host led_to
listing live load logs ls manager notify plan properties read remove_set reset save set snapshot
start states stop stop_manager teardown tick timeout_s unfollow values wait write
"""
